"""Lobes from a few numbers: the models that can be plotted without a document, and what each is described by."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.bsdf import EON, Conductor, Dielectric, GeneralizedSchlick, Lambert

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from mrm_mtlx.bsdf import Lobe

DEFAULT_ROUGHNESS = 0.3

# Microfacet models: the lobe, and the values that it has where none are given. The metal is the one that MaterialX's
# conductor_bsdf shows by default, gold; the Schlick lobe reflects everything, as in Figure 2 of the paper.
_MICROFACET: dict[str, tuple[Callable[..., Lobe], dict[str, Any]]] = {
    "schlick": (GeneralizedSchlick, {"color0": 1.0, "color82": 1.0, "color90": 1.0}),
    "conductor": (Conductor, {"ior": (0.183, 0.421, 1.373), "extinction": (3.424, 2.346, 1.770)}),
    "dielectric": (Dielectric, {"ior": 1.5}),
}
_WIDTH = ("roughness", "alpha")
_NAMES = ("distribution", "masking")
# By model, what its parameters are called.
PARAMETERS: dict[str, tuple[str, ...]] = {
    **{model: (*defaults, *_WIDTH, *_NAMES) for model, (_, defaults) in _MICROFACET.items()},
    "eon": ("color", "roughness"),
    "lambert": ("color",),
}
# The models that have a retroreflective form.
MICROFACET = tuple(_MICROFACET)
# How the others are called in a picture.
DIFFUSE = {"eon": "EON", "lambert": "Lambert"}


def lobe(model: str, given: Mapping[str, Any], *, retroreflective: bool = False) -> Lobe:
    """A lobe of a model.

    Parameters
    ----------
    model
        A name of `PARAMETERS`.
    given
        Its parameters by name; those that are absent have their defaults. `roughness` is the artist's value: a
        microfacet lobe has alpha = roughness^2, unless `alpha` is given in its place.
    retroreflective
        For a model of `MICROFACET`.

    Raises
    ------
    ValueError
        If a parameter is not of this model, given twice, or outside its range.
    """
    for name, value in given.items():
        _check(model, name, value)
    if model == "lambert":
        return Lambert(given.get("color", 1.0))
    if model == "eon":
        return EON(given.get("color", 1.0), given.get("roughness", DEFAULT_ROUGHNESS))
    if "roughness" in given and "alpha" in given:
        msg = "roughness and alpha are given, which are one quantity: alpha = roughness^2"
        raise ValueError(msg)
    alpha = given.get("alpha", given.get("roughness", DEFAULT_ROUGHNESS) ** 2)
    make, defaults = _MICROFACET[model]
    rest = {name: value for name, value in given.items() if name not in _WIDTH}
    return make(**{**defaults, **rest}, alpha=(alpha, alpha), retroreflective=retroreflective)


def _check(model: str, name: str, value: Any) -> None:
    """Refuse a parameter that a model does not have, or numbers out of range; the lobe itself knows its other names."""
    if name not in PARAMETERS[model]:
        owners = ", ".join(other for other, names in PARAMETERS.items() if name in names)
        msg = f"{name} is no parameter of {model}, but of {owners}"
        raise ValueError(msg)
    if name in _NAMES:
        return
    numbers = np.atleast_1d(np.asarray(value, dtype=float))
    highest = np.inf if name in ("ior", "extinction") else 1.0
    # An index and a width of 0 have no lobe.
    positive = name in ("ior", "alpha") or (name == "roughness" and model in MICROFACET)
    if np.all(np.isfinite(numbers) & (numbers >= 0.0) & (numbers <= highest)) and (
        np.all(numbers > 0.0) or not positive
    ):
        return
    lowest = "more than 0" if positive else "0 or more"
    bounds = lowest if highest == np.inf else f"{lowest}, and at most {highest:g}"
    msg = f"{name} is {', '.join(f'{x:g}' for x in numbers)}; expected {bounds}"
    raise ValueError(msg)
