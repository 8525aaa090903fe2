"""The table of hosts: what each gets, and the page that says so."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

import mrm_mtlx as mrm
from mrm_mtlx.library.assembly import served
from mrm_mtlx.library.hosts import HOSTS, Choice, Form, host_called
from mrm_mtlx.library.standard_library import FIRST_DEFINED
from mrm_mtlx.system.shells import assignments


def test_every_host_has_a_materialx_that_the_node_library_serves():
    for host in HOSTS.values():
        assert not host.materialx or (host.materialx in FIRST_DEFINED and served(host.materialx))


def test_a_host_that_is_told_by_a_variable_chooses_by_name():
    # They are hosts of USD, where the inputs of a node are gone before MaterialX chooses.
    assert all((host.choice is Choice.NAME) == bool(host.variable) for host in HOSTS.values())


def test_names_are_those_that_a_shell_takes_as_they_are():
    assert all(re.fullmatch(r"[a-z0-9.-]+", name) for name in HOSTS)


@pytest.mark.parametrize(("name", "near"), [("blender5.0", "blender-5.0"), ("Maya-2027", "maya-2027"), ("usd", None)])
def test_a_name_that_is_none_is_told_with_the_nearest_and_all(name, near):
    with pytest.raises(LookupError) as caught:
        host_called(name)
    assert f"'{name}'" in str(caught.value)
    assert (f"did you mean {near}?" in str(caught.value)) is bool(near)
    assert all(known in str(caught.value) for known in HOSTS)


def rows(page: str) -> dict[str, str]:
    """Rows of the table of hosts by the name of the host."""
    return {m[1]: m[0] for m in re.finditer(r"^\| `([a-z][a-z0-9.-]*)` \|.*$", page, re.MULTILINE)}


def wrong_rows(page: str) -> list[str]:
    """Hosts whose row does not say what the table of the package has."""
    found, wrong = rows(page), []
    for host in HOSTS.values():
        told = [host.materialx or "installed", host.evidence.value, host.variable]
        told += [host.form.value] if host.form is not Form.SOURCES else []
        if not all(each in found.get(host.name, "") for each in told) or host.name not in found:
            wrong.append(host.name)
    return wrong + sorted(found.keys() - HOSTS.keys())


def test_the_page_of_hosts_has_a_row_for_each_as_the_package_has_it(repository):
    assert wrong_rows((repository / "docs" / "hosts.md").read_text(encoding="utf-8")) == []


def test_a_row_that_is_missing_or_not_true_is_seen(repository):
    page = (repository / "docs" / "hosts.md").read_text(encoding="utf-8")
    without = re.sub(r"^\| `quiltix` .*\n", "", page, flags=re.MULTILINE)
    assert wrong_rows(without) == ["quiltix"]
    assert "blender-4.5" in wrong_rows(page.replace("1.39.2", "1.39.1"))
    assert wrong_rows(page + "\n| `nuke` | | |\n") == ["nuke"]


# What is to be set, and how.


def test_a_host_is_told_one_thing(tmp_path):
    installed = mrm.install_library(tmp_path, host="usd-26.08")
    assert (installed.variable, installed.value) == ("PXR_MTLX_PLUGIN_SEARCH_PATHS", str(tmp_path.resolve()))
    assert sum("variable" in note for note in installed.notes()) == 1
    assert all(any(line in note for note in installed.notes()) for line in assignments(*told(installed)).values())


def test_a_host_without_a_standard_library_is_told_of_both_folders_ours_first(tmp_path):
    first, second = mrm.install_library(tmp_path, host="usd-exchange").value.split(os.pathsep)
    assert first == str(tmp_path.resolve())
    assert Path(second, "pbrlib", "pbrlib_defs.mtlx").is_file()


def test_a_host_without_a_variable_is_told_of_the_folder(tmp_path):
    installed = mrm.install_library(tmp_path)
    assert told(installed) == ("", "")
    assert f"Search path '{tmp_path}'" in installed.notes()[-1]


def told(installed: mrm.InstalledLibrary) -> tuple[str, str]:
    return installed.variable, installed.value


VALUES = ("/plain", "/with space", "/it's", '/say "so"', "/a$HOME`x`", "/back\\slash")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "pwsh"])
def test_a_shell_takes_the_line_for_what_it_means(shell):
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f"{shell} is not installed")
    name = {"bash": "bash, zsh", "zsh": "bash, zsh", "pwsh": "PowerShell"}.get(shell, shell)
    lines = (f"{assignments('MRM_SAMPLE', value)[name]}\nprintenv MRM_SAMPLE" for value in VALUES)
    done = subprocess.run([program, "-c", "\n".join(lines)], capture_output=True, text=True, check=True)
    assert tuple(done.stdout.splitlines()) == VALUES
