"""Stages of USD, and what does not go through from one format to another."""

from __future__ import annotations

from mrm_mtlx.findings.finding import Rule, Severity

INTERCHANGE_LOST = Rule(
    "INTERCHANGE_LOST",
    Severity.WARNING,
    "not carried over into another format",
    "The file says something that the other format has no form for: an animated value has one value in "
    "MaterialX, a look of MaterialX has no place in a USD material. What is checked or written is without it.",
    "Nothing is wrong with the file; do not rely on what is named in the other format.",
)

INTERCHANGE_INVALID = Rule(
    "INTERCHANGE_INVALID",
    Severity.ERROR,
    "file breaks the rules of its format",
    "A property of a glTF asset has the wrong type or range, refers to what is not there, or must not be used "
    "together with another (glTF 2.0, and the JSON schemas of its extensions). The material that it belongs to "
    "is left out.",
    "Correct the place that is named, a JSON pointer into the file.",
)

INTERCHANGE_LEFT_OUT = Rule(
    "INTERCHANGE_LEFT_OUT",
    Severity.ERROR,
    "material has no form in the other format",
    "The material is made of parts that the other format does not have, and nothing that it has comes near, as "
    "where light is let through, or nothing near was asked for, so that it was not written at all.",
    "Build the material of what the other format has, for glTF of the node gltf_pbr, or use another format.",
)

INTERCHANGE_APPROXIMATED = Rule(
    "INTERCHANGE_APPROXIMATED",
    Severity.WARNING,
    "nearest material of the other format",
    "The material is made of parts that the other format does not have: glTF has one metal, one dielectric over "
    "a diffuse base, and layers over these. Written was what comes nearest by least squares over directions "
    "(docs/gltf.md); how far that is off was measured on what was written.",
    "Look at both, by mrm render, before relying on it; --exact leaves such materials out.",
)

INTERCHANGE_PREVIEW = Rule(
    "INTERCHANGE_PREVIEW",
    Severity.WARNING,
    "the look without MaterialX is another one",
    "A host that knows nothing of MaterialX shows the material's UsdPreviewSurface, which has its daytime "
    "colour and returns no light to where it comes from (docs/usd.md). The material itself is whole.",
    "Nothing is wrong with the file; --no-preview leaves the look out.",
)

USD_VALIDATOR = Rule(
    "USD_VALIDATOR",
    Severity.ERROR,
    "an error by USD's own validators",
    "The validators that come with USD call it an error; their name is in the message. They know nothing of "
    "MaterialX's nodes: that these are unknown to them is left out (docs/usd.md). The materials are checked "
    "all the same.",
    "Do what the message says; a stage wants defaultPrim, metersPerUnit and upAxis.",
    beside_materials=True,
    of_host=True,
)

USD_MISSING = Rule(
    "USD_MISSING",
    Severity.ERROR,
    "a layer of a stage is missing",
    "A sublayer, reference or payload of the stage names a file that is not there, or a document of MaterialX "
    "that is wrong. The stage is read without it. Materials that refer to it, or of which a prim around or in "
    "them does, are not checked; all others are.",
    "Correct the name, or put the file where the name leads; other places are not searched.",
    beside_materials=True,
)

USD_VALIDATOR_WARNING = Rule(
    "USD_VALIDATOR_WARNING",
    Severity.WARNING,
    "a warning by USD's own validators",
    "As USD_VALIDATOR, but what the validators call a warning.",
    "Do what the message says.",
    beside_materials=True,
    of_host=True,
)
