"""Checks many documents in worker processes that may crash or hang without taking the run down."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import shutil
import signal
import tempfile
from dataclasses import dataclass
from importlib import metadata
from multiprocessing import resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx import __version__
from mrm_mtlx.interchange.formats import SUFFIXES
from mrm_mtlx.library.files import Reach
from mrm_mtlx.validation.findings import Finding, finding
from mrm_mtlx.validation.request import Request
from mrm_mtlx.validation.results import DocumentResult, ValidationResult

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from concurrent.futures import Future

    from mrm_mtlx.library import Origin

# Seconds that a worker may take to start.
_RESTART_S = 60.0


@dataclass(frozen=True)
class Settings:
    """How to check; see `request.Request`.

    `timeout_s` is per document, `jobs` the number of processes, 0 for one per processor; `roots` are folders from which
    files may be read beside the one that is checked, and in which they are looked for.
    """

    targets: tuple[str, ...]
    samples: int
    seed: int
    origin: Origin
    jobs: int
    timeout_s: float
    retro_sweep: bool = False
    roots: tuple[Path, ...] = ()
    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()


def validate(
    paths: Sequence[Path], settings: Settings, progress: Callable[[int, int], None] | None = None
) -> ValidationResult:
    """Check documents and folders.

    Parameters
    ----------
    paths
        Files, or folders that are searched recursively for files of the formats that are read.
    settings
        Targets, samples, seed, processes, filters.
    progress
        Called with (finished, all) after each document.

    Returns
    -------
    ValidationResult
        Documents sorted by path. A path that does not exist is a document with a finding.
    """
    missing, requests = collect(paths, settings)
    documents = missing + _run(requests, settings, progress)
    for document in documents:
        document.findings = [f for f in document.findings if _wanted(f, settings)]
    documents.sort(key=lambda d: d.path)
    return ValidationResult(versions(), engines(settings.targets), documents)


def collect(paths: Sequence[Path], settings: Settings) -> tuple[list[DocumentResult], list[Request]]:
    """Results for paths that cannot be checked, and a request per document, each document once."""
    missing: list[DocumentResult] = []
    requests: dict[Path, Request] = {}
    for path in paths:
        if not path.exists():
            message = f"'{path.as_posix()}' does not exist"
            missing.append(DocumentResult(shown(path), [finding("READ_MISSING", "", message)]))
            continue
        is_folder = path.is_dir()
        root = path if is_folder else path.parent
        for file in documents_of(path) if is_folder else [path]:
            name = shown(file, path if is_folder else None)
            reach = Reach(file.parent, root, settings.roots)
            problem = _unreadable(file, reach if is_folder else None)
            if problem is not None:
                missing.append(DocumentResult(name, [problem]))
                continue
            requests.setdefault(
                file.resolve(),
                Request(
                    file,
                    reach,
                    name,
                    settings.targets,
                    settings.samples,
                    settings.seed,
                    settings.origin,
                    settings.retro_sweep,
                ),
            )
    return missing, list(requests.values())


def documents_of(folder: Path) -> list[Path]:
    """Files of all formats in a folder and those below it, sorted."""
    found = (path for path in folder.rglob("*") if path.suffix.lower() in SUFFIXES)
    return sorted(found, key=Path.as_posix)


def _unreadable(file: Path, reach: Reach | None) -> Finding | None:
    """Why a file is not even handed to a worker; `reach` is that of one that was found in a folder."""
    try:
        file.resolve()
        str(file).encode("utf-8")
    except (OSError, RuntimeError):
        return finding("READ_FAILED", "", "it is a link that leads to itself")
    except UnicodeEncodeError:
        return finding("READ_FAILED", "", "its name is not valid UTF-8")
    if reach is not None and reach.inside(Path(file.name)) is None:
        return finding("READ_OUTSIDE", "", "it is a link that leads out of the folder being checked")
    return None


def shown(path: Path, folder: Path | None = None) -> str:
    """A path as reports show it: never absolute.

    Relative to the current folder; of one that lies elsewhere, the part from the `folder` on in which it was found, or
    its last two parts.
    """
    absolute = Path.cwd() / path
    if absolute.is_relative_to(Path.cwd()):
        name = absolute.relative_to(Path.cwd()).as_posix()
    elif folder is not None:
        name = (Path((Path.cwd() / folder).name) / path.relative_to(folder)).as_posix()
    else:
        name = Path(*absolute.parts[-2:]).as_posix().lstrip("/")
    # Names of files are bytes on some systems; reports are text.
    return name.encode("utf-8", "backslashreplace").decode("utf-8")


def versions() -> dict[str, str]:
    """Versions of what a verdict depends on."""
    names = {
        "materialx": "MaterialX",
        "numpy": "numpy",
        "openimageio": "OpenImageIO",
        "moderngl": "moderngl",
        "usd": "usd-core",
    }
    return {"mrm": __version__, **{key: metadata.version(name) for key, name in names.items()}}


def engines(targets: Sequence[str]) -> dict[str, dict[str, Any]]:
    """What can run or compile source of these targets here, and OpenGL: to try the others would only take time."""
    from mrm_mtlx.engines import gl

    states = {"gl": gl.availability()}
    if "vulkan" in targets:
        from mrm_mtlx.engines import compilers

        states["vulkan"] = compilers.vulkan_availability()
    if "slang" in targets:
        from mrm_mtlx.engines import compilers

        states["slang"] = compilers.slang_availability()
    if "osl" in targets:
        from mrm_mtlx.engines import osl

        states["osl"] = osl.compiler_availability()
        osl.stop()  # the worker processes have their own
    report: dict[str, dict[str, Any]] = {}
    for name, state in states.items():
        key = "renderer" if state.available else "reason"
        report[name] = {"available": state.available, key: state.detail}
    return report


def _run(
    requests: list[Request], settings: Settings, progress: Callable[[int, int], None] | None
) -> list[DocumentResult]:
    import pebble

    if not requests:
        return []
    results = []
    # Spawned, not forked: a fork would share the parent's OpenGL driver and threads.
    # Files that a worker unpacks lie in here, so that one that dies leaves nothing behind.
    scratch = tempfile.mkdtemp(prefix="mrm-")
    pool = pebble.ProcessPool(
        max_workers=_workers(settings.jobs, len(requests)),
        context=multiprocessing.get_context("spawn"),
        initializer=_prepare,
        initargs=(scratch,),
    )
    try:
        with _interrupts_held():  # the pool's threads and processes start here, and inherit it
            futures = [pool.submit(_check, settings.timeout_s, request) for request in requests]
        for count, (request, future) in enumerate(zip(requests, futures, strict=True), start=1):
            results.append(_result(request, future, settings))
            if progress:
                progress(count, len(requests))
        if any(f.code in ("CHECK_TIMEOUT", "CHECK_CRASHED") for result in results for f in result.findings):
            # A worker is being started in the place of the lost one; closing before it is up would break its start.
            with contextlib.suppress(Exception):
                pool.submit(os.getpid, _RESTART_S).result()
        pool.close()
    except BaseException:
        pool.stop()
        raise
    finally:
        pool.join()
        shutil.rmtree(scratch, ignore_errors=True)
    return results


def _workers(jobs: int, documents: int) -> int:
    """Processes that share the documents; of 0 jobs, one per processor."""
    if jobs == 0 and documents > 1:  # one document does not wait for NumPy to be imported here
        from mrm_mtlx.bsdf.blocks import processors

        jobs = processors()
    return max(min(jobs, documents), 1)


def _check(request: Request) -> DocumentResult:
    """The check in a worker: what it imports would be imported in vain in the process that waits for it."""
    from mrm_mtlx.validation.document import check_document

    return check_document(request)


def _result(request: Request, future: Future[DocumentResult], settings: Settings) -> DocumentResult:
    import pebble

    try:
        return future.result()
    except TimeoutError:
        message = f"not finished within {settings.timeout_s:g} s"
        found = finding("CHECK_TIMEOUT", "", message)
    except pebble.ProcessExpired as error:
        found = finding("CHECK_CRASHED", "", f"the process that checked it died with exit status {error.exitcode}")
    except Exception as error:
        found = finding("CHECK_CRASHED", "", f"internal error: {type(error).__name__}: {error}")
    return DocumentResult(request.shown, [found])


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Block SIGINT in what is started meanwhile: an interrupt is for this process, which ends its workers itself."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # starting it later would unblock the signal again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _prepare(scratch: str) -> None:
    """Workers return their results; what C++ libraries print meanwhile is noise on the user's terminal."""
    tempfile.tempdir = scratch
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    os.dup2(sink, 2)


def _wanted(found: Finding, settings: Settings) -> bool:
    selected = not settings.select or found.code.startswith(settings.select)
    return selected and not (settings.ignore and found.code.startswith(settings.ignore))
