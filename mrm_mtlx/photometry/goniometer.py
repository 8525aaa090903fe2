"""The goniometer of CIE and ASTM: observation and entrance angles to directions in the sample's frame, and back.

The observation angle is that between l and v. The observation half-plane ends at the line of l and contains v; the
first axis is perpendicular to it. beta1 turns about the first axis, positive towards v; beta2 goes from the observation
plane to n. The second axis e2 is perpendicular to n and the first axis; the rotation epsilon is that about n from e2 to
the tangent t. With m = n x e2, and in the coordinates (e2, m, n),

    u(q) = (-sin q, -cos q sin beta2, cos q cos beta2)        l = u(beta1)        v = u(beta1 - observation)

so that n.l = cos beta1 cos beta2 and n.v = cos beta2 cos(beta1 - observation). The sign of beta1 is that of 16 CFR
1512.18(o): positive if v lies between l and n. For the sign of beta2 and the sense of epsilon, gamma and omega_s no
source could be read; the other choice mirrors the sample, see `MIRRORED`.

All angles are in radians and broadcast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf.vectors import components, dot

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# The choice that no source was read for. True turns over beta2, epsilon, gamma and omega_s together, which is the
# mirror image y -> -y of the sample. What is isotropic, or has that mirror symmetry, does not notice.
MIRRORED = False


def directions(
    observation: ArrayLike,
    beta1: ArrayLike,
    beta2: ArrayLike = 0.0,
    epsilon: ArrayLike = 0.0,
    *,
    mirrored: bool = MIRRORED,
) -> tuple[Array, Array]:
    """Directions v and l of a geometry, in the local frame (t, n x t, n).

    Parameters
    ----------
    observation : array_like, shape (...)
        Angle between l and v [rad], >= 0.
    beta1, beta2 : array_like, shape (...)
        Components of the entrance angle [rad].
    epsilon : array_like, shape (...)
        Rotation of the sample about its normal [rad].
    mirrored
        See `MIRRORED`.

    Returns
    -------
    tuple of ndarray, shape (..., 3)
        v and l, unit. They may lie below the surface.

    Examples
    --------
    >>> v, l = directions(np.deg2rad(0.2), np.deg2rad(-4.0))
    >>> [round(float(np.rad2deg(np.arccos(w[2]))), 6) for w in (v, l)]
    [4.2, 4.0]
    """
    observation, beta1, beta2, epsilon = np.broadcast_arrays(
        *(np.asarray(angle, dtype=float) for angle in (observation, beta1, beta2, epsilon))
    )

    def turned(q: Array) -> Array:
        across, along = -np.sin(q), -np.cos(q) * np.sin(beta2)
        x = np.cos(epsilon) * across + np.sin(epsilon) * along
        y = np.cos(epsilon) * along - np.sin(epsilon) * across
        return np.stack([x, -y if mirrored else y, np.cos(q) * np.cos(beta2)], axis=-1)

    return turned(beta1 - observation), turned(beta1)


def angles(v: ArrayLike, l: ArrayLike, *, mirrored: bool = MIRRORED) -> tuple[Array, Array, Array, Array]:
    """Observation, beta1, beta2 and epsilon of a pair of directions: the inverse of `directions`.

    Parameters
    ----------
    v, l : array_like, shape (..., 3)
        Unit, in the local frame; they broadcast.
    mirrored
        See `MIRRORED`.

    Returns
    -------
    tuple of ndarray, shape (...)
        Observation in [0, pi], beta1 and epsilon in [-pi, pi], beta2 in [-pi/2, pi/2]. Where v = l there is no
        observation plane; then it is the one that holds the normal, beta2 = 0 and beta1 >= 0. Where l is the normal
        too, epsilon is 0. As v - l loses digits, so do beta1, beta2 and epsilon: by 1e-16 / observation.
    """
    handed = np.array([1.0, -1.0 if mirrored else 1.0, 1.0])
    to_v, to_l = np.broadcast_arrays(components("v", v) * handed, components("l", l) * handed)
    toward = _without(to_v - to_l, to_l)
    sine = np.sqrt(dot(toward, toward))
    # Without an observation plane: that of the normal; without that, too: that of the tangent at epsilon = 0, where
    # e2 = t and v leans to +t.
    for substitute in ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]):
        missing = dot(toward, toward) == 0.0
        toward = np.where(missing[..., None], _without(np.broadcast_to(substitute, to_l.shape), to_l), toward)
    x = toward / np.sqrt(dot(toward, toward))[..., None]
    first_axis = np.cross(to_l, x)
    observation = np.arctan2(sine, dot(to_l, to_v))
    beta1 = np.arctan2(x[..., 2], to_l[..., 2])
    beta2 = np.arctan2(first_axis[..., 2], np.hypot(x[..., 2], to_l[..., 2]))
    # e2 = first axis x n = cos(beta2) (cos epsilon, -sin epsilon, 0).
    epsilon = np.arctan2(first_axis[..., 0], first_axis[..., 1])
    return observation, beta1, beta2, epsilon


def to_application(beta1: ArrayLike, beta2: ArrayLike, epsilon: ArrayLike) -> tuple[Array, Array, Array]:
    """Entrance angle beta, azimuth gamma and rotation omega_s, the angles of applications.

    tan(beta1) = tan(beta) cos(gamma), sin(beta2) = -sin(beta) sin(gamma), and
    omega_s = epsilon - atan2(cos(beta1) sin(beta2), sin(beta1)), counted from the trace of
    the entrance half-plane to t.

    Returns
    -------
    tuple of ndarray, shape (...)
        beta in [0, pi], gamma and omega_s in [-pi, pi] [rad]; gamma is 0 where beta is.
    """
    beta1, beta2, epsilon = (np.asarray(angle, dtype=float) for angle in (beta1, beta2, epsilon))
    along, across = np.sin(beta1) * np.cos(beta2), np.sin(beta2)
    beta = np.arctan2(np.hypot(along, across), np.cos(beta1) * np.cos(beta2))
    gamma = np.arctan2(-across, along)
    return beta, gamma, _wrapped(epsilon - np.arctan2(np.cos(beta1) * across, np.sin(beta1)))


def from_application(beta: ArrayLike, gamma: ArrayLike, omega_s: ArrayLike) -> tuple[Array, Array, Array]:
    """The inverse of `to_application`: beta1, beta2 and epsilon [rad]."""
    beta, gamma, omega_s = (np.asarray(angle, dtype=float) for angle in (beta, gamma, omega_s))
    along, across = np.sin(beta) * np.cos(gamma), -np.sin(beta) * np.sin(gamma)
    beta1 = np.arctan2(along, np.cos(beta))
    beta2 = np.arctan2(across, np.hypot(along, np.cos(beta)))
    return beta1, beta2, _wrapped(omega_s + np.arctan2(np.cos(beta1) * np.sin(beta2), np.sin(beta1)))


def entrance(beta1: ArrayLike, beta2: ArrayLike = 0.0) -> Array:
    """The entrance angle beta between l and n [rad], cos(beta) = cos(beta1) cos(beta2)."""
    return to_application(beta1, beta2, 0.0)[0]


def _without(a: Array, l: Array) -> Array:
    """The part of a that is perpendicular to l."""
    return np.asarray(a - dot(a, l)[..., None] * l)


def _wrapped(angle: Array) -> Array:
    """The same angle in [-pi, pi]."""
    return np.asarray(np.arctan2(np.sin(angle), np.cos(angle)))
