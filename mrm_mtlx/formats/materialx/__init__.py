"""MaterialX's own XML: `importer` reads it with what it includes, `exporter` writes it with the files that it names."""

from mrm_mtlx.formats.materialx.exporter import names, write
from mrm_mtlx.formats.materialx.importer import read

__all__ = ["names", "read", "write"]
