"""Colour spaces by the names that documents have for them, as MaterialX's generators take these names.

Generators convert colours to linear Rec.709 with MaterialX's default colour management: by the nodes of its library for
the names that it knows, and not at all for others. OpenColorIO's built-in configurations have more names; some are of
spaces that MaterialX knows by another.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from mrm_mtlx.library.load import definitions_for

LINEAR = "lin_rec709"

# Other names that MaterialX's default colour management takes (COLOR_SPACE_REMAP of DefaultColorManagementSystem.cpp,
# which Python cannot ask for): those of MaterialX before 1.36, and those of the Color Interop Forum.
_RENAMED = {
    "gamma18": "g18_rec709",
    "gamma22": "g22_rec709",
    "gamma24": "rec709_display",
    "lin_ap1": "acescg",
    "lin_ap1_scene": "acescg",
    "lin_rec709_scene": LINEAR,
    "lin_p3d65_scene": "lin_displayp3",
    "lin_adobergb_scene": "lin_adobergb",
    "srgb_rec709_scene": "srgb_texture",
    "g22_rec709_scene": "g22_rec709",
    "g18_rec709_scene": "g18_rec709",
    "g22_ap1_scene": "g22_ap1",
    "srgb_p3d65_scene": "srgb_displayp3",
    "g22_adobergb_scene": "adobergb",
}

# OpenColorIO's built-in configuration with the most spaces.
_CONFIGURATION = "ocio://studio-config-latest"


def canonical(space: str) -> str:
    """The name under which MaterialX's library has a colour space; the name itself if it has no other."""
    return _RENAMED.get(space, space)


def is_linear(space: str) -> bool:
    """True for a colour space whose numbers MaterialX uses as they are."""
    return canonical(space) in ("", "none", LINEAR)


def is_handled(document: Any, space: str) -> bool:
    """True if generators take colours of a space as is meant: by a transform, or rightly as they are."""
    known = is_linear(space) or color_transform(document, space) is not None
    return known or is_linear(equivalent(document, space) or space)


def color_transform(document: Any, space: str) -> Any:
    """The node definition by which generators take colours of a space to linear Rec.709, or None.

    With None the numbers are used as they are, whether or not that is meant; see `is_handled`.
    """
    definitions = definitions_for(document).getMatchingNodeDefs(f"{canonical(space)}_to_{LINEAR}")
    return next((d for d in definitions if d.getType() == "color3"), None)


def equivalent(document: Any, space: str) -> str:
    """MaterialX's name of a space that OpenColorIO names otherwise, such as "Raw"; "" if it has none."""
    names = in_opencolorio(space)
    return next((n for n in names if n and (is_linear(n) or color_transform(document, n) is not None)), "")


@cache
def in_opencolorio(space: str) -> tuple[str, ...]:
    """All names that OpenColorIO's built-in configurations have for a colour space, its own first; none if unknown."""
    import OpenImageIO as oiio

    configuration = oiio.ColorConfig(_CONFIGURATION)
    name = str(configuration.resolve(space))
    if name not in configuration.getColorSpaceNames():
        return ()
    return (name, *(str(alias) for alias in configuration.getAliases(name)))
