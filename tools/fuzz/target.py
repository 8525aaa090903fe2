"""What is done with a mutant, and what counts as a failure. Runs in a worker process."""

from __future__ import annotations

import contextlib
import shutil
import traceback
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.document import Document, ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.formats.format import NothingToWriteError
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.formats.registry import MATERIALX, format_for, format_of
from mrm_mtlx.library import load_library
from mrm_mtlx.reference import Surface, UnsupportedError
from mrm_mtlx.shadergen import GenerationError, generate, renderable_elements
from mrm_mtlx.validation.checks.files import check_files
from mrm_mtlx.validation.checks.graph import check_graph
from mrm_mtlx.validation.checks.materialx import messages_of_validation
from mrm_mtlx.validation.checks.retroreflection import check_retroreflection
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.retro_sweep import flattened

if TYPE_CHECKING:
    from random import Random

    from mrm_mtlx.findings.finding import Finding
    from tools.fuzz.mutants import Mutant

# One mutant in so many is also flattened, written in each format, and evaluated.
_DISSOLVED, _CONVERTED, _EVALUATED = 4, 6, 4
# Elements of one document for which code is made.
_ELEMENTS = 3
# A picture is read through this document.
_SHOWS = """<?xml version="1.0"?>
<materialx version="1.39">
  <image name="i" type="color3"><input name="file" type="filename" value="m{}"/></image>
  <oren_nayar_diffuse_bsdf name="b" type="BSDF">
    <input name="color" type="color3" nodename="i"/>
  </oren_nayar_diffuse_bsdf>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="b"/></surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
</materialx>
"""


class Outcome(StrEnum):
    """What came of a mutant. Of the first two nothing is wrong; the next three have a finding of their own."""

    CLEAN = "clean"
    FINDINGS = "findings"
    TIMEOUT = "time-out"
    DIED = "worker died"
    MEMORY = "out of memory"
    EXCEPTION = "uncaught exception"
    ORACLE = "clean where MaterialX refuses"
    LARGE = "above the memory bound"

    @property
    def failed(self) -> bool:
        """Whether it is a failure whatever the walls around say."""
        return self in (Outcome.EXCEPTION, Outcome.ORACLE, Outcome.LARGE)


@dataclass
class Verdict:
    """What came of a mutant: codes of its findings, and in `detail` what is wrong, the traceback's last lines."""

    outcome: Outcome
    codes: tuple[str, ...] = ()
    detail: str = ""


def judge(mutant: Mutant, place: Path, scratch: Path, rng: Random) -> Verdict:
    """Do with a mutant all that the commands do before a driver or a fit is asked.

    Parameters
    ----------
    mutant
        Is written as `m` with its ending into the `place`, and removed.
    place
        Folder of `place.lay_out`; nothing outside of it may be opened.
    scratch
        Folder for what is made of it, emptied.
    rng
        Decides what else than reading, checking and generating is done.
    """
    path = place / f"m{mutant.suffix}"
    path.write_bytes(mutant.content)
    try:
        if mutant.suffix in (".csv", ".alta", ".json", ".binary"):
            return _measured(path)
        if format_of(path) is None:
            return _pictured(path, scratch, rng)
        return _document(path, scratch, rng)
    except MemoryError as error:
        return Verdict(Outcome.MEMORY, detail=_last(error))
    except Exception as error:  # whatever is not caught there is a fault
        return Verdict(Outcome.EXCEPTION, detail=_last(error))
    finally:
        path.unlink(missing_ok=True)
        shutil.rmtree(scratch, ignore_errors=True)
        scratch.mkdir()


def _last(error: Exception) -> str:
    """The exception, and where it came from."""
    frames = traceback.extract_tb(error.__traceback__)
    inner = [f for f in frames if "mrm_mtlx" in f.filename] or frames
    where = f"{Path(inner[-1].filename).name}:{inner[-1].lineno} {inner[-1].name}"
    return f"{type(error).__name__}: {str(error)[:200]} ({where})"


def _verdict(findings: list[Finding]) -> Verdict:
    codes = tuple(sorted({f.code for f in findings}))
    return Verdict(Outcome.FINDINGS if any(f.blocks for f in findings) else Outcome.CLEAN, codes)


def _document(path: Path, scratch: Path, rng: Random) -> Verdict:
    library = load_library()
    inside = scratch / "inside"
    inside.mkdir()
    try:
        read = read_document(path, Reach.beside(path), library, inside)
    except ReadError as error:
        return _verdict([error.finding])
    findings = read.findings + check_graph(read.materialx)
    findings += check_files(read.materialx, read.reach, library)
    if any(f.blocks for f in findings):
        return _verdict(findings)
    findings += check_retroreflection(read.materialx)
    codes = list(_verdict(findings).codes)
    for element in renderable_elements(read.materialx)[:_ELEMENTS]:
        try:
            generate(element, "glsl", library)
        except GenerationError:
            codes.append("SHADER_GENERATE")
    if "SHADER_GENERATE" in codes:
        return Verdict(Outcome.FINDINGS, tuple(sorted(set(codes))))
    refused = _refused(path, read)
    if refused:
        return Verdict(Outcome.ORACLE, tuple(codes), refused)
    _more(read, scratch, rng)
    return Verdict(Outcome.CLEAN, tuple(codes))


def _refused(path: Path, read: Document) -> str:
    """Why MaterialX itself refuses a document, "" if it does not."""
    document = read.materialx
    if format_of(path) is MATERIALX:
        document = mx.createDocument()
        try:
            mx.readFromXmlFile(document, str(path), mx.FileSearchPath(str(path.parent)))
        except Exception as error:  # MaterialX throws several unrelated types
            return f"its reader: {error}"
        document.setDataLibrary(load_library().document)
    _, messages = document.validate()
    # All but that the only output of a node is named, which the specification allows.
    return "\n".join(f.message for f in messages_of_validation(document, messages, explained=False))[:300]


def _more(read: Document, scratch: Path, rng: Random) -> None:
    """What other commands do with a document that is valid; exceptions of theirs that mean a message are expected."""
    if rng.randrange(_DISSOLVED) == 0:
        with contextlib.suppress(ValueError):
            flattened(read.materialx)
    if rng.randrange(_CONVERTED) == 0:
        _convert(read, scratch / f"w{rng.choice(('.usda', '.usdc', '.usdz', '.gltf', '.glb', '.mtlx'))}")
    if rng.randrange(_EVALUATED) == 0:
        for element in renderable_elements(read.materialx)[:_ELEMENTS]:
            _evaluate(element, read, rng)


def _convert(read: Document, path: Path) -> None:
    form = format_for(path)
    assert form is not None
    try:
        form.write(read, path, load_library())
    except (NothingToWriteError, ValueError, OSError):
        return


def _evaluate(element: Any, read: Document, rng: Random) -> list[Finding]:
    """The reference at a few points; findings of the images that it asks for."""
    images = CheckedImages(read.reach, f"/{element.getNamePath()}")
    generator = sampling.generator(rng.getrandbits(32), str(element.getNamePath()))
    try:
        surface = Surface(element, images=images)
        points = sampling.shading_points(generator, *sampling.sample_local(generator, 4))
        kinds = surface.traits(points).properties
        points = sampling.shading_points(
            generator, *sampling.sample_local(generator, 4), sampling.geometric_properties(generator, kinds, 4)
        )
        surface.shade(points)
    except (UnsupportedError, RecursionError):
        pass
    return images.findings


def _pictured(path: Path, scratch: Path, rng: Random) -> Verdict:
    """A picture as the image of a document."""
    document = path.with_name("shows.mtlx")
    document.write_text(_SHOWS.format(path.suffix), encoding="utf-8")
    library = load_library()
    read = read_document(document, Reach.beside(document), library, scratch)
    findings = read.findings + check_graph(read.materialx)
    findings += check_files(read.materialx, read.reach, library)
    if any(f.blocks for f in findings):
        return _verdict(findings)
    for element in renderable_elements(read.materialx):
        findings += _evaluate(element, read, rng)
    return _verdict(findings)


def _measured(path: Path) -> Verdict:
    """Measured data, and the samples that a fit would take of them."""
    from mrm_mtlx.fitting.samples import doubts, from_coefficients, from_measurement
    from mrm_mtlx.formats.openmaterial import block
    from mrm_mtlx.measured import Measurement
    from mrm_mtlx.measured.any_format import read

    try:
        if path.suffix == ".json":
            block.load(path)
            return Verdict(Outcome.CLEAN)
        found = read(path)
        if isinstance(found, Measurement):
            from_measurement(found)
            doubts(found)
        else:
            from_coefficients(found)
    except (ValueError, OSError):
        return Verdict(Outcome.FINDINGS, ("refused",))
    return Verdict(Outcome.CLEAN)
