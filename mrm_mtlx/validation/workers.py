"""Documents checked in worker processes, which may crash or hang without taking the run down."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import tempfile
from concurrent.futures import FIRST_COMPLETED, wait
from dataclasses import dataclass
from multiprocessing import resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.findings import rules
from mrm_mtlx.system import process_limits
from mrm_mtlx.system.spawning import SpawnContext
from mrm_mtlx.validation.results import DocumentResult
from mrm_mtlx.validation.steps import READING, Steps, add_lost, error_reason, lost_finding, read_record

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Future

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.validation.options import Request, ValidationOptions

# Memory that a comparison takes for each of its samples, which the user chooses [bytes]: measured, 700 to 900 with
# 131,072 to 1,048,576 samples.
_BYTES_PER_SAMPLE = 1024
# Seconds that a worker may take to start.
_RESTART_S = 60.0


def check_all(
    requests: list[Request], options: ValidationOptions, progress: Callable[[int, int], None] | None = None
) -> list[DocumentResult]:
    """The results of documents, in the order in which they were finished; `progress` as for `runner.validate`."""
    import pebble

    if not requests:
        return []
    results: list[DocumentResult] = []
    # Files that a worker unpacks lie in here, so that one that dies leaves nothing behind.
    scratch = tempfile.mkdtemp(prefix="mrm-")
    # Spawned, not forked: a fork would share the parent's OpenGL driver and threads.
    workers = _workers(options.jobs, len(requests))
    context = SpawnContext()
    up = context.Semaphore(0)
    memory = process_limits.MAXIMUM_MEMORY + options.samples * _BYTES_PER_SAMPLE
    pool = pebble.ProcessPool(
        max_workers=workers, context=context, initializer=_prepare, initargs=(scratch, os.getpid(), memory, up)
    )
    tasks = [_Task(request, Path(scratch) / f"{n}.steps", options.timeout_s) for n, request in enumerate(requests)]
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
        """True if the worker died, or was ended."""
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
