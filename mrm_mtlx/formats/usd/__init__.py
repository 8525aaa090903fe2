"""USD: materials of a stage as a document, and a document's materials as a stage.

* `opening`: untrusted files as a stage that opens no other.
* `importer`: a stage's materials as a document.
* `exporter`: a document's materials as a stage.

They share `prims` (which of a material are MaterialX's) and `messages` (what USD says, as it is shown), and with
`shadergen.usd`, which writes single materials, its `values`.
"""

from mrm_mtlx.formats.usd.exporter.stage_file import names, write
from mrm_mtlx.formats.usd.importer.stage_materials import read

__all__ = ["names", "read", "write"]
