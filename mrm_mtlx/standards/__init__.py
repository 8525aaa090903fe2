"""Minima and colour boxes of the standards, with their sources."""

from mrm_mtlx.standards.quantities import Quantity
from mrm_mtlx.standards.tables import Box, Limit, boxes, limits, standards

__all__ = ["Box", "Limit", "Quantity", "boxes", "limits", "standards"]
