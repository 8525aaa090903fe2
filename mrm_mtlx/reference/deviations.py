"""Known deviations of MaterialX's hardware code from its specification.

The reference follows the specification. So that a comparison can tell a known deviation from an unknown error, the
reference can be asked to deviate in the same way, by name; docs/upstream-notes.md has each with the smallest document
that shows it and the measured difference. Some are no part of the reference: there the document or the source is
mended, and has to be right then (validation.mending).
"""

from __future__ import annotations

from enum import Enum


class Deviation(Enum):
    """A known deviation; the value is its name in reports and in docs/upstream-notes.md.

    `PREMULTIPLIED_MIX`: generators write a mixture of BSDFs whose amount is connected as the sum of both with their
    weights multiplied. The response is the same. The throughput is not where one of the two is opaque at any weight, or
    has none: it is lost, and what lies below in a layer with it.

    `LOWP_SAMPLERS`: samplers of generated ESSL have the language's default precision, lowp, so that colours of images
    may be off by 2^-8 (GLSL ES 3.00, section 4.5.4).

    `MEDIUMP_FLOATS`: floats of generated ESSL are mediump before MaterialX 1.39.5, of which a driver may take 16 bits;
    no narrow lobe is left then, and most give NaN.

    `MEDIUMP_INTEGERS`: integers of generated ESSL have the language's default precision, mediump, and may have 16 bits
    where the hash of every noise needs 32.

    `SHARED_NAMES`: nodes of one name in two graphs, whose inputs of one name share a uniform; likewise names of files
    in interfaces of graphs inside of each other, where each has its colours transformed.

    `INTERFACE_COLOR_SPACE`: the colour space of a value that an input of a graph holds is passed over.

    `OUTPUT_ORDER`: the outputs of a graph that defines a node are taken by their place, not by their names.

    `HEXAGON_ROOT`: `hexagon` asks whether the root of a number is above 0, also of a negative one, of which GLSL says
    nothing.

    `BLACK_MATERIALS`: a node of type material that a graph defines is black.

    `SIX_DECIMALS`: numbers inside of a graph are written into the source with six decimals; 0.00277778 is 0.002778.

    `UNMIXED_ZERO`: `burn` and `dodge` give 0 where they would divide by 0, also where their `mix` hides the effect.

    `HAIR_CONSTANTS`: hair is divided by pi once too often and, to MaterialX 1.39.5, its residual lobe has pi / 2 for
    1 / (2 pi).

    `COMBINED_THROUGHPUT`: what lies below a sum of BSDFs, a product or a layer stack is too bright in MaterialX 1.39.3,
    and too dark before; below a BSDF over a medium, too bright in 1.39.3 and 1.39.4.

    `IGNORED_MEDIA`: volumes absorb nothing before MaterialX 1.39.5.

    `VERTICAL_RAMPS`: `ramptb` and `splittb` are upside down before MaterialX 1.39.5.

    `HSV_ALPHA`: before MaterialX 1.39.5, `rgbtohsv` and `hsvtorgb` of four channels have an alpha of 1.

    `HEXTILE_ALPHA`: before MaterialX 1.39.5, the alpha of `hextiledimage` is the mean of that of its three tiles.

    `BLACK_BOOLEANS`: an output of type boolean is black before MaterialX 1.39.5.

    `MATRIX_PRODUCTS`: before MaterialX 1.39.4, `multiply` of matrices takes its factors in the other order, and
    `divide` divides entry by entry.

    `UNDECLARED_BLOCK`: Vulkan GLSL names a block that it does not declare before MaterialX 1.39.4; nothing compiles.

    `DEFAULT_COLORS`: generators take the default colours of a node definition as linear Rec.709, whatever the colour
    space of the file that defines it.
    """

    PREMULTIPLIED_MIX = "premultiplied-mix"
    LOWP_SAMPLERS = "lowp-samplers"
    MEDIUMP_FLOATS = "mediump-floats"
    MEDIUMP_INTEGERS = "mediump-integers"
    SHARED_NAMES = "shared-names"
    INTERFACE_COLOR_SPACE = "interface-color-space"
    OUTPUT_ORDER = "output-order"
    HEXAGON_ROOT = "hexagon-root"
    BLACK_MATERIALS = "black-materials"
    SIX_DECIMALS = "six-decimals"
    UNMIXED_ZERO = "unmixed-zero"
    HAIR_CONSTANTS = "hair-constants"
    COMBINED_THROUGHPUT = "combined-throughput"
    IGNORED_MEDIA = "ignored-media"
    VERTICAL_RAMPS = "vertical-ramps"
    HSV_ALPHA = "hsv-alpha"
    HEXTILE_ALPHA = "hextile-alpha"
    BLACK_BOOLEANS = "black-booleans"
    MATRIX_PRODUCTS = "matrix-products"
    UNDECLARED_BLOCK = "undeclared-block"
    DEFAULT_COLORS = "default-colors"
