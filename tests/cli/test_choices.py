"""The names that options take are those of the tables that they stand for, in their order where it is a table's."""

from __future__ import annotations

from mrm_mtlx.api import fit, plot
from mrm_mtlx.bsdf.masking import DISTRIBUTIONS, MASKINGS
from mrm_mtlx.cli import choices
from mrm_mtlx.conformance import Form
from mrm_mtlx.fitting.fit import LOSSES
from mrm_mtlx.fitting.residuals import RESIDUALS
from mrm_mtlx.library import Origin
from mrm_mtlx.photometry.color import METHODS
from mrm_mtlx.plots.drawing import SCALES
from mrm_mtlx.plots.parameters import PARAMETERS
from mrm_mtlx.render.shapes import SHAPES
from mrm_mtlx.shadergen import OslMode


def names(choice):
    return [member.value for member in choice]


def test_the_names_of_the_options_are_those_of_the_tables_they_stand_for():
    assert names(choices.Implementation) == names(Origin)
    assert names(choices.Form) == names(Form)
    assert names(choices.OslModeName) == names(OslMode)
    assert names(choices.Shape) == list(SHAPES)
    assert names(choices.Scale) == list(SCALES)
    assert names(choices.Method) == list(METHODS)
    assert set(names(choices.LobeModel)) == set(PARAMETERS)
    assert set(names(choices.Distribution)) == set(DISTRIBUTIONS)
    assert set(names(choices.Masking)) == set(MASKINGS)
    assert set(names(choices.Residual)) == set(RESIDUALS) == set(fit.RESIDUALS)
    assert tuple(names(choices.Loss)) == LOSSES == fit.LOSSES
    assert tuple(names(choices.FitModel)) == fit.MODELS
    assert tuple(names(choices.Cosine)) == fit.COSINES
    assert tuple(names(choices.Criterion)) == fit.CRITERIA
    assert tuple(names(choices.Figure)) == plot.FIGURES
