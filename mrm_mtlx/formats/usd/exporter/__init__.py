"""The materials of a document as a stage.

* `stage_file`: a layer or a package, with the images.
* `material_prims`: the materials as its prims, over `shadergen.usd`, which writes one.
* `preview`: their looks by day for hosts without MaterialX.
"""
