"""The environment of a picture, and the irradiance that it gives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.engines.base import Environment

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array

# The irradiance is smooth: a coarse image of it, from a coarse image of the radiance, is exact to a few per mille.
_ROWS = 32


def environment(image: NDArray[np.floating], samples: int) -> Environment:
    """An environment from a latitude-longitude image of radiance, shape (height, width, channels), row 0 at +y."""
    radiance = image[..., :3] if image.shape[-1] >= 3 else np.repeat(image[..., :1], 3, -1)
    return Environment(radiance, irradiance_over_pi(radiance), samples)


def irradiance_over_pi(radiance: NDArray[np.floating]) -> Array:
    """Cosine-weighted mean of the radiance over the hemisphere about each direction, (rows, 2 rows, 3)."""
    coarse = _shrink(radiance, min(_ROWS, radiance.shape[0]))
    directions, solid_angle = latlong_directions(coarse.shape[0], coarse.shape[1])
    targets, _ = latlong_directions(_ROWS, 2 * _ROWS)
    cosines = np.maximum(targets.reshape(-1, 3) @ directions.reshape(-1, 3).T, 0.0) * solid_angle.ravel()
    # Normalised by the weights that the coarse grid has, so that a constant environment gives exactly its constant.
    total = cosines @ coarse.reshape(-1, 3) / np.sum(cosines, axis=1, keepdims=True)
    return np.asarray(total).reshape(_ROWS, 2 * _ROWS, 3)


def latlong_directions(height: int, width: int) -> tuple[Array, Array]:
    """Direction and solid angle of each pixel: (height, width, 3) and (height, width).

    The inverse of MaterialX's projection: longitude atan2(x, -z), the centre column at -z, row 0 at +y.
    """
    latitude = (0.5 - (np.arange(height) + 0.5) / height) * np.pi
    longitude = ((np.arange(width) + 0.5) / width * 2.0 - 1.0) * np.pi
    cosine = np.cos(latitude)[:, None]
    shape = (height, width)
    directions = np.stack(
        [
            cosine * np.sin(longitude),
            np.broadcast_to(np.sin(latitude)[:, None], shape),
            -cosine * np.cos(longitude),
        ],
        axis=-1,
    )
    return directions, np.broadcast_to(cosine * (np.pi / height) * (2.0 * np.pi / width), shape)


def look_up(radiance: NDArray[np.floating], directions: Array) -> Array:
    """Nearest pixel of a latitude-longitude image in these directions, (samples, 3)."""
    height, width = radiance.shape[:2]
    row = (0.5 - np.arcsin(np.clip(directions[:, 1], -1.0, 1.0)) / np.pi) * height
    column = (np.arctan2(directions[:, 0], -directions[:, 2]) / (2.0 * np.pi) + 0.5) * width
    rows, columns = np.clip(row.astype(int), 0, height - 1), column.astype(int) % width
    return np.asarray(radiance[rows, columns, :3], dtype=float)


def _shrink(image: NDArray[np.floating], rows: int) -> Array:
    """Mean over blocks, down to at most `rows` rows and twice as many columns."""
    step_y, step_x = max(image.shape[0] // rows, 1), max(image.shape[1] // (2 * rows), 1)
    height, width = image.shape[0] // step_y * step_y, image.shape[1] // step_x * step_x
    blocks = image[:height, :width].reshape(height // step_y, step_y, width // step_x, step_x, 3)
    return np.asarray(blocks.mean(axis=(1, 3), dtype=float))
