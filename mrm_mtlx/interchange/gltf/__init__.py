"""glTF 2.0: materials with KHR_materials_retroreflection and the extensions that MaterialX's gltf_pbr knows.

* `container`: the file, its JSON and its buffers; `schema`: the JSON schemas that objects are held against.
* `properties`: which property of glTF is which input of gltf_pbr, for both directions.
* `reading`, `textures`: an asset as a document; `writing`, `terms`, `closures`, `mesh`: a document as an asset.
"""

from mrm_mtlx.interchange.gltf.reading import read
from mrm_mtlx.interchange.gltf.writing import write

__all__ = ["read", "write"]
