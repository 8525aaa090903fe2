"""How often the suite rejects what is right: once in a thousand changes of its seed.

Tests that decide by random numbers reject with a known probability, and have their thresholds from the fixture
`significance` alone. Its level for one test is Sidak's, 1 - (1 - 0.001)^(1 / n) for the n tests that ask for it, and a
test with several decisions shares its level among them in the same way; where the decisions are not independent, less
is rejected. The seed of a test comes from its name (fixture `rng`) and is never chosen; nor is a tolerance.

Statistical is what estimates something by independent draws: means, shares, histograms, variances. Tests whose random
inputs are places to look at, with a bound that holds at every place, are not; nor is a planted error that must be seen:
one that is missed is a miss, not a false alarm, and the numbers of samples are such that the chance of one is as small.
"""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy import stats

if TYPE_CHECKING:
    from pathlib import Path


def statistical_modules(repository: Path) -> list[str]:
    """Modules that name the fixture, but this one and the one that defines it."""
    here = repository / "tests"
    named = (p for p in sorted(here.rglob("test_*.py")) if "significance" in p.read_text(encoding="utf-8"))
    return [p.relative_to(repository).as_posix() for p in named if p.name != "test_false_alarms.py"]


def test_the_level_is_shared_among_as_many_tests_as_there_are(repository, false_alarms):
    options = ["-n", "0", "--collect-only", "-q", "-m", "statistical", "-p", "no:cacheprovider"]
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_")}
    found = subprocess.run(
        [sys.executable, "-m", "pytest", *options, *statistical_modules(repository)],
        cwd=repository, env=environment, capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    collected = sum("::" in line for line in found.stdout.splitlines())
    assert found.returncode == 0, found.stdout + found.stderr
    assert collected == false_alarms[1], f"set STATISTICAL_TESTS in tests/conftest.py to {collected}"


def test_thresholds_come_from_one_place(repository):
    # A constant number of standard deviations is how a test would evade the count.
    for path in sorted((repository / "tests").rglob("*.py")):
        if path.name != "test_false_alarms.py":
            assert "SIGMAS" not in path.read_text(encoding="utf-8"), path.relative_to(repository)


@pytest.mark.parametrize("decisions", [1, 10, 1000])
def test_the_levels_of_all_tests_together_make_the_stated_rate(share_of_false_alarms, false_alarms, decisions):
    (rate, tests), share = false_alarms, share_of_false_alarms()
    assert not share.asked
    silent = tests * decisions * np.log1p(-share.level(decisions))
    assert silent == pytest.approx(np.log1p(-rate), rel=1e-12)  # a dozen roundings
    # What a normal variable exceeds to both sides as often.
    assert 2.0 * stats.norm.sf(share.sigmas(decisions)) == pytest.approx(share.level(decisions), rel=1e-9)
    assert share.asked
