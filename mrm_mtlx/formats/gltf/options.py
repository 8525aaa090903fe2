"""Options of glTF: whether what it has no form for is approximated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from mrm_mtlx.formats.options import Option, Options
from mrm_mtlx.system.arguments import check_flag


@dataclass(frozen=True)
class GltfOptions(Options):
    """Options of writing an asset.

    Raises
    ------
    ArgumentError
        If one is no truth value.
    """

    exact: Annotated[
        bool | None, Option("", "Leave out what glTF has no form for; default: the nearest is written.")
    ] = None

    def __post_init__(self) -> None:
        """Check the value."""
        check_flag("exact", self.exact)
