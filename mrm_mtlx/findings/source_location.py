"""Places in files."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SourceLocation:
    """A place in a file; plain data that crosses processes.

    Attributes
    ----------
    file
        The file as reports show it, never absolute: the document, one that it includes, or one of a stage.
    line, column
        Counted from 1, the column in characters; None where they are not known.
    pointer
        JSON pointer (RFC 6901), in a glTF asset; "" is the asset as a whole.
    layer, prim
        In a stage: the layer, which in a package is "package.usdz[layer.usda]", and the path of the prim or property
        there; "" is the stage as a whole.
    """

    file: str
    line: int | None = None
    column: int | None = None
    pointer: str | None = None
    layer: str | None = None
    prim: str | None = None

    def __str__(self) -> str:
        """As compilers write it, "file:line:column", as far as that is known."""
        return ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)

    def within(self, file: str) -> str:
        """The same for a reader of what is said of a file, whose own name is left out: "line:column"."""
        return str(self).removeprefix(self.file).removeprefix(":") if self.file == file else str(self)

    def to_json(self) -> dict[str, str | int | None]:
        """The keys of a finding in reports (docs/report.schema.json); those of other formats are left out."""
        others = {"pointer": self.pointer, "layer": self.layer, "prim": self.prim}
        said = {name: value for name, value in others.items() if value is not None}
        return {"file": self.file, "line": self.line, "column": self.column, **said}
