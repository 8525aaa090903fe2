"""Test vectors: lobes, pairs of directions and what the model gives for them, to check an implementation against.

Directions are given by angles in degrees, since those can be typed: theta from the normal, phi from the tangent.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.bsdf.blend import partially_retroreflective
from mrm_mtlx.bsdf.lobes import Conductor, Dielectric, GeneralizedSchlick
from mrm_mtlx.bsdf.microfacet_lobe import Microfacet
from mrm_mtlx.bsdf.sheeting import PrismaticSheeting

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.lobe import Lobe

SCHEMA = "mrm.vectors/1"

# Digits that are printed: what any order of the same operations agrees on.
DIGITS = 10
# Decimals of an albedo, which is an integral.
ALBEDO_DECIMALS = 3

GOLD: dict[str, Any] = {"ior": (0.183, 0.421, 1.373), "extinction": (3.424, 2.346, 1.770)}


@dataclass(frozen=True)
class Case:
    """One lobe and the pairs of directions it is evaluated for.

    `pairs` holds (theta_v, phi_v, theta_l, phi_l) in degrees; `weight` is that of partial retroreflection, None where
    the lobe's own flag decides.
    """

    name: str
    lobe: Microfacet | PrismaticSheeting
    pairs: tuple[tuple[float, float, float, float], ...]
    weight: float | None = None

    @property
    def bsdf(self) -> Lobe:
        """The lobe that is evaluated."""
        if self.weight is None or not isinstance(self.lobe, Microfacet):
            return self.lobe
        return partially_retroreflective(self.lobe, self.weight)


# In the plane of incidence at the peak and beside it, out of the plane, and at grazing incidence.
REFLECTED = ((30.0, 0.0, 30.0, 180.0), (30.0, 0.0, 30.0, 0.0), (35.0, 20.0, 50.0, -70.0), (80.0, 45.0, 85.0, 40.0))
# Through the interface: beside the refracted direction, far from it, and both ways through one pair of directions.
REFRACTED = (
    (40.0, 0.0, 155.0, 180.0),
    (40.0, 0.0, 155.0, 10.0),
    (155.0, 180.0, 40.0, 0.0),
    (60.0, 30.0, 110.0, -100.0),
)


def cases() -> tuple[Case, ...]:
    """The cases, in order."""
    tape = GeneralizedSchlick(0.19, 0.0, 1.0, alpha=(0.23**2, 0.23**2), retroreflective=True, sampling="visible")
    found = [Case("yellow tape of Figure 4", tape, tuple((t, 0.0, t, 0.0) for t in (15.0, 30.0, 60.0)))]
    for flag, kind in ((False, "ordinary"), (True, "retroreflective")):
        common: dict[str, Any] = {"retroreflective": flag, "sampling": "visible"}
        found += [
            Case(f"gold, {kind}", Conductor(**GOLD, alpha=(0.1, 0.2), **common), REFLECTED),
            Case(f"narrow metal, {kind}", Conductor(0.2, 3.4, alpha=(0.0025, 0.0025), **common), REFLECTED[:2]),
            Case(
                f"bounded cap, {kind}",
                Conductor(**GOLD, alpha=(0.1, 0.2), **{**common, "sampling": "bounded"}),
                REFLECTED[2:],
            ),
        ]
        for distribution in ("ggx", "beckmann", "phong"):
            for masking in ("smith", "smith_separable", "v_cavity"):
                parts = {"distribution": distribution, "masking": masking, **common}
                lobe = Dielectric(1.5, alpha=(0.3, 0.4), scatter_mode="RT", **parts)
                found.append(Case(f"glass, {distribution}, {masking}, {kind}", lobe, (REFLECTED[2], REFRACTED[0])))
    for reflection, transmission in ((False, False), (True, True), (True, False)):
        glass = Dielectric(
            1.5,
            alpha=(0.2, 0.3),
            scatter_mode="RT",
            retroreflective=reflection,
            retroreflective_btdf=transmission,
            sampling="visible",
        )
        inside = ((150.0, 0.0, 160.0, 30.0), (125.0, 0.0, 120.0, 180.0))  # the latter beyond the critical angle
        kind = "retroreflective" if reflection else "ordinary"
        through = "retroreflective" if transmission else "ordinary"
        found.append(Case(f"Figure 6: {kind} BRDF, {through} BTDF", glass, REFLECTED[2:3] + REFRACTED + inside))
    film = Conductor(0.9, 2.5, alpha=(0.2, 0.1), thinfilm_thickness=450.0, thinfilm_ior=1.35, sampling="visible")
    found.append(Case("thin film", film, REFLECTED[:3]))
    found += [
        Case(
            f"partially retroreflective, weight {weight:g}", Conductor(**GOLD, alpha=(0.3, 0.3)), REFLECTED[:3], weight
        )
        for weight in (0.0, 0.25, 1.0)
    ]
    sheet = PrismaticSheeting(1.586, alpha=(0.05, 0.08), rotation=0.3, substrate=(0.5, 0.1, 0.02), tint=(0.9, 0.3, 0.1))
    for backing in ("air", "metal"):
        pairs = ((10.0, 20.0, 10.0, 20.0), (30.0, 40.0, 31.0, 41.0), (50.0, -20.0, 20.0, 100.0))
        found.append(Case(f"prismatic sheeting, {backing}", replace(sheet, backing=backing), pairs))
    return tuple(found)


def rows(*, albedos: bool = True) -> list[dict[str, Any]]:
    """One row per case and pair: name, model, its parameters, directions, f [1/sr], pdf [1/sr], albedo; plain values.

    A parameter that a model does not have is absent. `retroreflectivity` is the weight of partial retroreflection;
    where it is present, `retroreflective` has no part. `albedo` is that for v, to 1e-3; it takes most of the time, and
    is absent without `albedos`.
    """
    found = []
    for case in cases():
        angles = np.deg2rad(case.pairs)
        v, l = direction(angles[:, 0], angles[:, 1]), direction(angles[:, 2], angles[:, 3])
        bsdf = case.bsdf
        f, pdf = bsdf.eval(v, l), bsdf.pdf(v, l)
        # One by one: each view takes as many points as it needs.
        views = {tuple(view): view for view in v} if albedos else {}
        albedo = {key: bsdf.albedo(view, accuracy=0.5 * 10.0**-ALBEDO_DECIMALS) for key, view in views.items()}
        for i, pair in enumerate(case.pairs):
            row: dict[str, Any] = {"case": case.name, **parameters(case)}
            row |= dict(zip(("theta_v_deg", "phi_v_deg", "theta_l_deg", "phi_l_deg"), pair, strict=True))
            row |= {"v": _list(v[i]), "l": _list(l[i]), "f": _list(f[i]), "pdf": _list(pdf[i])}
            if albedos:
                row["albedo"] = [round(x, ALBEDO_DECIMALS) for x in albedo[tuple(v[i])].tolist()]
            found.append(row)
    return found


def parameters(case: Case) -> dict[str, Any]:
    """Model and parameters of a case, by the names of `lobes`; a width is `alpha`, a pair."""
    row: dict[str, Any] = {"model": type(case.lobe).__name__}
    for field in fields(case.lobe):
        value = getattr(case.lobe, field.name)
        row[field.name] = list(value) if isinstance(value, tuple) else value
    if isinstance(case.lobe, Microfacet):
        row["energy_compensation"] = case.lobe.energy_compensation is not None
    if case.weight is not None:
        row["retroreflectivity"] = case.weight
    return row


def direction(theta: Array, phi: Array) -> Array:
    """Unit vectors (..., 3) for angles in radians: theta from n, phi from the tangent."""
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def _list(values: Array) -> Any:
    """Plain numbers of `DIGITS` digits."""
    return np.vectorize(lambda x: float(f"{x:.{DIGITS}g}"))(values).tolist()
