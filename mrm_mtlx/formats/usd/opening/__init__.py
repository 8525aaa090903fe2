"""Untrusted stages, opened safely: `stage`, over all the others."""
