"""Options of USD: whether materials get a look for hosts without MaterialX."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from mrm_mtlx.formats.options import Option, Options


@dataclass(frozen=True)
class UsdOptions(Options):
    """Options of writing a stage."""

    preview: Annotated[
        bool | None, Option("", "Add the look by day as UsdPreviewSurface, for hosts without MaterialX. Default: yes.")
    ] = None

    @property
    def has_preview(self) -> bool:
        """Whether it is added."""
        return self.preview is not False
