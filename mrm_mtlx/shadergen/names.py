"""Names of shaders: generators write the one that they are given as it is, be it a word of the language or not."""

from __future__ import annotations

import re

import MaterialX as mx

# Words that a shader cannot have for its name, by target; in others the name does not appear.
_WORDS = {
    # Those of OSL, reserved ones with them, and what the OSL of MaterialX defines as macros.
    "osl": """
        and bool break case catch char class closure color const continue default delete do double else emit enum extern
        false float for friend goto if illuminance illuminate inline int long matrix new normal not operator or output
        point private protected public return short signed sizeof static string struct switch template this throw true
        try typedef uniform union unsigned varying vector virtual void volatile while
        BSDF EDF MATERIAL M_FLOAT_EPS M_PI VDF displacementshader lightshader surfaceshader volumeshader
        """,
    # MDL 1.9.2, section 5.3, but the types that end in numbers.
    "mdl": """
        annotation auto bool break bsdf bsdf_measurement case cast catch char class color const const_cast continue
        declarative default delete do double dynamic_cast edf else enum explicit export extern external false float for
        foreach friend goto graph hair_bsdf half if import in inline inout int intensity_mode intensity_power
        intensity_radiant_exitance lambda let light_profile long material material_emission material_geometry
        material_surface material_volume mdl module mutable namespace native new operator out package phenomenon private
        protected public reinterpret_cast return sampler shader short signed sizeof static static_cast string struct
        struct_category switch technique template texture_2d texture_3d texture_cube texture_ptex this throw true try
        typedef typeid typename uniform union unsigned using varying vdf virtual void volatile wchar_t while
        """,
}
_PATTERNS = {
    "osl": re.compile(r"__[A-Z_]+__"),  # the preprocessor's own
    "mdl": re.compile(r"(bool|int|float|double|half)[2-4](x[2-4])?"),
}


def shader_name(name: str, target: str) -> str:
    """The name that the shader of an element has: its own, with a number where the target has another use for it."""
    valid = str(mx.createValidName(name))
    taken = target in _WORDS and (valid in _WORDS[target].split() or _PATTERNS[target].fullmatch(valid))
    return f"{valid}1" if taken else valid
