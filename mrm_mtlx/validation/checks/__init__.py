"""Checks of a document's structure, by subject."""
