"""ASAM OpenMATERIAL 3D: the R_A of a material, one number.

* `block`: where that number stands in a file.
* `options`: whose R_A, and at which angles.
* `translation`: documents evaluated (by `reference`, over `photometry`) to write the number and to compare with it, and
  the number as what a material is to be fitted to.
"""
