"""Environments with other versions of MaterialX: what is there is used, and what cannot be made is said in a line."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tools import environments
from tools.environments import MAIN, EnvironmentUnavailableError, environment


def test_an_environment_that_is_there_is_used_as_it_is(tmp_path):
    (tmp_path / "1.39.99").mkdir()
    assert environment(tmp_path, "1.39.99").is_relative_to(tmp_path / "1.39.99")
    assert list((tmp_path / "1.39.99").iterdir()) == []


@pytest.mark.parametrize("folder", [None, Path("nowhere"), Path()])
def test_main_needs_its_data_libraries(tmp_path, folder):
    with pytest.raises(EnvironmentUnavailableError, match="is no folder of data libraries"):
        environment(tmp_path / "new", MAIN, folder and tmp_path / folder)
    assert list((tmp_path / "new").iterdir()) == []


@pytest.mark.versions
def test_a_command_runs_in_each_environment_and_its_failure_is_that_of_the_tool(with_materialx, capfd):
    folder = with_materialx("1.39.4").parents[2]
    assert environments.main([str(folder), "1.39.4", "--run", "rules"]) == 0
    assert environments.main([str(folder), "1.39.4", "--run", "rules", "--run", "rules NONE"]) == 1
    lines = [line for line in capfd.readouterr().out.splitlines() if line.startswith(("--- 1.39.4: mrm", "FAILED"))]
    assert [line.rpartition(" (")[0] for line in lines] == [
        "--- 1.39.4: mrm rules: exit status 0",
        "--- 1.39.4: mrm rules: exit status 0",
        "--- 1.39.4: mrm rules NONE: exit status 2",
        "FAILED: 1.39.4",
    ]


@pytest.mark.versions
def test_a_version_without_a_wheel_is_named_and_leaves_nothing(tmp_path):
    with pytest.raises(EnvironmentUnavailableError, match=r"^no wheel of MaterialX 1\.39\.99 for Python 3\.\d+ "):
        environment(tmp_path, "1.39.99")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.versions
def test_an_environment_differs_from_this_one_in_materialx_alone(with_materialx):
    python = with_materialx("1.39.4")
    ask = "import MaterialX, numpy, moderngl, mrm_mtlx; print(MaterialX.getVersionString(), numpy.__file__)"
    import numpy as np

    done = subprocess.run([python, "-c", ask], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["1.39.4", np.__file__]


@pytest.mark.versions
def test_the_environment_of_main_has_its_data_and_says_so(with_materialx):
    ask = "from mrm_mtlx.library import materialx_version as v; import MaterialX as m; print(v(), m.__version__)"
    done = subprocess.run([with_materialx(MAIN), "-c", ask], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [environments.MAIN_VERSION, environments.NEWEST_WHEEL]
