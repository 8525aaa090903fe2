"""The materials of a document as a stage.

* `stage_file`: a layer or a package, with the images.
* `material_prims`: the materials as its prims, over `scope` (what lies beside each other in one).
"""
