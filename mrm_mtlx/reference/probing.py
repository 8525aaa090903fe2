"""Values of single inputs of a document's nodes, and widths of its lobes, without a surface to evaluate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.graph import Scope, connected_node
from mrm_mtlx.reference.evaluation import Evaluation
from mrm_mtlx.reference.points import ShadingPoints
from mrm_mtlx.reference.surface import Surface
from mrm_mtlx.reference.survey import Survey, UnsupportedError

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# Two points that differ in everything: what is the same at both is constant.
_TWO_POINTS = ShadingPoints(
    view=np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]]),
    light=np.array([[0.0, 0.6, 0.8], [0.0, 0.0, 1.0]]),
    normal=np.array([[0.0, 0.0, 1.0], [0.0, 0.28, 0.96]]),
    tangent=np.array([[1.0, 0.0, 0.0], [0.0, 0.96, -0.28]]),
    position=np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]),
    texcoord=np.array([[0.0, 0.0], [0.25, 0.75]]),
)

# A picture that differs there, too.
_TWO_TEXELS = np.array([[[0.25] * 4], [[0.75] * 4]])


def constant_input(node: Any, name: str) -> Array | str | None:
    """Value of a node's input where it is the same at every point; None where it varies or cannot be evaluated here.

    `node` stands in a document whose data library is set, and has a definition with that input. Scalars have shape (),
    colours and vectors (components,).
    """
    value, is_local = _input(node, name, _TWO_POINTS)
    if isinstance(value, str):
        return value
    if not is_local or value is None or value.shape[-1:] == (2,):
        return None
    return value if value.ndim == 0 else value[..., 0]


def narrowest_width(shader: Any) -> float | None:
    """Least width alpha of the lobes that a surface shader node reflects a light by, as far as they are constant.

    None where there are none, or where the node cannot be evaluated here. Lobes of weight 0 do not count.
    """
    try:
        traits = Surface(shader, images=lambda _: _TWO_TEXELS).traits(_TWO_POINTS)
    except (UnsupportedError, RecursionError, KeyError, AttributeError, TypeError):  # as in `_input`
        return None
    if traits.properties:
        return None
    seen = [lobe for lobe in traits.lobes if not lobe.off and lobe.scatter_mode != "T"]
    widths = [float(np.min(a)) for lobe in seen for a in (lobe.alpha_x, lobe.alpha_y) if np.size(a) == 1]
    return min(widths, default=None)


def input_at(node: Any, name: str, points: ShadingPoints) -> Array | None:
    """Value of a node's input at these points, shape (components, samples); None where it cannot be evaluated here.

    As `constant_input`; what depends on images or on geometric properties cannot.
    """
    value, is_local = _input(node, name, points)
    if isinstance(value, str) or value is None or not is_local:
        return None
    return np.broadcast_to(np.atleast_2d(value), (len(np.atleast_2d(value)), len(points)))


def _input(node: Any, name: str, points: ShadingPoints) -> tuple[Array | str | None, bool]:
    """Value of a node's input, None if it cannot be evaluated, and whether it needs neither images nor properties."""
    definition = node.getNodeDef()
    given, survey = node.getInput(name), Survey()
    if given is not None:
        survey.visit(connected_node(given))
    if survey.unknown:
        return None, False
    images: list[str] = []
    evaluation = Evaluation(points, images=images.append)
    try:
        with np.errstate(all="ignore"):
            value = evaluation.input_value(node, definition, name, Scope(), evaluation.light)
    except (KeyError, AttributeError, TypeError):  # an interface that is bound only where the graph is used
        return None, False
    is_local = not images and not evaluation.asked  # an image and a geometric property vary
    if isinstance(value, np.generic):  # what NumPy's functions make of arrays without dimensions
        value = np.asarray(value)
    return (value if isinstance(value, str | np.ndarray) else None), is_local
