"""Numbers and forms of MaterialX's shaders that no paper has, by version of MaterialX.

`NUMBERS` says which version uses which: a version that differs gets a module beside `materialx_1_39_5` with its
`Numbers` (those of another version with `dataclasses.replace`, where it shares most), and a line here. A fit of another
form is a class in `fits`; a formula that versions write in several ways is a function for each (`combination`,
`fresnel_average`).
"""

from functools import cache

from mrm_mtlx.library import dialects
from mrm_mtlx.reference.versions import materialx_1_39_0, materialx_1_39_5, materialx_1_39_6
from mrm_mtlx.reference.versions.numbers import Numbers

NUMBERS = {
    "1.39.0": materialx_1_39_0.NUMBERS_1_39_0,
    "1.39.3": materialx_1_39_0.NUMBERS_1_39_3,
    "1.39.4": materialx_1_39_0.NUMBERS_1_39_4,
    "1.39.5": materialx_1_39_5.NUMBERS,
    "1.39.6": materialx_1_39_6.NUMBERS,
}


def of(version: str) -> Numbers:
    """The numbers of a version of MaterialX.

    Raises
    ------
    LookupError
        If it is older than every version in `NUMBERS`.
    """
    return dialects.entry(NUMBERS, version)


@cache
def installed() -> Numbers:
    """The numbers of the installed MaterialX.

    Raises
    ------
    LookupError
        If it is older than every version in `NUMBERS`.
    """
    return of(dialects.materialx_version())


__all__ = ["NUMBERS", "Numbers", "installed", "of"]
