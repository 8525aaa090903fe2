"""Checks of arguments: what is refused, and how it is said."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from mrm_mtlx.system.arguments import (
    ArgumentError,
    check_angles,
    check_choice,
    check_positive,
    check_range,
    check_whole,
    one_or_more,
    path_of,
    refuse,
)


@pytest.mark.parametrize(
    ("check", "message"),
    [
        (lambda: refuse({"a": None, "b": 0.0}, "not here"), "b: not here"),
        (lambda: refuse({"a": (), "b": True}, "not here"), "b: not here"),
        (lambda: check_choice("a", "x", ("y", "z")), "a: 'x': expected one of y, z"),
        (lambda: check_range("a", 3, 4), "a: 3: expected 4 or more"),
        (lambda: check_range("a", float("nan"), 4, 1 << 22), "a: nan: expected 4 to 4194304"),
        (lambda: check_range("a", "3", 4), "a: '3': expected a number, 4 or more"),
        (lambda: check_whole("a", 3, 4), "a: 3: expected 4 or more"),
        (lambda: check_whole("a", 6.0, 4, 8), "a: 6.0: expected a whole number, 4 to 8"),
        (lambda: check_whole("a", None, 4), "a: None: expected a whole number, 4 or more"),
        (lambda: check_choice("a", ["y"], {"y": 1}), "a: ['y']: expected one of y"),
        (lambda: check_positive("a", "1"), "a: '1': expected a number above 0"),
        (lambda: check_angles("a", ["1"], -90.0, 90.0), "a: '1': expected an angle from -90 to 90 degrees"),
        (lambda: path_of("a", ["b"]), "a: ['b']: expected a path"),
        (lambda: path_of("a", b"b"), "a: b'b': expected a path"),
        (lambda: check_positive("a", 0.0), "a: 0: expected a number above 0"),
        (lambda: check_positive("a", float("inf")), "a: inf: expected a number above 0"),
        (lambda: check_angles("a", [3.0, 91.0], -90.0, 90.0), "a: 91: expected an angle from -90 to 90 degrees"),
    ],
)
def test_a_wrong_argument_is_named_with_what_was_expected(check, message):
    with pytest.raises(ArgumentError) as caught:
        check()
    assert str(caught.value) == message
    copied = pickle.loads(pickle.dumps(caught.value))
    assert (copied.message, copied.argument) == (caught.value.message, caught.value.argument)


@pytest.mark.parametrize("one", ["glsl", 20, 0.0, np.float32(0.2), Path("assets")])
def test_one_value_is_a_list_of_one(one):
    assert one_or_more(one) == one_or_more([one]) == (one,)


def test_what_is_right_or_not_given_passes():
    refuse({"a": None, "b": False, "c": (), "d": []}, "not here")
    check_choice("a", None, ("y",))
    check_choice("a", "y", ("y",))
    check_range("a", 4, 4, 4)
    check_whole("a", np.int64(4), 4, 4)
    assert path_of("a", "b") == path_of("a", Path("b")) == Path("b")
    assert one_or_more(None) == ()
    check_positive("a", None)
    check_positive("a", 1e-9)
    check_angles("a", [-90.0, 90.0], -90.0, 90.0)
