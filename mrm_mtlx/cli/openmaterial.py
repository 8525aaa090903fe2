"""The block of OpenMATERIAL 3D on the command line: written, merged into a file, or compared with one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

if TYPE_CHECKING:
    from mrm_mtlx.formats.openmaterial import Geometry, OpenMaterialFile
    from mrm_mtlx.photometry.coefficients import Brdf

# R_A of a file and of a document that are called equal: labs state some percent, files a few digits.
EQUAL_WITHIN = 0.01


class Options(NamedTuple):
    """Options of `mrm convert` that are for this format alone."""

    into: Path | None
    at: str | None
    compare: Path | None
    observation: float | None
    entrance: float | None
    element: str | None


def convert(path: Path, output: Path | None, options: Options, roots: list[Path] | None) -> None:
    """Write a document's coefficient of retroreflection, or compare it with that of a file.

    Raises
    ------
    typer.BadParameter, typer.Exit
        If the call or a file is wrong; Exit with 1 also if the values differ.
    """
    from mrm_mtlx.formats import openmaterial

    into, at, compare, observation, entrance, element = options
    if at is not None and into is None:
        raise typer.BadParameter("only with --into, whose objects it names", param_hint="--at")
    source = compare or into
    try:
        file = None if source is None else openmaterial.read(source)
    except (ValueError, OSError) as error:
        raise typer.BadParameter(str(error), param_hint="--compare" if compare else "--into") from error
    stated = file.block.geometry if compare and file is not None and file.block is not None else None
    geometry = _geometry(observation, entrance, stated or openmaterial.Geometry())
    brdf = _brdf(path, element, roots)
    if compare is not None:
        assert file is not None
        _compare(file, compare, brdf, geometry)
        return
    assert output is not None
    try:
        block = openmaterial.of_brdf(brdf, path.name, geometry)
        openmaterial.write(openmaterial.merged(file, block, at or ""), output)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    except OSError as error:
        message = f"{output} cannot be written: {error.strerror}"
        raise typer.BadParameter(message, param_hint="OUTPUT") from error
    typer.echo(f"wrote {output}", err=True)


def _geometry(observation: float | None, entrance: float | None, default: Geometry) -> Geometry:
    from mrm_mtlx.formats.openmaterial import Geometry

    given = Geometry(
        default.observation_deg if observation is None else observation,
        default.entrance_deg if entrance is None else entrance,
    )
    for value, lower, name in zip(given, (0.0, -90.0), ("--observation", "--entrance"), strict=True):
        if not lower <= value <= 90.0:
            raise typer.BadParameter(f"{value:g}: expected {lower:g} to 90 degrees", param_hint=name)
    return given


def _brdf(path: Path, element: str | None, roots: list[Path] | None) -> Brdf:
    """The BRDF of the document's first surface, or the named one."""
    import numpy as np

    from mrm_mtlx.cli.documents import open_surfaces
    from mrm_mtlx.photometry import surface_brdf

    chosen = open_surfaces(path, element, roots)[0]
    brdf = surface_brdf(chosen.surface)
    normal = np.array([0.0, 0.0, 1.0])
    try:
        brdf(normal, normal)  # images are read when they are needed, and what is wrong with them is known then
    except ValueError as error:
        raise typer.BadParameter(f"{path} has {error}", param_hint="PATH") from error
    chosen.refuse_missing_images()
    return brdf


def _compare(file: OpenMaterialFile, path: Path, brdf: Brdf, geometry: Geometry) -> None:
    """Print both values; exit status 1 if they differ."""
    from mrm_mtlx.formats import openmaterial

    if file.block is None:
        raise typer.BadParameter(f"{path.name} has no {openmaterial.BLOCK}", param_hint="--compare")
    try:
        value = openmaterial.r_a(brdf, geometry)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    stated = "as the file states" if file.block.geometry == geometry else "the file states other angles or none"
    angles = f"observation {geometry.observation_deg:g} deg, entrance {geometry.entrance_deg:g} deg ({stated})"
    equal = abs(value - file.block.coefficient) <= EQUAL_WITHIN * max(value, file.block.coefficient)
    typer.echo(f"R_A, cd/(lx m^2), at {angles}: document {value:.6g}, file {file.block.coefficient:.6g}")
    typer.echo(f"{'PASSED' if equal else 'FAILED'}  {'equal' if equal else 'different'} within {EQUAL_WITHIN:.0%}")
    if not equal:
        raise typer.Exit(1)
