"""Names that options take: those of tables in the rooms below, without importing what these import."""

from __future__ import annotations

from enum import StrEnum


class ReportFormat(StrEnum):
    """Report formats."""

    TEXT = "text"
    JSON = "json"
    JUNIT = "junit"
    GITHUB = "github"


class TableFormat(StrEnum):
    """Formats of commands that print one table."""

    TEXT = "text"
    JSON = "json"


class VectorFormat(StrEnum):
    """Forms of the table of test vectors."""

    TEXT = "text"
    JSON = "json"
    CSV = "csv"


class Implementation(StrEnum):
    """Implementations of the flag; library.Origin."""

    MRM = "mrm"
    UPSTREAM = "upstream"


class Form(StrEnum):
    """Forms of the node library; conformance.Form."""

    LIBRARY = "library"
    PORTABLE = "portable"


class OslModeName(StrEnum):
    """Ways in which OSL makes a retroreflective lobe; shadergen.OslMode."""

    ALIGNED = "aligned"
    CYCLES = "cycles"
    KEYWORD = "keyword"


class Shape(StrEnum):
    """Shapes that can be rendered; render.shapes.SHAPES."""

    SPHERE = "sphere"
    PLANE = "plane"
    CONE = "cone"


class FitModel(StrEnum):
    """Layer stacks that are fitted; api.fit.MODELS."""

    AUTO = "auto"
    PAPER = "paper"


class Residual(StrEnum):
    """Residuals of BRDF samples; fitting.residuals.RESIDUALS."""

    LOG = "log"
    ROOT = "root"
    LINEAR = "linear"


class Loss(StrEnum):
    """Losses; fitting.fit.LOSSES."""

    SOFT_L1 = "soft_l1"
    LINEAR = "linear"


class Cosine(StrEnum):
    """Directions whose cosine values may have; api.fit.COSINES."""

    LIGHT = "light"
    VIEW = "view"


class Criterion(StrEnum):
    """Information criteria; api.fit.CRITERIA."""

    BIC = "bic"
    AICC = "aicc"


class Method(StrEnum):
    """Ways of colours under illuminant A; photometry.color.METHODS."""

    SPECTRAL = "spectral"
    RGB = "rgb"


class Scale(StrEnum):
    """Scales of values; plots.drawing.SCALES."""

    LINEAR = "linear"
    LOG = "log"
    POLAR = "polar"


class LobeModel(StrEnum):
    """Models that need no document; plots.parameters.PARAMETERS."""

    SCHLICK = "schlick"
    CONDUCTOR = "conductor"
    DIELECTRIC = "dielectric"
    EON = "eon"
    LAMBERT = "lambert"


class Distribution(StrEnum):
    """Distributions of facets; bsdf.masking.DISTRIBUTIONS."""

    GGX = "ggx"
    BECKMANN = "beckmann"
    PHONG = "phong"


class Masking(StrEnum):
    """Ways in which facets hide each other; bsdf.masking.MASKINGS."""

    SMITH = "smith"
    SMITH_SEPARABLE = "smith_separable"
    V_CAVITY = "v_cavity"


class Figure(StrEnum):
    """Figures of the paper; api.plot.FIGURES."""

    TWO = "2"
    FOUR = "4"
    ALL = "all"
