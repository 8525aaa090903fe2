"""Data of reports, as JSON can hold them."""

from __future__ import annotations

from typing import Any


def finite(value: Any) -> Any:
    """A report's data with NaN and infinity, which JSON does not have, as None; tuples become lists."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, float) and not abs(value) < float("inf"):
        return None
    return value
