"""glTF 2.0: materials with KHR_materials_retroreflection and the extensions that MaterialX's gltf_pbr knows.

Both directions share

* `container`: an untrusted file, its JSON and its buffers; `schema`: the JSON schemas that objects are held against;
  `image_kinds`: the image files that it may name.
* `properties`: which property of glTF is which input of gltf_pbr.

`importer` makes a document of an asset's materials. `exporter` makes an asset of a document's materials. It evaluates
them with `mrm_mtlx.reference`: to find constants in their graphs, and to say how far the asset is from the document.
"""

from mrm_mtlx.formats.gltf.exporter.document_materials import names, write
from mrm_mtlx.formats.gltf.importer.asset_materials import read

__all__ = ["names", "read", "write"]
