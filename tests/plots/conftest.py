"""What the tests of plots share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.plots.curves import LUMINANCE

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.plots.curves import Curve

# Relative, to the curve's highest value: a narrow lobe's directions are known to 2^-53 of a right angle, which is 1e-13
# of the narrowest width here, and a sine and a cosine round it a few times more.
SAME_VALUE = 1e-11


@pytest.fixture(scope="session")
def is_the_curve_of() -> Callable[..., bool]:
    """Whether a curve has the values of a function f(v, l) [1/sr] of colours, for directions made here."""

    def check(curve: Curve, f: Callable[..., np.ndarray], azimuth: float = 0.0, within: float = SAME_VALUE) -> bool:
        polar, turn = np.abs(curve.theta_v), azimuth + np.where(curve.theta_v < 0.0, np.pi, 0.0)
        v = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1)
        l = np.array([np.sin(curve.theta_l), 0.0, np.cos(curve.theta_l)])
        expected = f(v, l) @ LUMINANCE
        return bool(np.all(np.abs(curve.value - expected) <= within * expected.max()))

    return check
