"""The materials of a document as a glTF asset.

* `document_materials`: all of them, read back and compared with what they were made of.
* `material`: the inputs of gltf_pbr (`formats.pbr`) as factors and textures, over `texture_slots` (their images) and
  `ranges`.
* `asset`: the files.
"""
