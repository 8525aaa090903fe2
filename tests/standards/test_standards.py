"""The minima and colour boxes: complete, consistent, found by their names, the same as the tables they came from."""

from __future__ import annotations

import csv
import hashlib
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.photometry import goniometer
from mrm_mtlx.standards import Quantity, boxes, limits, standards
from mrm_mtlx.standards.tables import classes, notes
from mrm_mtlx.system.arguments import ArgumentError

UNITS = {
    "R_A": {"cd/lx/m2"},
    "R_L": {"mcd/lx/m2"},
    "R_I": {"mcd/lx", "cd/fc"},
    "R_I/r": {"m"},
}
# Rows as printed, by standard.
PRINTED = {
    "16 CFR 1512": 27, "46 CFR 164.018": 9, "49 CFR 224": 8, "ANSI/ISEA 107": 2, "ASTM D4956-01": 77,
    "DPR 495/1992 (Italy)": 18, "EN 1436": 13, "EN ISO 20471": 16, "FMVSS 108": 62, "FMVSS 131": 16, "UN R3": 17,
}  # fmt: skip


def printed():
    return [limit for limit in standards() if not limit.derived]


def test_every_standard_has_the_rows_that_were_printed():
    assert Counter(limit.standard for limit in printed()) == PRINTED


def test_every_row_has_a_source_and_says_how_it_was_verified():
    for row in (*standards(), *boxes()):
        assert row.source
        assert row.confidence in ("verified-primary", "verified-secondary")


def test_every_quantity_has_its_unit_and_a_positive_minimum():
    for limit in standards():
        assert limit.unit in UNITS[limit.quantity]
        assert limit.minimum > 0.0


def test_no_geometry_is_asked_for_twice():
    keys = [(c.table, c.class_name, c.colour, c.observation_deg, c.entrance_deg) for c in standards()]
    assert len(set(keys)) == len(keys)


def test_the_components_of_the_entrance_angle_make_the_printed_one():
    for limit in standards():
        beta = np.rad2deg(goniometer.entrance(*np.deg2rad([limit.beta1_deg, limit.beta2_deg])))
        # UN R3: 20 stands for 5 up and 20 left or right, 0.59 more.
        allowed = 0.6 if limit.standard == "UN R3" else 1e-9
        assert abs(beta - abs(limit.entrance_deg)) <= allowed


def test_reflectors_are_turned_left_and_right_from_20_degrees_and_sheeting_never():
    for limit in standards():
        reflector = limit.quantity is Quantity.R_I
        assert (limit.beta2_deg != 0.0) == (reflector and limit.entrance_deg >= 20.0)


def test_minima_fall_with_the_observation_angle():
    for chosen in classes():
        rows = limits(chosen.class_name, chosen.colour, standard=chosen.standard)
        by_entrance = {row.entrance_deg: [] for row in rows}
        for row in sorted(rows, key=lambda row: row.observation_deg):
            by_entrance[row.entrance_deg].append(row.minimum)
        for minima in by_entrance.values():
            assert minima == sorted(minima, reverse=True)


def test_amber_and_red_bicycle_reflectors_have_their_shares_of_clear():
    """16 CFR 1512: 27 cd/fc of clear make 16.875 and 6.75; 6.75 cd/fc are 627 mcd/lx."""
    values = {c: limits("front/rear/side", c)[0].minimum for c in ("clear", "amber", "red")}
    assert values == {"clear": 27.0, "amber": 16.875, "red": 6.75}
    assert limits("front/rear/side", "red")[0].derived == "1/4 of clear"


@pytest.mark.parametrize(
    ("names", "count"),
    [
        ({"class_name": "dot c2", "color": "WHITE"}, 6),
        ({"class_name": "Type I", "color": "white"}, 4),  # not Type II, whose name has it as a part
        ({"standard": "dpr", "color": "red"}, 9),
        ({"standard": "iso 20471"}, 16),
        ({"standard": "fra", "class_name": None, "color": "yellow"}, None),
        ({"class_name": "FRA-224", "color": "yellow"}, 4),
        ({"standard": "EN 1436", "class_name": "R3 permanent", "color": "yellow"}, 1),
    ],
)
def test_a_class_is_found_by_as_much_of_its_names_as_tells_it_apart(names, count):
    if count is None:
        with pytest.raises(ValueError, match="no single standard is called 'fra'"):
            limits(**names)
    else:
        assert len(limits(**names)) == count


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ({}, "which class is not said; expected one of: .*DOT-C2"),
        ({"class_name": "DOT-C2"}, "which colour is not said; expected one of: red, white"),
        ({"class_name": "DOT-C9"}, "no single class is called 'DOT-C9'; expected one of: .*DOT-C2"),
        (
            {"class_name": "Type III", "standard": "131"},
            "no single class is called 'Type III'; .*glass bead.*prismatic",
        ),
        ({"standard": "EN 12899-1"}, "no single standard is called 'EN 12899-1'"),
        ({"class_name": " -"}, "no single class is called ' -'"),
        ({"class_name": "DOT-C2", "color": "blue"}, "no single colour is called 'blue'; expected one of: red, white"),
    ],
)
def test_a_name_that_does_not_tell_one_class_lists_what_there_is(names, message):
    with pytest.raises(ValueError, match=message):
        limits(**names)


def test_every_class_can_be_chosen_by_its_full_names():
    for chosen in classes():
        rows = limits(chosen.class_name, chosen.colour, standard=chosen.standard)
        assert {(row.standard, row.class_name, row.colour) for row in rows} == {tuple(chosen)}


def test_notes_belong_to_standards_that_are_there():
    assert all(notes(name) for name in PRINTED if name != "49 CFR 224")
    assert notes("EN 12899-1") == []


def test_boxes_are_convex_and_hold_their_middle():
    for box in boxes():
        assert len(box.corners) == 4
        middle = np.mean(box.corners, axis=0)
        assert box.margin(*middle) > 0.0
        for corner in box.corners:
            assert box.margin(*corner) == pytest.approx(0.0, abs=1e-12)  # a rounding of coordinates below 1
            assert box.margin(*(2.0 * np.array(corner) - middle)) < 0.0


def test_the_margin_of_a_box_is_the_distance_to_its_nearest_edge():
    box = next(box for box in boxes() if box.standard.startswith("DPR") and box.colour == "white")
    # Half way on the edge from (0.305, 0.305) to (0.355, 0.355), then 0.01 to either side.
    for sign in (1.0, -1.0):
        at = np.array([0.33, 0.33]) + sign * 0.01 * np.array([-1.0, 1.0]) / np.sqrt(2.0)
        assert box.margin(*at) == pytest.approx(sign * 0.01, abs=1e-12)


# Of each standard's minima and of the boxes, as they were when they were compared with the verified tables, number by
# number. A change of a number needs another comparison, and the digest that the test then prints.
VERIFIED_MINIMA = {
    "16 CFR 1512": "ea723a61b6fc8af0",
    "46 CFR 164.018": "feb8dffa68e121bc",
    "49 CFR 224": "d8c7c485a083cb5e",
    "ANSI/ISEA 107": "19146f8e4f587247",
    "ASTM D4956-01": "b11626d73943f3a4",
    "DPR 495/1992 (Italy)": "a798aa8c2e891f18",
    "EN 1436": "3711dcb224de476e",
    "EN ISO 20471": "91b8edac8813f65d",
    "FMVSS 108": "f241b82fb3a1dd78",
    "FMVSS 131": "bd047917f3317dd6",
    "UN R3": "9b36e3c366de86a0",
}
VERIFIED_BOXES = "baf0886cfdb67f3a"


def minimum_row(limit):
    return (
        limit.standard, limit.table, limit.class_name, limit.colour, limit.observation_deg, limit.entrance_deg,
        limit.quantity.value, limit.unit, limit.minimum, limit.confidence, limit.source,
    )  # fmt: skip


def box_rows(found):
    return [
        (f"{b.standard}, {b.table}", b.illuminant == "D65", b.colour, i, *corner, b.confidence, b.source)
        for b in found
        for i, corner in enumerate(b.corners, start=1)
    ]


def digest(rows):
    """Digest of rows in any order, short enough to be read."""
    return hashlib.sha256("\n".join(sorted(map(repr, rows))).encode()).hexdigest()[:16]


def test_the_minima_are_as_they_were_when_they_were_verified():
    found = {name: digest(minimum_row(limit) for limit in printed() if limit.standard == name) for name in PRINTED}
    assert found == VERIFIED_MINIMA


def test_the_boxes_are_as_they_were_when_they_were_verified():
    assert digest(box_rows(boxes())) == VERIFIED_BOXES


def test_another_number_has_another_digest():
    limit, box = printed()[0], boxes()[0]
    assert digest([minimum_row(limit)]) != digest([minimum_row(replace(limit, minimum=limit.minimum * 1.001))])
    moved = replace(box, corners=((box.corners[0][0] + 0.001, box.corners[0][1]), *box.corners[1:]))
    assert digest(box_rows([box])) != digest(box_rows([moved]))


def test_the_minima_are_those_of_the_verified_tables(shared):
    with (shared / "photometry" / "standards.csv").open(newline="", encoding="utf-8") as stream:
        expected = Counter(
            (
                row["standard"], row["edition_or_table"], row["class"], row["colour"], float(row["alpha_deg"]),
                float(row["beta_deg"]), row["quantity"], row["unit"], float(row["minimum"]), row["confidence"],
                row["source"],
            )
            for row in csv.DictReader(stream)
        )  # fmt: skip
    assert Counter(map(minimum_row, printed())) == expected


def test_the_boxes_are_those_of_the_verified_tables(shared):
    with (shared / "photometry" / "chromaticity.csv").open(newline="", encoding="utf-8") as stream:
        expected = Counter(
            (
                row["table"], row["condition"].startswith("day"), row["colour"], int(row["corner"]), float(row["x"]),
                float(row["y"]), row["confidence"], row["source"],
            )
            for row in csv.DictReader(stream)
        )  # fmt: skip
    assert Counter(box_rows(boxes())) == expected


@pytest.mark.parametrize(
    ("names", "argument"),
    [
        ({"standard": "nobody's"}, "standard"),
        ({"standard": "FMVSS 108"}, "class_name"),
        ({"class_name": "DOT-C2"}, "color"),
        ({"class_name": "DOT-C2", "color": "mauve"}, "color"),
    ],
)
def test_the_argument_that_does_not_tell_one_class_is_named(names, argument):
    with pytest.raises(ArgumentError) as caught:
        limits(**names)
    assert caught.value.argument == argument
