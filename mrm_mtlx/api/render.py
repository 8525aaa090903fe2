"""A picture of a material."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from mrm_mtlx.api.errors import UnavailableError
from mrm_mtlx.api.generate import check_library
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.api.opening import LibraryName, OpenDocument, PathLike, open_document
from mrm_mtlx.system import child
from mrm_mtlx.system.arguments import ArgumentError, check_choice, check_range, check_whole, path_of, refuse
from mrm_mtlx.system.writing import check_folder

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from mrm_mtlx.api.generate import OslModeName
    from mrm_mtlx.engines.base import Engine
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.render.picture import PictureOptions

# Endings of files, and bounds of what is asked for.
SUFFIXES = (".png", ".exr")
SMALLEST, LARGEST = 16, 4096
MOST_PATHS = 1 << 16
DEFAULT_PATHS = 64


@dataclass(frozen=True, eq=False, repr=False)
class Picture:
    """A picture. As an array (`np.asarray`), its linear radiance; a notebook shows it tone-mapped.

    Attributes
    ----------
    samples : shape (height, width, 3)
        Linear radiance, `oversampling` samples per pixel along each axis.
    oversampling
    exposure
        Stops over a white diffuser with which it is shown; None fits it to the picture.
    findings
        What is to be said of the document.
    """

    samples: NDArray[np.floating]
    oversampling: int
    exposure: float | None
    findings: tuple[Finding, ...]

    @property
    def radiance(self) -> NDArray[np.floating]:
        """Linear radiance, (height, width, 3); a white diffuser that faces the light has 1."""
        from mrm_mtlx.render.picture import reduced

        return reduced(self.samples.astype(float), self.oversampling)

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """sRGB, (height, width, 3), on a logarithmic scale of light."""
        from mrm_mtlx.render.picture import stored

        return stored(self.samples, self.exposure, self.oversampling, linear=False)

    def save(self, path: PathLike) -> None:
        """Write it: EXR holds the linear radiance, PNG what is shown.

        Raises
        ------
        ArgumentError
            If the name has another ending, or the file cannot be written.
        """
        self._write(Path(path), "path")

    def _write(self, path: Path, argument: str) -> None:
        from mrm_mtlx.render import picture

        _check_output(path, argument)
        try:
            picture.write(self.samples, path, self.exposure, oversampling=self.oversampling)
        except ValueError as error:
            raise ArgumentError(str(error)) from error

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        radiance = self.radiance
        return radiance if dtype is None else radiance.astype(dtype)

    def __repr__(self) -> str:
        height, width = (n // self.oversampling for n in self.samples.shape[:2])
        return f"<Picture of {width} x {height} pixels, radiance up to {float(self.samples.max()):.4g}>"

    def _repr_png_(self) -> bytes:
        with tempfile.TemporaryDirectory(prefix="mrm-") as folder:
            file = Path(folder) / "picture.png"
            self.save(file)
            return file.read_bytes()


def render(
    path: PathLike | OpenDocument,
    *,
    shape: Literal["sphere", "plane", "cone"] = "sphere",
    light: str | float = "headlight",
    environment: PathLike | None = None,
    compare: bool = False,
    size: int = 384,
    exposure: float | None = None,
    element: str | None = None,
    engine: str | None = None,
    paths: int | None = None,
    seed: int = 0,
    osl_mode: OslModeName | None = None,
    library: LibraryName = "mrm",
    root: PathLike | Sequence[PathLike] = (),
    output: PathLike | None = None,
    listener: Listener = SILENT,
) -> Picture:
    """Render a material on a sphere, plane or cone under a headlight, a light at an angle, and an environment.

    Parameters
    ----------
    path
        A document.
    shape
        What carries the material.
    light
        "headlight", at the eye, or its angle from the eye [degrees].
    environment
        Latitude-longitude image that surrounds it.
    compare
        Four panels: ordinary and retroreflective, each lit from the eye and from aside.
    size
        Width and height of a panel in pixels.
    exposure
        Stops over a white diffuser; default: fitted to the picture.
    element
        Renderable element; default: the first.
    engine
        What renders, see `doctor`. Default: the generated GLSL in OpenGL.
    paths
        Paths per pixel, with an engine that traces paths. Default: 64.
    seed
        Of the paths.
    osl_mode
        How OSL makes a retroreflective lobe, with an engine that traces paths. Default: aligned.
    library
        Whose implementation of the flag: this project's or MaterialX's ("upstream").
    root
        Folders from which files may be read besides the document's own.
    output
        A .png or .exr file to write, if any.
    listener
        Told of findings, progress and the file.

    Raises
    ------
    ArgumentError
        If the call is wrong.
    UnavailableError
        If the engine does not work here.
    DocumentError
        If the document cannot be used; ShaderError if MaterialX or the engine refuses the surface.
    """
    from mrm_mtlx.shadergen import OslMode

    target = None if output is None else path_of("output", output)
    if target is not None:
        _check_output(target, "output")
    _check_numbers(size, exposure, paths, seed)
    chosen = _engine(engine)
    check_library(chosen.targets, library, "engine")
    if not _traces_paths(chosen):
        of_paths = {"paths": paths, "seed": seed or None, "osl_mode": osl_mode}
        refuse(of_paths, f"only with an engine that traces paths: `engine` {' or '.join(_tracers())}")
    angle = _light_angle(light)
    check_choice("shape", shape, ("sphere", "plane", "cone"))
    check_choice("osl_mode", osl_mode, tuple(OslMode))
    available = chosen.availability()
    if not available.available:
        msg = f"{available.detail}; to add it: {available.remedy}"
        raise UnavailableError(msg)
    opened = open_document(path, element=element, library=library, root=root, listener=listener)
    job = _Job(opened, chosen, (shape, angle, size, compare), environment, listener)
    samples, oversampling = job.done(DEFAULT_PATHS if paths is None else paths, seed, str(osl_mode or "aligned"))
    found = Picture(samples, oversampling, exposure, opened.findings)
    if target is not None:
        found._write(target, "output")
        listener.wrote(target)
    return found


@dataclass(frozen=True)
class _Job:
    """A picture that is to be made."""

    opened: OpenDocument
    engine: Engine
    scene: tuple[str, float | None, int, bool]
    environment: PathLike | None
    listener: Listener = field(repr=False)

    def done(self, paths: int, seed: int, mode: str) -> tuple[NDArray[np.floating], int]:
        """The samples, and how many there are per pixel along each axis."""
        from mrm_mtlx.documents.document_images import ImagesTooLargeError
        from mrm_mtlx.engines.base import CompileError, EngineFailure
        from mrm_mtlx.findings import rules
        from mrm_mtlx.render import picture
        from mrm_mtlx.shadergen import GenerationError

        name = self.opened.elements[0]
        try:
            options = self._options()
            child.allow(picture.memory(options))
            if self.engine.scene_renderer is not None:
                return self._scene(options, paths, seed, mode), 1
            surface = (self.opened.element(name), self.opened.library, self.opened.source.reach)
            return picture.render(*surface, options, self.engine), picture.OVERSAMPLING
        except ImagesTooLargeError as error:
            msg = f"{self.opened.path} has {error}"
            raise ArgumentError(msg, "path") from error
        except ArgumentError:
            raise
        except ValueError as error:
            raise ArgumentError(str(error)) from error
        except GenerationError as error:
            raise self.opened.shader_error(rules.SHADER_GENERATE, name, error) from error
        except CompileError as error:
            raise self.opened.shader_error(rules.SHADER_COMPILE, name, error) from error
        except EngineFailure as error:
            raise UnavailableError(str(error)) from error

    def _options(self) -> PictureOptions:
        from mrm_mtlx.documents.images import read_image
        from mrm_mtlx.render.picture import PictureOptions

        shape, angle, size, compare = self.scene
        try:
            environment = None if self.environment is None else read_image(path_of("environment", self.environment))
        except ValueError as error:
            raise ArgumentError(getattr(error, "message", str(error)), "environment") from error
        return PictureOptions(str(shape), angle, size, environment, compare)

    def _scene(self, options: PictureOptions, paths: int, seed: int, mode: str) -> NDArray[np.floating]:
        from mrm_mtlx.render import scenes
        from mrm_mtlx.shadergen import OslMode

        assert self.engine.scene_renderer is not None
        document = self.opened.document.copy()  # the names of its files are changed
        return scenes.render(
            document.getDescendant(self.opened.elements[0]),
            self.opened.library,
            self.opened.source.reach,
            options,
            self.engine.scene_renderer,
            paths=paths,
            seed=seed,
            mode=OslMode(mode),
            progress=self.listener.progress,
        )


def engine_names() -> list[str]:
    """Names of the engines that render, in the order of the registry."""
    from mrm_mtlx.engines import registry

    return [name for name, engine in registry.engines().items() if registry.renders(engine)]


def _tracers() -> list[str]:
    from mrm_mtlx.engines import registry

    return [name for name, engine in registry.engines().items() if _traces_paths(engine)]


def _traces_paths(engine: Engine) -> bool:
    return engine.scene_renderer is not None and engine.scene_renderer.traces_paths


def _engine(name: str | None) -> Engine:
    from mrm_mtlx.engines import registry

    names = engine_names()
    check_choice("engine", name, names)
    return registry.engines()[name or names[0]]


def _check_output(path: Path, argument: str) -> None:
    if path.suffix.lower() not in SUFFIXES:
        msg = f"{path}: expected a name that ends in {' or '.join(SUFFIXES)}"
        raise ArgumentError(msg, argument)
    check_folder(path, argument)


def _check_numbers(size: int, exposure: float | None, paths: int | None, seed: int) -> None:
    check_whole("size", size, SMALLEST, LARGEST)
    check_whole("paths", DEFAULT_PATHS if paths is None else paths, 1, MOST_PATHS)
    check_whole("seed", seed, 0)
    if exposure is not None:
        check_range("exposure", exposure, -100.0, 100.0)


def _light_angle(light: str | float) -> float | None:
    """Angle of the light from the eye in degrees, None for the headlight."""
    if light == "headlight":
        return None
    try:
        angle = float(light)
    except (TypeError, ValueError):
        msg = f"'{light}': expected headlight or an angle in degrees"
        raise ArgumentError(msg, "light") from None
    if not -180.0 <= angle <= 180.0:
        msg = f"{light}: expected an angle from -180 to 180 degrees"
        raise ArgumentError(msg, "light")
    return angle
