"""Options of OpenMATERIAL: whose R_A is written, at which angles, and into what."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path  # noqa: TC003  the annotations are read at run time
from typing import Annotated

from mrm_mtlx.formats.openmaterial.block import Geometry
from mrm_mtlx.formats.options import Option, Options
from mrm_mtlx.system.arguments import ArgumentError


@dataclass(frozen=True)
class OpenMaterialOptions(Options):
    """Options of writing a block, and of comparing with one.

    Raises
    ------
    ArgumentError
        If an angle is out of range, or an object is named and no file.
    """

    into: Annotated[Path | None, Option("FILE", "An OpenMATERIAL file whose other data are kept.")] = None
    at: Annotated[str | None, Option("POINTER", "Object of --into for a new block, as /parent. Default: the top.")] = (
        None
    )
    observation: Annotated[float | None, Option("DEG", "Observation angle of R_A. Default: 0.2.")] = None
    entrance: Annotated[float | None, Option("DEG", "Entrance angle of R_A. Default: -4.")] = None
    element: Annotated[str | None, Option("NAME", "Element whose R_A it is; default: the first.")] = None

    def __post_init__(self) -> None:
        """Check the values."""
        if self.at is not None and self.into is None:
            msg = "only with `into`, whose objects it names"
            raise ArgumentError(msg, "at")
        for argument, value, lower in (("observation", self.observation, 0.0), ("entrance", self.entrance, -90.0)):
            if value is not None and not lower <= value <= 90.0:
                msg = f"{value:g}: expected {lower:g} to 90 degrees"
                raise ArgumentError(msg, argument)

    def geometry(self, stated: Geometry | None = None) -> Geometry:
        """The angles that are given, else those that a file states, else the usual ones."""
        default = stated or Geometry()
        return Geometry(
            default.observation_deg if self.observation is None else self.observation,
            default.entrance_deg if self.entrance is None else self.entrance,
        )
