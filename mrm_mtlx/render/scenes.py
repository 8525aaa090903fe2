"""Renders a material on a mesh, with an engine that makes whole pictures."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.document_images import refuse_excess
from mrm_mtlx.documents.filenames import filenames, rename_files
from mrm_mtlx.engines.base import Scene, Take, looking_along, point, sun
from mrm_mtlx.render import picture
from mrm_mtlx.render.environment import look_up
from mrm_mtlx.render.meshes import mesh
from mrm_mtlx.render.shapes import EYE, HALF_FIELD, camera_rays
from mrm_mtlx.shadergen import OslMode, generate

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.engines.base import SceneRenderer
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.render.picture import PictureOptions

# Paths per pixel of one request to the renderer: the pace of the progress bar.
_PASS = 16
# A path's reflections; the shapes are convex, so light comes from the lamp, the environment, or through a portal.
_BOUNCES = 4


def render(
    element: Any,
    library: DataLibrary,
    reach: Reach,
    options: PictureOptions,
    renderer: SceneRenderer,
    *,
    paths: int = 64,
    seed: int = 0,
    mode: OslMode = OslMode.ALIGNED,
    progress: Callable[[int, int], None] | None = None,
) -> NDArray[np.floating]:
    """Linear radiance of the picture, (height, width, 3); camera, light and scale as `picture.render` has them.

    Parameters
    ----------
    element, library, reach, options
        As `picture.render`; the document of `element` gets absolute names of its image files.
    renderer
        What renders.
    paths
        Paths per pixel; above 16, rounded up to a multiple of it.
    seed
        Fixes the noise.
    mode
        How the node library makes retroreflective lobes.
    progress
        Called with (finished, all) requests.

    Raises
    ------
    GenerationError
        If MaterialX refuses.
    CompileError
        If the engine refuses the shader.
    EngineFailure
        If there is no renderer, or it dies.
    ValueError
        If an image cannot be read, there are too many, or a comparison is asked for of a material without a
        retroreflective lobe.
    """
    refuse_excess((name for _, name in filenames(element.getDocument())), reach)
    rename_files(element.getDocument(), lambda name: str(reach.resolve(name) or ""))
    shaders = [
        generate(document.getDescendant(element.getNamePath()), renderer.target, library, mode)
        for document in picture.versions(element.getDocument(), options)
    ]
    compiled = [renderer.compile(shader) for shader in shaders]
    panels = [(shown, degrees) for shown in compiled for degrees in picture.light_angles(options)]
    passes = -(-paths // _PASS) if renderer.traces_paths else 1
    oversampling = 1 if renderer.traces_paths else picture.OVERSAMPLING
    size = options.size * oversampling
    scene = _scene(replace(options, size=size), min(paths, _PASS))
    images = []
    for index, (shown, degrees) in enumerate(panels):
        total = np.zeros((size, size, 4))
        for number in range(passes):
            (image,) = renderer.render(shown, scene, [Take([_light(degrees)])], seed=seed + number)
            total += image
            if progress:
                progress(index * passes + number + 1, len(panels) * passes)
        images.append(picture.reduced(_on_backdrop(total / passes, options), oversampling))
    return picture.side_by_side(images)


def _scene(options: PictureOptions, paths: int) -> Scene:
    shape = mesh(options.shape)
    arrays: dict[str, Any] = {
        "vertices": shape.vertices.astype(np.float32),
        "faces": shape.faces,
        "normals": shape.normals.astype(np.float32),
        "uv": shape.texcoords.astype(np.float32),
    }
    world: dict[str, Any] = {}
    if options.environment is not None:
        arrays["environment"] = np.asarray(options.environment[..., :3], dtype=np.float32)
    to_eye = EYE / np.linalg.norm(EYE)
    camera = {
        "field": float(2.0 * np.arctan(HALF_FIELD)),
        "resolution": [options.size, options.size],
        "clip": [0.1, 100.0],
        "filter_width": 1.0,
        "alone": False,
        "matrix": looking_along(to_eye.tolist(), EYE.tolist()),
    }
    return Scene(arrays, camera, world, paths, _BOUNCES)


def _light(degrees: float | None) -> dict[str, Any]:
    if degrees is None:
        return point(EYE.tolist(), picture.IRRADIANCE * float(EYE @ EYE))
    return sun(picture.direction_of_light(degrees), picture.IRRADIANCE, shadow=True)


def _on_backdrop(image: Array, options: PictureOptions) -> Array:
    """The picture without its alpha, on the environment or the backdrop, as `picture` shows them."""
    colour, alpha = image[..., :3], np.clip(image[..., 3:], 0.0, 1.0)
    behind: Array | float = picture.BACKDROP
    if options.environment is not None and np.any(alpha < 1.0):  # a renderer may show it itself
        behind = look_up(options.environment, camera_rays(len(image))).reshape(colour.shape)
    colour = colour + (1.0 - alpha) * behind
    return np.asarray(np.maximum(np.nan_to_num(colour, nan=0.0), 0.0))
