"""Bounds of what is read. A document beyond them is not malformed, but nothing in it is worth an unbounded wait."""

# Of a document with all that it includes.
MAXIMUM_BYTES = 16 * 2**20
MAXIMUM_XML_DEPTH = 64
MAXIMUM_INCLUDES = 64
