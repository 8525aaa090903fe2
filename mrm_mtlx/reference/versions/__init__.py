"""Numbers of MaterialX's shaders that no paper has, by version of MaterialX.

`NUMBERS` says which version uses which: a version that differs gets a module beside `materialx_1_39_5` with its
`Numbers` (those of another version with `dataclasses.replace`, where it shares most), and a line here. A fit of another
form is a class in `fits`.
"""

from functools import cache

from mrm_mtlx.library import dialects
from mrm_mtlx.reference.versions import materialx_1_39_5
from mrm_mtlx.reference.versions.numbers import Numbers

NUMBERS = {"1.39.0": materialx_1_39_5.NUMBERS}


@cache
def installed() -> Numbers:
    """The numbers of the installed MaterialX.

    Raises
    ------
    LookupError
        If it is older than every version in `NUMBERS`.
    """
    return dialects.entry(NUMBERS, dialects.materialx_version())


__all__ = ["NUMBERS", "Numbers", "installed"]
