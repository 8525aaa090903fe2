"""USD: materials of a stage as a document, and a document's materials as a stage.

* `reading`: a stage's materials, in all variants, over `network` (one material), `versions` (of MaterialX), `prims` and
  `assets` (files).
* `opening`: safe opening of untrusted files, over `layers` (one file), `packages`, `crates` (what one claims to hold,
  over `crate_values` and `crate_packing`), `documents` (of MaterialX), `weighing` (how large the stage will be),
  `standins` (what is not opened).
* `validators`: what USD's own validators say; `texts`: what USD says, as it is shown.
* `writing`: a document's materials as prims, over `scope` (what is beside each other); `saving`: their file.
* `values`: types, values and colour spaces.
"""

from mrm_mtlx.formats.usd.exporter.saving import names, write
from mrm_mtlx.formats.usd.importer.reading import read

__all__ = ["names", "read", "write"]
