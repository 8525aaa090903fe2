"""Values, names and files that programs trip over."""

NUMBERS = (
    "nan", "inf", "-inf", "1e999", "-1e308", "1e-320", "0", "-0", "-1", "1", "2", "0.5", "255", "65536", "2147483647",
    "2147483648", "-2147483649", "99999999999999999999", "0x10", "1,5", "1.5.2", "", " ", "1e", "--1", "+1", ".5", "1.",
    "true", "false", "True", "0.1, 0.2", "0.1, 0.2, 0.3", "0.1,0.2,0.3,0.4", "0.1 0.2 0.3", "0.1, nan, 0.3", "1;2;3",
    "{0.1;2}", "{{1;2};{3;4}}", "1, 0, 0, 0, 1, 0, 0, 0, 1", "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1", "1, , 2", ",", "\u0663",
    "1" * 400, "0." + "3" * 300, "1, " * 400 + "1",
)  # fmt: skip
NAMES = (
    "", " ", "a b", "a/b", "/a", "..", ".", "a:b", "a.b", "a|b", "é", "\u202e", "\u0085", "\u2028", "\u200b", "__",
    "_", "0a", "main", "float", "int", "vec3", "N", "out", "m", "s", "bsdf", "mix", "image", "surfaceshader", "a&b",
    "<", ">", "'", "%s%n", "${x}", "{0}", "\\", "x" * 300, "gl_FragColor", "surface", "retroreflective",
    "ND_standard_surface_surfaceshader", "NG_standard_surface_surfaceshader_100", "IM_mix_bsdf_genglsl",
)  # fmt: skip
TYPES = (
    "float", "integer", "boolean", "string", "filename", "color3", "color4", "vector2", "vector3", "vector4",
    "matrix33", "matrix44", "BSDF", "EDF", "VDF", "surfaceshader", "volumeshader", "displacementshader",
    "lightshader", "material", "multioutput", "floatarray", "stringarray", "integerarray", "color3array", "geomname",
    "none", "", "nonsense", "Float", "my_type",
)  # fmt: skip
# What the folder of a mutant holds, and what it does not.
FILES = (
    "i.png", "i.jpg", "i.exr", "i.hdr", "i.tif", "parts/i.png", "i.<UDIM>.png", "i.<UVTILE>.png", "<UDIM>",
    "i.1001.png", "missing.png", "part.mtlx", "code.glsl", "code.osl", "../outside/secret.png",
    "../outside/secret.mtlx", "/etc/hostname", "link.png", "loop.png", "pipe.png", "a\\i.png", "parts\\i.png",
    "C:\\i.png", "file:///etc/hostname", "http://localhost/i.png", "", ".", "..", "/", "~/i.png", "parts",
    "parts/../i.png", "./i.png", "i.png/", "i.png/i.png", "x" * 300 + ".png", "é.png", "i%2Epng", "m.mtlx", "i.usda",
    "p.usdz[i.png]", "{frame}.png", "<f>", "i.####.png", "%04d.png", "\u202egnp.i",
)  # fmt: skip
COLOR_SPACES = (
    "srgb_texture", "lin_rec709", "lin_rec709_scene", "gamma18", "gamma22", "gamma24", "g22_ap1", "acescg",
    "lin_ap1", "lin_displayp3", "srgb_displayp3", "adobergb", "lin_adobergb", "Raw", "raw", "none", "auto",
    "ACES2065-1", "nonsense", "", "sRGB", "data",
)  # fmt: skip
UNITS = ("meter", "inch", "micron", "degree", "radian", "nonsense", "", "lightyear")
