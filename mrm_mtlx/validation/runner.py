"""Checks many documents in worker processes that may crash or hang without taking the run down."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import shutil
import signal
import tempfile
from concurrent.futures import FIRST_COMPLETED, wait
from dataclasses import dataclass
from importlib import metadata
from multiprocessing import resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx import __version__
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.catalogue import all_rules
from mrm_mtlx.formats.registry import SUFFIXES
from mrm_mtlx.system import process_limits
from mrm_mtlx.validation.request import Request
from mrm_mtlx.validation.results import DocumentResult, ValidationResult
from mrm_mtlx.validation.steps import READING, Steps, add_lost, error_reason, lost_finding, read_record

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from concurrent.futures import Future

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import Origin

# Memory that a comparison takes for each of its samples, which the user chooses [bytes]: measured, 700 to 900 with
# 131,072 to 1,048,576 samples.
_BYTES_PER_SAMPLE = 1024
# Seconds that a worker may take to start.
_RESTART_S = 60.0


@dataclass(frozen=True)
class Settings:
    """How to check; see `request.Request`.

    `timeout_s` is what reading a document may take, and then each of its surfaces on each target; `jobs` the number of
    processes, 0 for one per processor; `roots` are folders from which files may be read beside the one that is checked,
    and in which they are looked for.
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
    all_rules()  # one that does not load is to be known before documents are checked
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
            missing.append(DocumentResult(shown(path), [rules.READ_MISSING.at("", message)]))
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
        return rules.READ_FAILED.at("", "it is a link that leads to itself")
    except UnicodeEncodeError:
        return rules.READ_FAILED.at("", "its name is not valid UTF-8")
    if reach is not None and reach.inside(Path(file.name)) is None:
        return rules.READ_OUTSIDE.at("", "it is a link that leads out of the folder being checked")
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
    """What runs or compiles source of these targets here, and of glsl: to try the others would only take time."""
    from mrm_mtlx.engines import registry

    report: dict[str, dict[str, Any]] = {}
    for name, state in registry.survey(("glsl", *targets)).items():
        key = "renderer" if state.available else "reason"
        report[name] = {"available": state.available, key: state.detail}
    return report


def _run(
    requests: list[Request], settings: Settings, progress: Callable[[int, int], None] | None
) -> list[DocumentResult]:
    import pebble

    if not requests:
        return []
    results: list[DocumentResult] = []
    # Files that a worker unpacks lie in here, so that one that dies leaves nothing behind.
    scratch = tempfile.mkdtemp(prefix="mrm-")
    # Spawned, not forked: a fork would share the parent's OpenGL driver and threads.
    workers = _workers(settings.jobs, len(requests))
    context = multiprocessing.get_context("spawn")
    up = context.Semaphore(0)
    memory = process_limits.MAXIMUM_MEMORY + settings.samples * _BYTES_PER_SAMPLE
    pool = pebble.ProcessPool(
        max_workers=workers, context=context, initializer=_prepare, initargs=(scratch, os.getpid(), memory, up)
    )
    tasks = [_Task(request, Path(scratch) / f"{n}.steps", settings.timeout_s) for n, request in enumerate(requests)]
    try:
        with _interrupts_held():  # the pool's threads and processes start here, and inherit it
            waiting = {task.start(pool): task for task in tasks}
        while waiting:
            done, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                task = waiting.pop(future)
                workers += task.lost_its_process(future)
                result = task.result(future)
                if result is None:
                    waiting[task.start(pool)] = task
                    continue
                results.append(result)
                if progress:
                    progress(len(results), len(requests))
        _await_workers(up, workers)
        pool.close()
    except BaseException:
        pool.stop()
        raise
    finally:
        pool.join()
        shutil.rmtree(scratch, ignore_errors=True)
    return results


def _await_workers(up: Any, number: int) -> None:
    """Wait until as many workers as were started are up: one is being started in the place of each that was lost.

    To close the pool before would break their start, with a traceback on the user's terminal.
    """
    for _ in range(number):
        if not up.acquire(timeout=_RESTART_S):
            return


@dataclass(frozen=True)
class _Task:
    """The check of one document, in as many processes as die in it; `record` is the file of its steps."""

    request: Request
    record: Path
    limit_s: float

    def start(self, pool: Any) -> Future[DocumentResult]:
        """Have it done, or gone on with, by a worker."""
        # Where a process cannot limit its own time, a document has the time of a step.
        limit = None if process_limits.can_limit_time() else self.limit_s
        future: Future[DocumentResult] = pool.submit(_check, limit, self.request, self.record, self.limit_s)
        return future

    def lost_its_process(self, future: Future[DocumentResult]) -> bool:
        """Whether the worker died, or was ended."""
        import pebble

        return isinstance(future.exception(), TimeoutError | pebble.ProcessExpired)

    def result(self, future: Future[DocumentResult]) -> DocumentResult | None:
        """The result; None if the process died and another can go on behind the step in which it did."""
        import pebble

        try:
            return future.result()
        except TimeoutError:
            found = self._lost()
        except pebble.ProcessExpired as error:
            found = self._lost() if process_limits.is_time_up(error.exitcode) else self._lost(error.exitcode)
        except Exception as error:
            found = rules.CHECK_CRASHED.at("", error_reason(error))
        return DocumentResult(self.request.shown, [found]) if found else None

    def _lost(self, status: int | None = None) -> Finding | None:
        """Note in which step a process died, without a status because its time was up.

        The finding, if that step was all of the document.
        """
        timed_out = status is None
        reason = f"not finished within {self.limit_s:g} s"
        if status is not None:
            reason = f"the process that checked it died ({process_limits.cause_of_death(status)})"
        step = read_record(self.record).begun or READING
        if step != READING:
            with contextlib.suppress(OSError):
                add_lost(self.record, step, reason, timed_out=timed_out)
                return None
        return lost_finding(step, reason, timed_out=timed_out)


def _workers(jobs: int, documents: int) -> int:
    """Processes that share the documents; of 0 jobs, one per processor."""
    if jobs == 0 and documents > 1:  # one document does not wait for NumPy to be imported here
        from mrm_mtlx.bsdf.blocks import processors

        jobs = processors()
    return max(min(jobs, documents), 1)


def _check(request: Request, record: Path, limit_s: float) -> DocumentResult:
    """The check in a worker: what it imports would be imported in vain in the process that waits for it."""
    from mrm_mtlx.validation.document import check_document

    process_limits.limit_time(limit_s)
    try:
        return check_document(request, Steps(record, limit_s))
    finally:
        process_limits.limit_time(0.0)


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


def _prepare(scratch: str, parent: int, memory: int, up: Any) -> None:
    """Bind a worker to its limits, and say that it is up.

    Workers return their results; what C++ libraries print meanwhile is noise on the user's terminal.
    """
    up.release()
    process_limits.die_with(parent)
    process_limits.limit_memory(memory)
    tempfile.tempdir = scratch
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    os.dup2(sink, 2)


def _wanted(found: Finding, settings: Settings) -> bool:
    is_selected = not settings.select or found.rule.is_among(settings.select)
    return is_selected and not found.rule.is_among(settings.ignore)
