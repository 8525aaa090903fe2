"""Bounds of what is read. A document beyond them is not malformed, but nothing in it is worth an unbounded wait."""

# Of a document with all that it includes.
MAXIMUM_DOCUMENT_BYTES = 16 * 2**20
MAXIMUM_XML_DEPTH = 64
MAXIMUM_INCLUDES = 64

# Nodes that a surface is made of, with those inside of the graphs that define nodes, as often as each is used. Of
# MaterialX's examples, OpenPBR's and the corpus of the tests none comes to more than 1,400 in all its surfaces
# together; a node of the libraries comes to 270 at most. A graph of 20,000 takes MaterialX a minute to flatten.
MAXIMUM_NODES = 20_000
