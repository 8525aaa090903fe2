"""A compiled shader: what it can be asked for, and its evaluation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from types import TracebackType

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base.lighting import Lighting

# Bits of the significand of float32, the precision that comparisons are made for.
FLOAT32_BITS = 24


@dataclass(frozen=True)
class Capabilities:
    """Abilities of the programs of an engine.

    Attributes
    ----------
    runs
        Whether `Program.evaluate` gives numbers; an engine that only compiles says no.
    textures
        Whether image files are looked up; without, the uniforms of files stay unbound.
    derivatives
        Whether the derivatives of the shading language are differences between neighbouring samples. Without, each
        sample stands alone and they are zero, as the reference has them.
    lights
        The types of `Lighting.light` that it takes.
    environment
        Whether it takes `Lighting.environment`.
    significand_bits
        Precision of its arithmetic: 24 for float32, 53 for float64.
    color_bits, color_step
        Precision of the colours that it gives, 11 for half floats, and the step between the smallest of them. Numbers
        of fewer bits than float32 may be cut off to their last bit and not rounded.
    materialx
        Version of the MaterialX that generates the code of its programs, "" for the installed one.
    largest_batch
        The most points of one evaluation; None for any number.
    """

    runs: bool = False
    textures: bool = False
    derivatives: bool = False
    lights: frozenset[type] = frozenset()
    environment: bool = False
    significand_bits: int = FLOAT32_BITS
    color_bits: int = FLOAT32_BITS
    color_step: float = 0.0
    materialx: str = ""
    largest_batch: int | None = None


@dataclass(frozen=True)
class SurfacePoints:
    """Points of a surface at which a program is evaluated, all in world space, which is object space as well.

    Attributes
    ----------
    position, normal, tangent : shape (points, 3)
    texcoord : shape (points, 2)
        Every set of texture coordinates.
    properties
        Geometric properties by name, (points,) or (points, components); those that are not given are zero.
    """

    position: NDArray[np.floating]
    normal: NDArray[np.floating]
    tangent: NDArray[np.floating]
    texcoord: NDArray[np.floating]
    properties: Mapping[str, NDArray[np.floating]] = field(default_factory=dict)

    def __len__(self) -> int:
        """The number of points."""
        return len(self.position)

    def part(self, where: slice) -> SurfacePoints:
        """Some of the points."""
        chosen = {f.name: getattr(self, f.name)[where] for f in fields(self) if f.name != "properties"}
        return replace(self, **chosen, properties={name: value[where] for name, value in self.properties.items()})

    def batches(self, largest: int | None) -> Iterator[SurfacePoints]:
        """The points in parts of at most `largest`."""
        step = largest or max(len(self), 1)
        yield from (self.part(slice(start, start + step)) for start in range(0, max(len(self), 1), step))


class Program(ABC):
    """A shader that an engine has compiled.

    Use it as a context manager, or call `release`: the memory of a driver is not the garbage collector's.
    """

    capabilities: Capabilities

    @abstractmethod
    def evaluate(
        self, points: SurfacePoints, lighting: Lighting, uniforms: Mapping[str, Any] | None = None
    ) -> NDArray[np.floating]:
        """Colours that the shader gives at points.

        Parameters
        ----------
        points
            At most `capabilities.largest_batch`; `evaluate_all` takes any number.
        lighting
            A light, an environment and an eye, of the kinds that the capabilities name.
        uniforms
            Values that replace those of the document in this evaluation, by variable name.

        Returns
        -------
        ndarray, shape (points, 4)
            The output colour, unclamped; the fourth channel is what the shader writes there.

        Raises
        ------
        KeyError
            If a uniform is named that the shader does not have.
        """

    def places(self, points: SurfacePoints, lighting: Lighting) -> SurfacePoints:
        """The points that are evaluated in the place of these; by default these.

        A renderer can shade the middles of its pixels alone: near the points that are asked for, and not there.
        """
        del lighting
        return points

    def release(self) -> None:  # noqa: B027 -- not all hold something
        """Free what the program holds; by default nothing."""

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release it."""
        self.release()


class CompiledOnly(Program):
    """A shader that a compiler took, and that cannot be run here."""

    capabilities = Capabilities()

    def evaluate(
        self, points: SurfacePoints, lighting: Lighting, uniforms: Mapping[str, Any] | None = None
    ) -> NDArray[np.floating]:
        """Raise a TypeError: callers ask `capabilities.runs` first."""
        del points, lighting, uniforms
        msg = "the program was compiled to be checked, not to be run"
        raise TypeError(msg)


def evaluate_all(
    program: Program, points: SurfacePoints, lighting: Lighting, uniforms: Mapping[str, Any] | None = None
) -> NDArray[np.floating]:
    """`Program.evaluate` over any number of points, in batches that the program takes."""
    batches = list(points.batches(program.capabilities.largest_batch))
    if len(batches) == 1:
        return program.evaluate(batches[0], lighting, uniforms)
    return np.concatenate([program.evaluate(part, lighting, uniforms) for part in batches])
