"""Many mutants in worker processes that may die or hang, as `mrm validate` checks documents."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import shutil
import tempfile
from collections import deque
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING

from mrm_mtlx.system import process_limits
from tools.fuzz import corpus
from tools.fuzz.mutants import Key, Maker

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Future

    from tools.fuzz.mutants import Mutant
    from tools.fuzz.target import Verdict

    Target = Callable[[Mutant, Path, Path, Random], Verdict]

# Seconds for one mutant.
TIME_LIMIT_S = 20.0
# Mutants that wait for each worker.
_AHEAD = 32


@dataclass(frozen=True)
class Settings:
    """How to run: processes, seconds per mutant, and what is done with each (of a module, so that workers find it)."""

    jobs: int = 1
    time_limit_s: float = TIME_LIMIT_S
    target: Target | None = None


@dataclass(frozen=True)
class Result:
    """A mutant's verdict, and the largest resident memory of its worker meanwhile [bytes]."""

    key: Key
    verdict: Verdict
    memory: int = 0


def run(keys: list[Key], settings: Settings) -> Iterator[Result]:
    """The results of mutants, in their order."""
    import pebble

    scratch = Path(tempfile.mkdtemp(prefix="mrm-fuzz-"))
    pool = None
    try:
        corpus.build(scratch / "corpus", frozenset(key.kind for key in keys))
        pool = pebble.ProcessPool(
            max_workers=settings.jobs,
            context=multiprocessing.get_context("spawn"),
            initializer=_prepare,
            initargs=(str(scratch), os.getpid()),
        )
        waiting: deque[tuple[Key, Future[Result]]] = deque()
        for key in keys:
            waiting.append((key, pool.schedule(partial(_judge, key, settings.target), timeout=settings.time_limit_s)))
            if len(waiting) >= _AHEAD * settings.jobs:
                yield _result(*waiting.popleft(), settings)
        while waiting:
            yield _result(*waiting.popleft(), settings)
        with contextlib.suppress(Exception):  # closing while a worker is being replaced would break its start
            pool.schedule(os.getpid, timeout=60).result()
        pool.close()
    finally:
        if pool is not None:
            pool.stop()
            pool.join()
        shutil.rmtree(scratch, ignore_errors=True)


def _result(key: Key, future: Future[Result], settings: Settings) -> Result:
    import pebble

    from tools.fuzz.target import Outcome, Verdict

    try:
        return future.result()
    except TimeoutError:
        return Result(key, Verdict(Outcome.TIMEOUT, detail=f"not finished within {settings.time_limit_s:g} s"))
    except pebble.ProcessExpired as error:
        return Result(key, Verdict(Outcome.DIED, detail=process_limits.cause_of_death(error.exitcode)))
    except MemoryError:  # beside the target, as when its result is sent
        return Result(key, Verdict(Outcome.MEMORY))
    except Exception as error:
        return Result(key, Verdict(Outcome.EXCEPTION, detail=f"{type(error).__name__}: {error}"))


@dataclass
class _Worker:
    """What a worker process keeps from one mutant to the next."""

    maker: Maker
    place: Path
    scratch: Path


_worker: list[_Worker] = []


def _prepare(scratch: str, parent: int) -> None:
    """Bound a worker, silence what C++ libraries print, and make its folder."""
    from tools.fuzz import place

    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    os.dup2(sink, 2)
    process_limits.die_with(parent)
    process_limits.limit_memory()
    own = Path(tempfile.mkdtemp(prefix="worker-", dir=scratch))
    tempfile.tempdir = str(own)
    inner = own / "scratch"
    inner.mkdir()
    folder = place.lay_out(own, Path(scratch) / "corpus" / "pictures")
    _worker[:] = [_Worker(Maker(Path(scratch) / "corpus"), folder, inner)]


def _judge(key: Key, target: Target | None) -> Result:
    from tools.fuzz.target import Outcome, Verdict, judge

    worker = _worker[0]
    forget_peak()
    verdict = (target or judge)(worker.maker.make(key), worker.place, worker.scratch, Random(f"{key} target"))
    memory = peak()
    if memory > process_limits.MAXIMUM_MEMORY and not verdict.outcome.failed:
        verdict = Verdict(Outcome.LARGE, verdict.codes, f"{memory / 2**30:.2f} GiB resident")
    return Result(key, verdict, memory)


def forget_peak() -> None:
    """Begin to measure the largest resident memory of this process anew, where the system can."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def peak() -> int:
    """The largest resident memory of this process [bytes]; 0 where the system does not say."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    return 0
