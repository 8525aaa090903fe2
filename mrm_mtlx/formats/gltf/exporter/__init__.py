"""The materials of a document as a glTF asset.

* `document_materials`: all of them, read back and compared by `comparison`.
* `pbr_inputs`: a surface in the inputs of gltf_pbr: its own, those of another surface model (`surface_models`), or
  those that its BSDF nodes come nearest to (`bsdf_surfaces`).
* `terms`: an input as a number times an image, over `value_sources` (what it is connected to) and `placement` (where
  the image is read).
* `material`: factors and textures of these, over `texture_slots` (their images); `asset`: the files.
"""
