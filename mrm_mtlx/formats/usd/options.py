"""Options of USD: whether materials get a look for hosts without MaterialX."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from mrm_mtlx.formats.options import Option, Options
from mrm_mtlx.system.arguments import check_flag


@dataclass(frozen=True)
class UsdOptions(Options):
    """Options of writing a stage.

    Raises
    ------
    ArgumentError
        If one is no truth value.
    """

    preview: Annotated[
        bool | None, Option("", "Add the look by day as UsdPreviewSurface, for hosts without MaterialX. Default: yes.")
    ] = None

    def __post_init__(self) -> None:
        """Check the value."""
        check_flag("preview", self.preview)

    @property
    def has_preview(self) -> bool:
        """Whether it is added."""
        return self.preview is not False
