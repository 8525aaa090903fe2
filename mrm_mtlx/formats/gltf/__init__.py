"""glTF 2.0: materials with KHR_materials_retroreflection and the extensions that MaterialX's gltf_pbr knows.

* `container`: the file, its JSON and its buffers; `schema`: the JSON schemas that objects are held against.
* `properties`: which property of glTF is which input of gltf_pbr, for both directions.
* `reading`, over `textures` and `graph`: an asset as a document.
* `writing`: a document as an asset. `inputs` has a surface as inputs of gltf_pbr, over `closures` and `models`; each is
  one of `terms`, whose nodes are found by `interfaces` and whose image lies by `placement`; `material` and `slots` make
  factors and textures of them, `asset` the files, and `comparison` says how far they are from the document.
"""

from mrm_mtlx.formats.gltf.exporter.writing import names, write
from mrm_mtlx.formats.gltf.importer.reading import read

__all__ = ["names", "read", "write"]
