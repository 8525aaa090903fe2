"""The inputs of gltf_pbr whose values come nearest to those of a surface that has another form.

Least squares over directions, of

    w_i (log(m_i + e_i) - log(t_i + e_i)),        e_i = (0.01 / pi) + max_rgb(t_i) / 20

with t the reference's values of the surface, cosine included and averaged over places, and m those of gltf_pbr: what is
small beside a white diffuser, or beside the other channels, counts for little, and a peak for no more than its flank.
Of the directions (`directions.pairs`), those by which standards measure the colour by day and R_A weigh as much as a
third of all others each.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mrm_mtlx.formats.pbr.directions import DAY, NIGHT, pairs, points, upper
from mrm_mtlx.formats.pbr.model_nodes import MODEL, model_document
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.term import Term
from mrm_mtlx.reference import Environment, Illumination, Surface

if TYPE_CHECKING:
    from collections.abc import Callable

    import MaterialX as mx
    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.closures import Facets

    Pixels = Callable[[str], NDArray[np.floating] | None]

_SEED, _THIRD, _PLACES = 7, 80, 16
# What can be seen: a hundredth of a white diffuser; and a twentieth of the brightest channel.
_DARK, _WEAK = 0.01 / np.pi, 0.05
# Relative: the sum of squares no longer falls. Steps of a derivative whose values have twelve digits.
_SETTLED, _STEP, _ROUNDS = 1e-3, 1e-6, 30
# From the ends of the parameters' ranges, where the search begins within.
_MARGIN = 1e-3
# Roughness below which gltf_pbr's lobe is a mirror to float32 shaders, alpha 0.0004.
_LEAST_ROUGHNESS = 0.02
# Light that a surface lets through, of 1 behind it.
_THROUGH = 1e-6
# gltf_pbr's reflectance at normal incidence, of index 1.5.
_REFLECTANCE = 0.04

# The parameters, from 0 to 1: the colour of the diffuse base, the reflectance at normal incidence as a share of that
# at grazing incidence, which is `specular`, and what follows.
_NUMBERS = ("specular", "roughness", "retroreflectivity", "clearcoat", "clearcoat_roughness")
_BASE, _NORMAL = ("base red", "base green", "base blue"), ("normal red", "normal green", "normal blue")
_PARAMETERS = (*_BASE, *_NORMAL, *_NUMBERS)
_WIDTHS = ("roughness", "clearcoat_roughness")


def nearest(element: Any, images: Pixels, alpha: float = 1.0) -> dict[str, Any]:
    """The inputs of gltf_pbr, as terms, that come nearest to a renderable element.

    Parameters
    ----------
    element
        In a document whose data library is set.
    images
        As `reference.Surface`.
    alpha
        Its opacity, above 0, which is none of the inputs.

    Raises
    ------
    InexpressibleError
        If it lets light through, is black, or has no finite values.
    UnsupportedError, RecursionError
        If the reference cannot evaluate it.
    """
    surface = Surface(element, images=images)
    _refuse_light_through(surface)
    wanted, lobes = _values(surface)
    model = _Model(element.getDocument().getDataLibrary(), wanted, alpha)
    return {**model.fitted(_start(lobes)), **_emission(surface, alpha)}


def _refuse_light_through(surface: Surface) -> None:
    """Raise InexpressibleError if light from behind a surface is seen through it."""

    def behind(directions: Array) -> Array:
        return np.repeat((directions[2:] < 0.0).astype(float), 3, axis=0)

    view = upper(np.random.default_rng(_SEED), _PLACES, 0.9)  # from where nothing is reflected from below the horizon
    at = points(view, view, _PLACES, _SEED)
    lit = Illumination(light=False, environment=Environment(behind, behind, samples=8))
    if np.any(surface.shade(at, lit) - surface.shade(at, Illumination(light=False)) > _THROUGH):
        msg = "it lets light through"
        raise InexpressibleError(msg)


def _values(surface: Surface) -> tuple[Array, list[Facets]]:
    """The surface's response at all directions, in the mean over places, and its microfacet lobes."""
    v, l = _directions()
    at = points(v, l, _PLACES, _SEED)
    found = surface.response(at).reshape(_PLACES, len(v), 3).mean(axis=0)
    if not np.all(np.isfinite(found)):
        msg = "it has no finite values"
        raise InexpressibleError(msg)
    if not np.any(found > _THROUGH):
        msg = "it reflects nothing"
        raise InexpressibleError(msg)
    return found, [lobe for lobe in surface.traits(at).lobes if not lobe.off]


def _directions() -> tuple[Array, Array]:
    v, l = pairs(np.random.default_rng(_SEED), _THIRD)
    return np.vstack([v, DAY[0], NIGHT[0]]), np.vstack([l, DAY[1], NIGHT[1]])


class _Start(NamedTuple):
    """Parameters to begin with, by name, and those of them that are free."""

    values: dict[str, float]
    free: frozenset[str]

    def placed(self, some: Array) -> Array:
        """Sets of parameters of sets of those that are free, (sets, parameters)."""
        found = np.tile([self.values[name] for name in _PARAMETERS], (len(some), 1))
        found[:, self.where] = some
        return found

    @property
    def where(self) -> NDArray[np.bool_]:
        """Which of the parameters are free."""
        return np.array([name in self.free for name in _PARAMETERS])


def _start(lobes: list[Facets]) -> _Start:
    """The parameters of a surface with these lobes: one is the base's, an ordinary one beside it is the coat's."""
    returning = [_roughness(lobe) for lobe in lobes if np.any(lobe.retroreflective)]
    ordinary = [_roughness(lobe) for lobe in lobes if not np.all(lobe.retroreflective)]
    is_coated = len(ordinary) > (not returning)
    free = {*_BASE}
    if lobes:
        free |= {*_NORMAL, "specular", "roughness"}
    if returning and ordinary:
        free.add("retroreflectivity")
    if is_coated:
        free |= {"clearcoat", "clearcoat_roughness"}
    values = {
        **dict.fromkeys(_BASE, 0.5),
        **dict.fromkeys(_NORMAL, 0.3),
        "specular": 0.5 if lobes else 0.0,
        "roughness": float(np.mean(returning or ordinary or [1.0])),
        "retroreflectivity": 1.0 if returning else 0.0,
        "clearcoat": 0.5 if is_coated else 0.0,
        "clearcoat_roughness": min(ordinary, default=0.1),
    }
    return _Start(values, frozenset(free))


def _roughness(lobe: Facets) -> float:
    width = np.sqrt(np.maximum(lobe.alpha_x * lobe.alpha_y, 0.0))
    return float(np.clip(np.sqrt(np.mean(width)), 2.0 * _LEAST_ROUGHNESS, 1.0))


def _emission(surface: Surface, alpha: float) -> dict[str, Term]:
    """The light of its own, in the mean over directions and places; what is seen of it is weakened by the opacity."""
    v, l = pairs(np.random.default_rng(_SEED), _PLACES)
    light = surface.shade(points(v, l, _PLACES, _SEED), Illumination(light=False)).mean(axis=0)
    return {"emissive": Term.constant(_rounded(light / alpha))} if np.any(light > _THROUGH) else {}


class _Model:
    """gltf_pbr with parameters as inputs, and the values that it is to have.

    Its inputs are connected to geometric properties, so that many sets of parameters are evaluated at once.
    """

    def __init__(self, library: mx.Document, wanted: Array, alpha: float) -> None:
        given: dict[str, Term | int] = {"alpha": Term.constant(alpha), "alpha_mode": 2}
        self._document = model_document(library, "gltf_pbr", given)
        node = self._document.getNode(MODEL)
        for name, values in _inputs(np.zeros((1, len(_PARAMETERS)))).items():
            kind = "color3" if values.ndim == 2 else "float"
            source = self._document.addNode("geompropvalue", f"of_{name}", kind)
            source.addInput("geomprop", "string").setValueString(name)
            node.addInput(name, kind).setNodeName(source.getName())
        self._surface = Surface(node)
        self._floor = _DARK + _WEAK * wanted.max(axis=1, keepdims=True)
        self._wanted = np.log(wanted + self._floor)
        self._weights = np.ones((len(wanted), 1))
        self._weights[-2:] = np.sqrt(_THIRD)

    def fitted(self, start: _Start) -> dict[str, Any]:
        """The inputs of the least sum of squares, of which some are free."""
        from scipy.optimize import least_squares

        low = np.array([_LEAST_ROUGHNESS if name in _WIDTHS else 0.0 for name in _PARAMETERS])[start.where]

        def residuals(some: Array) -> Array:
            return np.asarray(self._residuals(start.placed(some[None]))[0])

        def slopes(some: Array) -> Array:
            step = np.where(some < 0.5, _STEP, -_STEP)
            found = self._residuals(start.placed(np.vstack([some, some + np.diag(step)])))
            return np.asarray((found[1:] - found[0]).T / step)

        begin = np.array([start.values[name] for name in _PARAMETERS])[start.where]
        inside = np.clip(begin, low + _MARGIN, 1.0 - _MARGIN)
        found = least_squares(residuals, inside, slopes, (low, 1.0), ftol=_SETTLED, xtol=_SETTLED, max_nfev=_ROUNDS)
        best = _rounded(start.placed(found.x[None])[0])
        return {name: Term.constant(value[0]) for name, value in _inputs(best[None]).items()}

    def _residuals(self, parameters: Array) -> Array:
        """Weighted logarithms of values over those that are wanted, by set of parameters, (sets, residuals)."""
        v, l = _directions()
        sets = len(parameters)
        at = points(np.tile(v, (sets, 1)), np.tile(l, (sets, 1)))
        properties = {name: np.repeat(value, len(v), axis=0) for name, value in _inputs(parameters).items()}
        seen = self._surface.response(replace(at, properties=properties)).reshape(sets, len(v), 3)
        return np.asarray((self._weights * (np.log(seen + self._floor) - self._wanted)).reshape(sets, -1))


def _inputs(parameters: Array) -> dict[str, Array]:
    """The inputs of gltf_pbr that sets of parameters mean, (sets, parameters): numbers (sets,), colours (sets, 3)."""
    base, normal, numbers = parameters[:, :3], parameters[:, 3:6], parameters[:, 6:].T
    colors = {"base_color": base, "specular_color": normal / _REFLECTANCE}
    return {**colors, "metallic": np.zeros(len(parameters)), **dict(zip(_NUMBERS, numbers, strict=True))}


def _rounded(values: Array) -> Array:
    """Numbers with four digits: more of them say nothing."""
    return np.array([float(f"{x:.4g}") for x in np.atleast_1d(values)])
