"""Quantities that the standards have minima of."""

from __future__ import annotations

from enum import StrEnum


class Quantity(StrEnum):
    """What a minimum is of, by its symbol: of a material, of a whole reflector, or of a strip over its inner radius."""

    R_A = "R_A"
    R_L = "R_L"
    R_I = "R_I"
    R_I_OVER_R = "R_I/r"

    @property
    def subject(self) -> str:
        """The subject of colour boxes for what is measured by it, where its standard has none of its own."""
        return "pavement marking" if self is Quantity.R_L else "sheeting"

    @property
    def is_turned(self) -> bool:
        """True if it is measured at several rotations: sheeting is, reflectors and markings stand as mounted."""
        return self is Quantity.R_A

    @property
    def needs_area(self) -> bool:
        """True if it is of a body with an area, and not of a material."""
        return self in (Quantity.R_I, Quantity.R_I_OVER_R)

    @property
    def needs_radius(self) -> bool:
        """True if it is of a strip with a radius."""
        return self is Quantity.R_I_OVER_R
