"""Renders a material: every pixel of a shape is one sample of a generated shader."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.document_images import DocumentImages
from mrm_mtlx.documents.files import is_left_open, names_nothing
from mrm_mtlx.documents.images import srgb_encoded, write_image
from mrm_mtlx.engines.base import DirectionalLight, Lighting, PointLight, SurfacePoints, evaluate_all
from mrm_mtlx.render import environment as environments
from mrm_mtlx.render.ordinary import ordinary_copy
from mrm_mtlx.render.shapes import EYE, camera_rays, intersect
from mrm_mtlx.shadergen import generate

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.engines.base import Engine, Program
    from mrm_mtlx.library import DataLibrary

# Samples per pixel along each axis.
OVERSAMPLING = 2
# Directions per sample of the shader's environment lookup.
_ENVIRONMENT_SAMPLES = 16
# Angle between light and eye in the "from aside" panels of a comparison [degrees].
COMPARISON_DEGREES = 30.0
# Irradiance of the light where the shape stands: a white diffuser that faces it has radiance 1.
IRRADIANCE = float(np.pi)
# Radiance around the shape where there is no environment: dark, but not black, so that outlines show.
BACKDROP = 0.004
_GAP = 4
# Samples that are evaluated at a time: each takes a thousand bytes on its way, and twelve in the picture.
_BAND = 1 << 19
# Memory that a picture takes while it is made and written, for each of its samples [bytes].
_BYTES_PER_SAMPLE = 48


@dataclass(frozen=True)
class PictureOptions:
    """The scene of a picture.

    Attributes
    ----------
    shape
        A name of `shapes.SHAPES`.
    light_degrees
        Angle of a directional light from the eye, to the right; None for a light at the eye.
    size
        Width and height of a panel in pixels.
    environment
        Latitude-longitude image, or None.
    compare
        Four panels instead of one: the ordinary and the retroreflective material, each lit from the eye and from aside.
    """

    shape: str
    light_degrees: float | None
    size: int
    environment: NDArray[np.floating] | None
    compare: bool


def memory(options: PictureOptions) -> int:
    """Bytes that a picture takes, beyond those that its material does."""
    panels = 4 if options.compare else 1
    return panels * (options.size * OVERSAMPLING) ** 2 * _BYTES_PER_SAMPLE


def render(
    element: Any, library: DataLibrary, reach: Reach, options: PictureOptions, engine: Engine
) -> NDArray[np.floating]:
    """Linear radiance of the picture, (height, width, 3), oversampled; the light's irradiance at the shape is pi.

    So a white diffuser that faces the light has radiance 1. The shader is of the first target of the engine, which runs
    it.

    Raises
    ------
    CompileError
        If the engine refuses the shader.
    ValueError
        If a texture cannot be read, a comparison is asked for of a material without a retroreflective lobe, or the
        engine lacks what the picture needs.
    """
    panels, images = [], DocumentImages(reach)
    for document in versions(element.getDocument(), options):
        shader = generate(document.getDescendant(element.getNamePath()), engine.targets[0], library)
        textures = {
            variable: _pixels(name, images)
            for variable, name in shader.files.items()
            if not (names_nothing(name) or is_left_open(name))
        }
        _refuse_lack(engine, options, textures)
        with engine.compile(shader, textures) as program:
            panels += [_panel(program, replace(options, light_degrees=angle)) for angle in light_angles(options)]
    return side_by_side(panels, _GAP * OVERSAMPLING)


def _refuse_lack(engine: Engine, options: PictureOptions, textures: Mapping[str, Any]) -> None:
    """Raise a ValueError if the engine cannot have a light, the environment or the images of a picture."""
    can = engine.capabilities
    lights = {type(_light(degrees)) for degrees in light_angles(options)}
    lacks = {
        "takes no such light": not lights <= can.lights,
        "takes no environment": options.environment is not None and not can.environment,
        "looks up no images": bool(textures) and not can.textures,
    }
    for lack in (words for words, lacking in lacks.items() if lacking):
        msg = f"{engine.name} {lack}"
        raise ValueError(msg)


def _pixels(name: str, images: DocumentImages) -> NDArray[Any]:
    pixels = images(name)
    if pixels is None:
        raise ValueError(images.problems[-1] if images.problems else f"{name}: there is no such file that may be read")
    return pixels


def versions(document: Any, options: PictureOptions) -> list[Any]:
    """The document, after its ordinary version where the options ask for a comparison.

    Raises
    ------
    ValueError
        As `render`, of a comparison.
    """
    return [ordinary_copy(document), document] if options.compare else [document]


def light_angles(options: PictureOptions) -> list[float | None]:
    """Angle of the light in each panel of one version; None is the headlight."""
    return [None, options.light_degrees or COMPARISON_DEGREES] if options.compare else [options.light_degrees]


def side_by_side(panels: Sequence[NDArray[np.floating]], gap: int = _GAP) -> NDArray[np.floating]:
    """Panels of one height beside each other, this many pixels apart."""
    if len(panels) == 1:
        return panels[0]
    between = np.full((panels[0].shape[0], gap, 3), BACKDROP, dtype=panels[0].dtype)
    return np.concatenate([part for panel in panels for part in (panel, between)][:-1], axis=1)


def write(
    radiance: NDArray[np.floating], path: Path, exposure: float | None, *, oversampling: int = OVERSAMPLING
) -> None:
    """Write a picture whole or not at all: EXR holds the linear radiance, PNG a tone-mapped version.

    Raises
    ------
    ValueError
        If the file cannot be written.
    """
    linear = path.suffix.lower() == ".exr"
    pixels = stored(radiance, exposure, oversampling, linear=linear)
    try:
        write_image(path, pixels, {"oiio:ColorSpace": "lin_rec709" if linear else "sRGB"})
    except OSError as error:
        msg = f"{path} cannot be written: {error.strerror or error}"
        raise ValueError(msg) from error


def stored(radiance: NDArray[np.floating], exposure: float | None, oversampling: int, *, linear: bool) -> NDArray[Any]:
    """A picture as a file has it: linear radiance in half precision, or tone-mapped in eight bits."""
    brightest = 1.0 if linear else _brightest(radiance, exposure)
    step = max(_BAND // radiance.shape[1] // oversampling, 1) * oversampling
    bands = (radiance[row : row + step].astype(float) for row in range(0, len(radiance), step))
    return np.concatenate([_stored(band, brightest, oversampling, linear=linear) for band in bands])


def _stored(radiance: Array, brightest: float, oversampling: int, *, linear: bool) -> NDArray[Any]:
    """Rows of a picture as the file has them."""
    pixels = reduced(radiance if linear else _shown(radiance, brightest), oversampling)
    return np.minimum(pixels, 65504.0).astype(np.float16) if linear else np.round(255.0 * pixels).astype(np.uint8)


# Where the scale of a picture turns from linear to logarithmic: well below a white diffuser, so that dark paint does
# not drown beside a headlight.
_FLOOR = 0.004


def tone_map(radiance: Array, exposure: float | None) -> Array:
    """sRGB values in [0, 1] on a logarithmic scale: retroreflection is a thousand times a white diffuser.

    y = log(1 + x / w) / log(1 + m / w), x the largest channel, w where the scale turns from linear to logarithmic, m
    the brightest of the picture (or, with an exposure in stops, 2^-exposure), hue and saturation kept. A compromise
    that shows the dark and the bright at once, not a camera.
    """
    return _shown(radiance, _brightest(radiance, exposure))


def _brightest(radiance: NDArray[np.floating], exposure: float | None) -> float:
    """Radiance that is shown as the brightest: of the picture, or by the exposure."""
    if exposure is not None:
        return float(2.0**-exposure)
    return max(float(np.quantile(np.max(radiance, axis=-1).astype(float), 0.999)), 1.0)


def _shown(radiance: Array, brightest: float) -> Array:
    peak = np.max(radiance, axis=-1, keepdims=True)
    scale = np.log1p(peak / _FLOOR) / np.log1p(brightest / _FLOOR)
    return np.asarray(np.clip(srgb_encoded(radiance / np.maximum(peak, 1e-12)) * np.minimum(scale, 1.0), 0.0, 1.0))


def _panel(program: Program, options: PictureOptions) -> NDArray[np.float32]:
    size = options.size * OVERSAMPLING
    environment = None
    if options.environment is not None:
        environment = environments.environment(options.environment, _ENVIRONMENT_SAMPLES)
    lighting = Lighting(_light(options.light_degrees), environment, tuple(float(x) for x in EYE))
    image = np.empty((size, size, 3), dtype=np.float32)
    step = max(_BAND // size, 1)
    for rows in (slice(row, row + step) for row in range(0, size, step)):
        rays = camera_rays(size, rows)
        image[rows] = _seen(program, options, rays, lighting).reshape(-1, size, 3)
    return image


def _seen(program: Program, options: PictureOptions, rays: Array, lighting: Lighting) -> Array:
    """Radiance that comes along rays, (rays, 3)."""
    hits = intersect(options.shape, rays)
    seen = np.flatnonzero(hits.found)
    image = np.full((len(rays), 3), BACKDROP)
    if options.environment is not None:
        image = environments.look_up(options.environment, rays)
    if len(seen):
        points = SurfacePoints(hits.position[seen], hits.normal[seen], hits.tangent[seen], hits.texcoord[seen])
        image[seen] = evaluate_all(program, points, lighting)[:, :3]
    return np.asarray(np.maximum(np.nan_to_num(image, nan=0.0), 0.0))


def _light(degrees: float | None) -> PointLight | DirectionalLight:
    if degrees is None:
        intensity = IRRADIANCE * (float(np.linalg.norm(EYE)) + 1.0) ** 2  # see PointLight
        return PointLight(tuple(float(x) for x in EYE), (intensity, intensity, intensity))
    return DirectionalLight(direction_of_light(degrees), (IRRADIANCE, IRRADIANCE, IRRADIANCE))


def direction_of_light(degrees: float) -> tuple[float, float, float]:
    """Unit vector to a light at this angle from the eye, to its right, seen from the origin."""
    angle, to_eye = np.deg2rad(degrees), EYE / np.linalg.norm(EYE)
    right = np.cross([0.0, 1.0, 0.0], to_eye)
    x, y, z = np.cos(angle) * to_eye + np.sin(angle) * right / np.linalg.norm(right)
    return float(x), float(y), float(z)


def reduced(image: Array, step: int) -> Array:
    """Mean over blocks of this many pixels on a side."""
    height, width = (n // step for n in image.shape[:2])
    blocks = image[: height * step, : width * step]
    return np.asarray(blocks.reshape(height, step, width, step, 3).mean(axis=(1, 3)))
