"""The materials of a glTF asset as a document.

* `asset_materials`: each material as a node of gltf_pbr, over `textures` (their image files and how they are looked up)
  and `texture_graph` (their nodes).
* `locations`: where in the asset's JSON something stands.
"""
