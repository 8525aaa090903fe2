"""Formats of materials: what of a document they can say, and what they say of it.

* `formats`: the table of those that are translated from and into MaterialX documents, by the ending of a file's name.
* `imported`: what a reader returns.
* `openmaterial`: the coefficient of retroreflection of ASAM OpenMATERIAL 3D.
"""
