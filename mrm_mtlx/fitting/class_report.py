"""The fit of a material to the minima of a class: plain data, and the same as text."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from mrm_mtlx.fitting.classes import MATERIALS, ClassMaterial, document
from mrm_mtlx.fitting.performance import MARGIN, Met, meet
from mrm_mtlx.standards import limits
from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.shown import Shown

if TYPE_CHECKING:
    from mrm_mtlx.standards import Limit


@dataclass(frozen=True, repr=False)
class ClassFit(Shown):
    """A material that meets a class.

    Attributes
    ----------
    material
        What it is made of.
    limits
        The minima of its class.
    values
        What it has where the class has minima, in their order and units.
    document
        The text of its MaterialX document.
    met
        Its parameters.
    """

    material: ClassMaterial
    limits: tuple[Limit, ...]
    values: tuple[float, ...]
    document: str
    met: Met = field(repr=False)

    def report(self) -> str:
        """Minima and values, and the verdict."""
        first = self.limits[0]
        lines = [
            f"{'observation':>12}{'entrance':>10}{'minimum':>12}{'of the fit':>12}  {first.quantity} {first.unit}",
            *(
                f"{limit.observation_deg:>12g}{limit.entrance_deg:>10g}{limit.minimum:>12g}{value:>12.4g}"
                for limit, value in zip(self.limits, self.values, strict=True)
            ),
        ]
        over = float(min(self.met.ratios)) * MARGIN - 1.0
        verdict = f"FITTED  {len(self.limits)} minima met by {over:.1%}, share {self.met.share:.3f}"
        return "\n".join([*lines, "", verdict])


def fit_class(class_name: str | None, color: str | None, standard: str | None) -> ClassFit:
    """The material that meets a class, by the names that choose it (`standards.limits`).

    Raises
    ------
    ArgumentError
        If there is no such class, or it is not known what a material of it is made of.
    """
    wanted = limits(class_name, color, standard=standard)
    material = next((material for material in MATERIALS if material.limits() == wanted), None)
    if material is None:
        known = ", ".join(f"{m.standard} {m.class_name} {m.colour}" for m in MATERIALS)
        msg = f"what a material of this class is made of is not known here; known are: {known}"
        raise ArgumentError(msg, "class_name")
    met = meet(wanted, material.make)
    values = [float(ratio * limit.minimum) for limit, ratio in zip(wanted, met.ratios * MARGIN, strict=True)]
    return ClassFit(material, tuple(wanted), tuple(values), document(material, met), met)
