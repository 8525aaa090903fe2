"""Other formats of materials: what of a document they can say, and what they say of it.

* `openmaterial`: the coefficient of retroreflection of ASAM OpenMATERIAL 3D.
"""
