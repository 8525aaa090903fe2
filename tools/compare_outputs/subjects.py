"""The commands that are compared, by subject."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

# The folders of the old checkout that have the documents and data.
DOCUMENTS = ("materials", "materials_classes", "tests/rules", "tools/fuzz/seeds")
_TARGETS = ("glsl", "essl", "vulkan", "msl", "slang", "wgsl", "osl", "mdl")
_STAGES = (".usda", ".usd", ".usdc", ".usdz", ".gltf", ".glb")
# Where a few materials stand for all: layers, the library's own nodes, a surface model.
_FEW = ("materials/cats_eye.mtlx", "materials/embossed_foil.mtlx", "materials/segmented_trim.mtlx")
# Seconds that a document may take, also while other programs run; one of them never ends.
_LIMIT_S = 120


@dataclass(frozen=True)
class Run:
    """Commands on the same data, one after the other until one fails; {out} is the folder for what they write."""

    name: str
    steps: tuple[str, ...]


def validate(folders: Sequence[str], _: Path) -> Iterator[Run]:
    """Reports on all documents."""
    for folder in sorted(set(folders) - {"tools/fuzz/seeds"}, reverse=True):  # those that take longest come first
        options = f"--format json --samples 4096 -j 1 --timeout {_LIMIT_S}"
        yield Run(folder, (f"validate {shlex.quote(folder)} {options}",))


def conformance(*_: object) -> Iterator[Run]:
    """Figures of the nodes, as continuous integration has them computed, with fewer samples."""
    gl = "--target glsl --target essl"
    yield Run("osl", ("conformance --target osl --samples 16384 --format json",))
    yield Run("gl", (f"conformance {gl} --samples 16384 --format json",))
    yield Run("upstream", (f"conformance {gl} --library upstream --samples 16384 --format json",))


def vectors(*_: object) -> Iterator[Run]:
    """Test vectors."""
    for form in ("csv", "json", "text"):
        yield Run(form, (f"vectors --format {form}",))


def photometry(*_: object) -> Iterator[Run]:
    """Coefficients of the materials, and judged by their classes."""
    yield Run("list", ("photometry --list",))
    for folder in ("materials_classes", "materials"):
        yield Run(folder, tuple(f"photometry {folder} --format {form}" for form in ("json", "text")))
    document = "materials/hi_vis_tape_silver.mtlx"
    judged = f"photometry {document} --standard 'EN ISO 20471' --format"
    yield Run("judged", (f"{judged} json", f"{judged} text"))
    yield Run("apertures", (f"photometry {document} --source-aperture 0.1 --receiver-aperture 0.1 --format json",))
    yield Run("plotted", (f"photometry {document} --plot {{out}}/plot.svg",))


def convert(folders: Sequence[str], place: Path) -> Iterator[Run]:
    """Documents in other formats and back, and files of other formats as documents."""
    for path in _files(folders, place, (".mtlx",)):
        for ending in ("usda", "gltf"):
            forth = f"convert {shlex.quote(path)} {{out}}/forth.{ending} --timeout {_LIMIT_S}"
            yield Run(f"{ending}/{path}", (forth, f"convert {{out}}/forth.{ending} {{out}}/back.mtlx"))
        if path.startswith("materials"):
            yield Run(f"json/{path}", (f"convert {shlex.quote(path)} {{out}}/forth.json",))
    for path in _files(folders, place, _STAGES):
        yield Run(f"mtlx/{path}", (f"convert {shlex.quote(path)} {{out}}/forth.mtlx --timeout {_LIMIT_S}",))


def generate(*_: object) -> Iterator[Run]:
    """Sources for all targets, and of each way of writing them."""
    for document in _FEW:
        command = f"generate {document} -o {{out}}"
        for target in _TARGETS:
            yield Run(f"{target}/{document}", (f"{command} --target {target}",))
        for mode in ("cycles", "keyword"):
            yield Run(f"osl_{mode}/{document}", (f"{command} --target osl --osl-mode {mode}",))
        yield Run(f"upstream/{document}", (f"{command} --library upstream",))


def plot(*_: object) -> Iterator[Run]:
    """Curves of lobes."""
    for document in _FEW:
        yield Run(document, (f"plot {document} -o {{out}}/plot.svg --light 30 --azimuth 10",))
    yield Run("figures", ("plot --figure all -o {out}",))
    for model in ("schlick", "conductor", "dielectric", "eon", "lambert"):
        yield Run(model, (f"plot --model {model} -o {{out}}/plot.svg --scale polar",))


def fit(*_: object) -> Iterator[Run]:
    """Materials from small data."""
    for name in ("samples.csv", "coefficients.csv"):
        step = f"fit tools/fuzz/seeds/{name} -o {{out}}/fit.mtlx --plot {{out}}/fit.svg --format"
        yield Run(name, (f"{step} json", f"{step} text"))
    yield Run("tape.alta", ("fit tools/fuzz/seeds/tape.alta -o {out}/fit.mtlx --format json",))
    yield Run("given", ("fit --ra 0.2:-4:250 --ra 0.5:-4:95 -o {out}/fit.mtlx --format json",))
    yield Run("classes", ("fit --classes -o {out}",))


def render(*_: object) -> Iterator[Run]:
    """Small pictures."""
    for document in _FEW:
        yield Run(f"gl/{document}", (f"render {document} -o {{out}}/picture.png --size 64 --compare",))
    cycles = f"render {_FEW[0]} -o {{out}}/picture.png --size 32 --engine cycles --paths 4 --shape plane"
    yield Run("cycles", (cycles,))


SUBJECTS: dict[str, Callable[[Sequence[str], Path], Iterator[Run]]] = {
    subject.__name__: subject
    for subject in (validate, conformance, vectors, photometry, convert, generate, plot, fit, render)
}


def _files(folders: Sequence[str], place: Path, endings: tuple[str, ...]) -> list[str]:
    """Paths of the files with one of some endings in the copies of the documents."""
    found = (path for folder in folders for path in sorted((place / folder).rglob("*")) if path.suffix in endings)
    return [path.relative_to(place).as_posix() for path in found if path.is_file()]
