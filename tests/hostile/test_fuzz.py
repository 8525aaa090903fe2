"""Mutants by fixed seeds: none makes anything fail, and the run sees what does. `python -m tools.fuzz` is longer."""

from __future__ import annotations

import sys
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from tools.fuzz.report import Counts

HERE = Path(__file__).resolve().parent
SEED = 2026
# 2,000 in all; documents are what most commands take.
COUNTS = {"mtlx": 900, "usd": 400, "gltf": 300, "data": 200, "image": 200}


@pytest.fixture(scope="module", autouse=True)
def planted_targets_on_the_path() -> None:
    """Worker processes find the planted targets by name."""
    sys.path.append(str(HERE))


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> Callable:
    """Function from a document to its verdict in this process, as an unchanged mutant has it."""
    from tools.fuzz import corpus, place
    from tools.fuzz.mutants import Mutant
    from tools.fuzz.target import judge

    folder = tmp_path_factory.mktemp("fuzz")
    corpus.pictures(folder / "pictures")
    laid_out = place.lay_out(folder, folder / "pictures")
    (folder / "scratch").mkdir()

    def run(suffix: str, content: str, draw: int = 0):
        class Always(Random):
            """Draws what makes every further step be done."""

            def randrange(self, *_: int) -> int:
                return draw

        return judge(Mutant(suffix, content.encode()), laid_out, folder / "scratch", Always(SEED))

    return run


def tried(kind: str, count: int) -> Counts:
    """Outcomes of the first mutants of a kind."""
    from tools.fuzz.mutants import Key
    from tools.fuzz.report import Counts, notable
    from tools.fuzz.run import Settings, run

    counts = Counts()
    for result in run([Key(kind, SEED, index) for index in range(count)], Settings(jobs=1)):
        counts.add(result)
    assert sum(counts.outcomes.values()) == count
    assert counts.failures == [], notable({kind: counts})
    return counts


@pytest.mark.large
@pytest.mark.parametrize("kind", COUNTS)
def test_mutants_give_findings_and_no_failure(kind: str) -> None:
    from tools.fuzz.target import Outcome

    counts = tried(kind, COUNTS[kind])
    # Both sides are tried: mutants that are refused, and such that go on to code, conversion and evaluation.
    assert min(counts.outcomes[Outcome.CLEAN], counts.outcomes[Outcome.FINDINGS]) > COUNTS[kind] // 20


@pytest.mark.parametrize("kind", COUNTS)
def test_the_first_mutants_give_findings_and_no_failure(kind: str) -> None:
    from tools.fuzz.target import Outcome

    outcomes = tried(kind, COUNTS[kind] // 20).outcomes
    assert min(outcomes[Outcome.CLEAN], outcomes[Outcome.FINDINGS]) > 0


def test_a_mutant_is_the_same_whenever_it_is_made(tmp_path: Path) -> None:
    from tools.fuzz import corpus
    from tools.fuzz.kinds import KINDS
    from tools.fuzz.mutants import Key, Maker

    for part in ("a", "b"):
        corpus.build(tmp_path / part, frozenset(KINDS) - {"usd", "gltf"})
    for kind in ("mtlx", "data", "image"):
        keys = [Key(kind, SEED, index) for index in range(30)]
        first, second = Maker(tmp_path / "a"), Maker(tmp_path / "b")
        made = [first.make(key) for key in keys]
        assert [second.make(key) for key in reversed(keys)] == made[::-1]
        assert len({mutant.content for mutant in made}) > 25


def test_a_document_without_fault_is_clean(judged: Callable, document_text: Callable) -> None:
    verdict = judged(".mtlx", document_text())
    assert (verdict.outcome, verdict.codes) == ("clean", ())


def test_a_name_of_the_only_output_of_a_node_is_no_refusal(judged: Callable) -> None:
    named = '<dot name="d" type="float"><input name="in" type="float" nodename="c" output="out"/></dot>'
    verdict = judged(".mtlx", f'<materialx version="1.39"><constant name="c" type="float"/>{named}</materialx>')
    assert (verdict.outcome, verdict.codes) == ("clean", ("DOC_OUTPUT_IGNORED",))


def test_an_uncaught_exception_is_seen(
    judged: Callable, document_text: Callable, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tools.fuzz import target

    def broken(_: object) -> list:
        return [][0]

    monkeypatch.setattr(target, "check_graph", broken)
    verdict = judged(".mtlx", document_text())
    assert verdict.outcome == "uncaught exception"
    assert verdict.outcome.failed
    assert "IndexError" in verdict.detail


def test_a_refusal_of_materialx_that_is_passed_over_is_seen(judged: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    from tools.fuzz import target

    wrong = (
        '<materialx version="1.39"><nodegraph name="g" nodedef="ND_none"/><constant name="c" type="float"/></materialx>'
    )
    assert judged(".mtlx", wrong).outcome == "findings"
    monkeypatch.setattr(target, "check_graph", lambda _: [])
    verdict = judged(".mtlx", wrong)
    assert verdict.outcome == "clean where MaterialX refuses"
    assert verdict.outcome.failed


@pytest.mark.parametrize(
    ("planted", "outcome"),
    [
        ("dies", "worker died"),
        ("hangs", "time-out"),
        ("takes_memory", "out of memory"),
        ("raises", "uncaught exception"),
    ],
)
def test_what_happens_to_a_worker_is_counted(planted: str, outcome: str) -> None:
    import planted_targets

    from tools.fuzz.mutants import Key
    from tools.fuzz.run import Settings, run

    settings = Settings(jobs=1, time_limit_s=3.0, target=getattr(planted_targets, planted))
    results = list(run([Key("data", SEED, index) for index in range(3)], settings))
    assert [result.key.number for result in results] == [0, 1, 2]
    assert [result.verdict.outcome for result in results] == ["clean", outcome, "clean"]


def test_resident_memory_is_measured() -> None:
    from tools.fuzz.run import forget_peak, peak

    forget_peak()
    before = peak()
    if before == 0:
        pytest.skip("this system does not say how much memory is resident")
    size = 64 * 2**20
    block = bytearray(size)
    del block
    assert peak() - before > size // 2
    forget_peak()
    assert peak() < before + size // 2


def test_the_command_prints_a_table_and_keeps_what_can_be_replayed(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    from tools.fuzz.__main__ import main

    assert main(["--kind", "data", "--count", "20", "-o", str(tmp_path / "kept")]) == 0
    printed = capsys.readouterr().out
    assert "| data | 20 |" in printed
    assert printed.rstrip().endswith("PASSED  0 failures")
    assert main(["--kind", "data", "--replay", "1:3", "-o", str(tmp_path / "kept")]) == 0
    (kept,) = (tmp_path / "kept").iterdir()
    assert kept.stem == "data-1-3"
