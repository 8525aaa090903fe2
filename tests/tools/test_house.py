"""The picture of the rooms: it is made of the order that the imports are held to, and is up to date."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import matplotlib as mpl
import pytest

from tests.test_architecture import LAYERS
from tools import house
from tools.make_docs import PRODUCTS, verdict

if TYPE_CHECKING:
    from pathlib import Path


def test_the_rooms_are_those_of_the_order_of_imports_and_say_what_they_are() -> None:
    assert [set(rooms) for rooms in house.layers()] == [set(layer) for layer in LAYERS]
    for rooms in house.layers():
        assert all(len(house.about(room)) > 20 for room in rooms)


def test_every_door_leads_to_a_file_of_its_room() -> None:
    assert [room for room, (_, path) in house.DOORS.items() if not (house.PACKAGE / room / path).is_file()] == []


def test_every_room_is_in_the_picture() -> None:
    texts = {text.get_text() for text in house.house().axes[0].texts}
    assert {room for rooms in house.layers() for room in rooms} <= texts
    assert {f"+ {what}" for what, _ in house.DOORS.values()} <= texts


def test_the_picture_is_up_to_date(repository: Path, tmp_path: Path) -> None:
    kept = repository / "docs/figures/house.svg"
    (version,) = re.findall(r"Matplotlib v([\d.]+)", kept.read_text(encoding="utf-8"))
    if version != mpl.__version__:
        pytest.skip(f"drawn by Matplotlib {version}, which sets letters in another way than {mpl.__version__}")
    assert verdict(PRODUCTS["figures/house.svg"], kept, tmp_path / "house.svg") == "up to date", (
        "run: python -m tools.make_docs figures/house.svg"
    )
