"""Materials of known performance: what each is made of, and its document.

The minima are those of `standards.tables`. What they do not say stands here, by judgement: the construction, the
colour at night (the tint of the lobes) and by day, the gloss of a clear face, and the area of a reflector. Colours lie
inside the boxes that were read, and luminance factors within Table 1a of 23 CFR 655, subpart F (white from 27 %, yellow
15 to 45 %, red 2.5 to 12 %), those of markings above its Table 5a (white from 35 %).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mrm_mtlx.fitting.document import write
from mrm_mtlx.fitting.model import Part
from mrm_mtlx.fitting.performance import CEILINGS, MARGIN, Make, Met, meet
from mrm_mtlx.standards import limits
from mrm_mtlx.system.versions import __version__
from mrm_mtlx.system.writing import replacing

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from mrm_mtlx.standards.tables import Limit

BEADS, TRUNCATED, FULL = CEILINGS
_WHITE, _YELLOW, _AMBER, _RED = (1.0, 1.0, 1.0), (1.0, 0.7, 0.0), (1.0, 0.5, 0.0), (1.0, 0.0, 0.0)
_WHITE_DAY, _YELLOW_DAY, _RED_DAY = (0.314, 0.331, 0.4), (0.485, 0.447, 0.28), (0.613, 0.333, 0.06)
# Faces: of film that is bent and handled, and of tape and moulded plastic.
_FLEXIBLE, _GLOSSY = 0.03, 0.01
# A front reflector of bicycles has some 4 by 7.5 cm, one of a pedal 2 by 6 cm.
_REFLECTOR_CM2, _PEDAL_CM2 = 30.0, 12.0


@dataclass(frozen=True)
class ClassMaterial:
    """A material of known performance: its file's name, its class by the names that choose it, what it is, its make."""

    name: str
    standard: str
    class_name: str
    colour: str
    what: str
    make: Make

    def limits(self) -> list[Limit]:
        """The minima of its class."""
        return limits(self.class_name, self.colour, standard=self.standard)


def _beaded(tint: tuple[float, float, float], day: tuple[float, float, float]) -> Make:
    return Make(BEADS, tint, day, _FLEXIBLE)


def _prismatic(tint: tuple[float, float, float], day: tuple[float, float, float]) -> Make:
    return Make(TRUNCATED, tint, day, _GLOSSY)


def _moulded(tint: tuple[float, float, float], day: tuple[float, float, float], area_cm2: float) -> Make:
    return Make(FULL, tint, day, _GLOSSY, area_cm2)


_MARKING = Make(BEADS, _WHITE, (0.314, 0.332, 0.6))
_CLEAR_DAY, _AMBER_DAY = (0.314, 0.331, 0.3), (0.53, 0.4, 0.15)

MATERIALS = (
    ClassMaterial(
        "dot_c2_white",
        "FMVSS 108",
        "DOT-C2",
        "white",
        "White blocks of vehicle conspicuity tape",
        _prismatic(_WHITE, _WHITE_DAY),
    ),
    ClassMaterial(
        "dot_c2_red",
        "FMVSS 108",
        "DOT-C2",
        "red",
        "Red blocks of vehicle conspicuity tape",
        _prismatic(_RED, _RED_DAY),
    ),
    ClassMaterial(
        "fmvss_131_beads_white",
        "FMVSS 131",
        "Type III glass bead",
        "white",
        "White legend of school bus stop signs, glass beads",
        _beaded(_WHITE, _WHITE_DAY),
    ),
    ClassMaterial(
        "fmvss_131_beads_red",
        "FMVSS 131",
        "Type III glass bead",
        "red",
        "Red ground of school bus stop signs, glass beads",
        _beaded(_RED, _RED_DAY),
    ),
    ClassMaterial(
        "astm_d4956_iii_yellow",
        "ASTM D4956-01",
        "Type III",
        "yellow",
        "Yellow high-intensity sheeting, glass beads",
        _beaded(_YELLOW, _YELLOW_DAY),
    ),
    ClassMaterial(
        "fmvss_131_prismatic_white",
        "FMVSS 131",
        "Type III prismatic",
        "white",
        "White legend of school bus stop signs, prismatic",
        _prismatic(_WHITE, _WHITE_DAY),
    ),
    ClassMaterial(
        "fmvss_131_prismatic_red",
        "FMVSS 131",
        "Type III prismatic",
        "red",
        "Red ground of school bus stop signs, prismatic",
        _prismatic(_RED, _RED_DAY),
    ),
    ClassMaterial(
        "iso_20471_silver",
        "EN ISO 20471",
        "separate-performance material",
        "unspecified",
        "Silver tape of high-visibility clothing, exposed glass beads",
        Make(BEADS, _WHITE, (0.313, 0.329, 0.3)),
    ),
    ClassMaterial(
        "fra_224_white",
        "49 CFR 224",
        "FRA-224",
        "white",
        "White sheeting on the sides of rail cars",
        _prismatic(_WHITE, _WHITE_DAY),
    ),
    ClassMaterial(
        "fra_224_yellow",
        "49 CFR 224",
        "FRA-224",
        "yellow",
        "Yellow sheeting on the sides of rail cars",
        _prismatic(_YELLOW, _YELLOW_DAY),
    ),
    ClassMaterial(
        "cpsc_reflector_clear",
        "16 CFR 1512",
        "front/rear/side reflector",
        "clear",
        "Clear front reflector of bicycles",
        _moulded(_WHITE, _CLEAR_DAY, _REFLECTOR_CM2),
    ),
    ClassMaterial(
        "cpsc_reflector_amber",
        "16 CFR 1512",
        "front/rear/side reflector",
        "amber",
        "Amber side reflector of bicycles",
        _moulded(_AMBER, _AMBER_DAY, _REFLECTOR_CM2),
    ),
    ClassMaterial(
        "cpsc_reflector_red",
        "16 CFR 1512",
        "front/rear/side reflector",
        "red",
        "Red rear reflector of bicycles",
        _moulded(_RED, _RED_DAY, _REFLECTOR_CM2),
    ),
    ClassMaterial(
        "cpsc_pedal_amber",
        "16 CFR 1512",
        "pedal reflector",
        "amber",
        "Amber pedal reflector of bicycles",
        _moulded(_AMBER, _AMBER_DAY, _PEDAL_CM2),
    ),
    *(
        ClassMaterial(
            f"en_1436_{name.lower()}_white",
            "EN 1436",
            f"{name} permanent",
            "white",
            f"White road marking of class {name}, dry, glass beads in paint",
            _MARKING,
        )
        for name in ("R2", "R3", "R4", "R5")
    ),
    ClassMaterial(
        "dpr_495_white",
        "DPR 495/1992 (Italy)",
        "mobile warning sign, new material",
        "white",
        "White prismatic part of warning triangles",
        _prismatic(_WHITE, _WHITE_DAY),
    ),
    ClassMaterial(
        "dpr_495_red",
        "DPR 495/1992 (Italy)",
        "mobile warning sign, new material",
        "red",
        "Red prismatic part of warning triangles",
        _prismatic(_RED, _RED_DAY),
    ),
    ClassMaterial(
        "lifesaving_silver",
        "46 CFR 164.018",
        "lifesaving equipment, Types I and II",
        "unspecified",
        "Silver tape on lifejackets and liferafts, glass beads",
        _beaded(_WHITE, (0.313, 0.329, 0.35)),
    ),
)


def write_documents(folder: Path, progress: Callable[[int, int], None] = lambda _done, _total: None) -> list[Path]:
    """Fit every material and write its document to the folder, which is made; the files, in order.

    Raises
    ------
    OSError
        If one cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for count, material in enumerate(MATERIALS):
        progress(count, len(MATERIALS))
        with replacing(folder / f"{material.name}.mtlx") as unfinished:
            unfinished.write_text(document(material, meet(material.limits(), material.make)), encoding="utf-8")
        written.append(folder / f"{material.name}.mtlx")
    progress(len(MATERIALS), len(MATERIALS))
    return written


def document(material: ClassMaterial, met: Met) -> str:
    """The text of a material's MaterialX document."""
    notes, docs = _notes(material, met), _DOCS[material.make.construction]
    return write(met.stack, met.values, material.name, notes, docs, doc=f"{material.what}.")


# What the layers are.
_DOCS = {
    BEADS: {
        Part.LOBE: "Glass beads with a mirror behind them.",
        Part.LOBE2: "Beads that are less round, a wider lobe.",
    },
    TRUNCATED: {Part.LOBE: "Cube corners, cut where they send back nothing.", Part.LOBE2: "Their wider part."},
    FULL: {Part.LOBE: "Whole cube corners, by total reflection.", Part.LOBE2: "Their wider part."},
}


def _notes(material: ClassMaterial, met: Met) -> list[str]:
    """Paragraphs on the origin of the numbers."""
    rows, make = material.limits(), material.make
    minima = ", ".join(f"{row.observation_deg:g}/{entrance(row)}: {row.minimum:g}" for row in rows)
    sources = "; ".join(dict.fromkeys(f"{row.source} ({row.confidence})" for row in rows))
    derived = next((f", {row.derived}" for row in rows if row.derived), "")
    area = f" The area of the reflector, {make.area_cm2:g} square centimetres, is a choice." if make.area_cm2 else ""
    lobes = "One lobe meets" if met.stack.lobes == 1 else "One lobe would return more than the ceiling, two meet"
    x, y, factor = make.day
    return [
        f"{material.what}. Made with mrm-mtlx {__version__} by mrm fit for all classes at once; do not edit.",
        f"Class: {material.standard}, {material.class_name}, colour {material.colour}{derived}. Source: {sources}.",
        f"Minima, {rows[0].quantity} in {rows[0].unit} at observation/entrance angle in degrees: {minima}.{area}",
        f"Fitted: width, fall-off and height of the lobes, as close above the minima as they get, {MARGIN - 1.0:.0%} "
        f"at least. {lobes} the class. Share returned within 2 degrees at normal incidence: {met.share:.3f}; "
        f"ceiling of {make.construction}: {CEILINGS[make.construction]:g}.",
        f"Chosen by judgement: construction, tint of the lobes, colour by day x {x:g}, y {y:g}, luminance factor "
        f"{factor:g}{'' if make.face_alpha is None else ', gloss of the face'}. "
        "Values beyond the angles of the minima are those of the lobes, not of a product.",
    ]


def entrance(limit: Limit) -> str:
    """Entrance angle as text: of reflectors, what is not in one plane has its side."""
    if limit.beta2_deg == 0.0:
        return f"{limit.beta1_deg:g}"
    side = f"{limit.beta2_deg:g} left or right"
    return side if limit.beta1_deg == 0.0 else f"{limit.beta1_deg:g} up and {side}"
