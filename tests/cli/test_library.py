"""`mrm library install` and `mrm doctor --host`: what a user types, sees and gets wrong."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import MaterialX as mx
import pytest

from mrm_mtlx.library.hosts import HOSTS, PLUGIN_VARIABLE

PAGES = ("hosts.md", "hosts/openusd.md", "hosts/maya.md")


@pytest.fixture
def here(in_process, repository, tmp_path, monkeypatch):
    """A command run in a folder that has the ready materials, as the pages have them."""
    (tmp_path / "materials").symlink_to(repository / "materials")
    monkeypatch.delenv(PLUGIN_VARIABLE, raising=False)
    return in_process


def needs_another_materialx(command: list[str]) -> bool:
    """Whether a command installs for a MaterialX that is not installed here."""
    host = HOSTS[command[command.index("--host") + 1]] if "--host" in command else HOSTS["plain"]
    version = command[command.index("--for") + 1] if "--for" in command else host.materialx
    return command[:2] == ["library", "install"] and version not in ("", mx.getVersionString())


def run_all(here, monkeypatch, commands: list[list[str]]) -> None:
    for command in commands:
        done = here(*command)
        assert done.exit_code == 0, done.output
        if command[:2] == ["library", "install"]:
            monkeypatch.setenv(PLUGIN_VARIABLE, str(Path(command[2]).resolve()))


def test_the_commands_of_the_pages_run(here, page_commands, monkeypatch):
    commands = [command for page in PAGES for command in page_commands(page) if not needs_another_materialx(command)]
    assert {command[0] for command in commands} == {"library", "convert", "doctor"}
    run_all(here, monkeypatch, commands)


@pytest.mark.versions
def test_the_commands_of_the_pages_for_another_materialx_run(here, page_commands, monkeypatch):
    commands = [command for page in PAGES for command in page_commands(page) if needs_another_materialx(command)]
    assert len(commands) >= 3
    run_all(here, monkeypatch, commands)


def test_files_go_to_stdout_and_what_to_set_to_stderr(here, tmp_path):
    done = here("library", "install", "hosts", "--host", "usd-26.08")
    assert [Path(line).is_file() for line in done.stdout.splitlines()] == [True] * len(done.stdout.splitlines())
    first, *told, last = done.stderr.splitlines()
    said = f"For OpenUSD 26.08, usdview, MaterialX {mx.getVersionString()}"
    assert first == f"{said}; surface models made from the MaterialX that is installed here."
    assert told[0] == f"Set one variable before the host starts, {PLUGIN_VARIABLE}:"
    assert told[1] == f"  bash, zsh  export {PLUGIN_VARIABLE}={tmp_path / 'hosts'}"
    assert [line[2:12].strip() for line in told[1:]] == ["bash, zsh", "fish", "PowerShell", "cmd"]
    assert last == "Then: mrm doctor --host usd-26.08"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--host", "blnder-5.0"], "--host: no host is called 'blnder-5.0'; did you mean blender-5.0? Known: plain, "),
        (["--for", "1.38.10"], "--for: the node library serves MaterialX 1.39.0 and later, not 1.38.10: "),
        (["--for", "1.41.0"], "--for: MaterialX 1.41.0 is not known here: expected one of 1.39.0, 1.39.1, "),
        (["--for", "newest"], "--for: 'newest' is no version of MaterialX, such as 1.39.3"),
        (["--stdlib", "nowhere"], "--stdlib: 'nowhere' is no folder"),
        (
            ["--stdlib", "materials"],
            "--stdlib: no standard library of MaterialX in 'materials': expected a folder that ",
        ),
        (["--form", "graphs"], "--form: 'graphs': expected one of sources, portable"),
    ],
)
def test_what_is_wrong_is_said_in_a_line_and_nothing_is_written(here, tmp_path, arguments, message):
    done = here("library", "install", "hosts", *arguments)
    assert done.exit_code == 2
    assert f"Error: Invalid value for {message}" in done.stderr
    assert not (tmp_path / "hosts").exists()


def test_the_doctor_says_what_is_wrong_and_what_to_do(here, monkeypatch, tmp_path):
    here("library", "install", "hosts", "--host", "usd-26.08")
    done = here("doctor", "--host", "usd-26.08", "--path", "hosts")
    assert done.exit_code == 1
    assert f"variable   wrong  {PLUGIN_VARIABLE} is not set in this shell\n{'':18}to do: mrm library " in done.stdout
    monkeypatch.setenv(PLUGIN_VARIABLE, str(tmp_path / "hosts"))
    done = here("doctor", "--host", "usd-26.08")
    assert done.exit_code == 0
    assert "wrong" not in done.stdout


@pytest.mark.parametrize(
    ("damage", "name", "found"),
    [
        (lambda mrm: (mrm / "mrm_defs.mtlx").unlink(), "folder", "has no folder 'mrm' with the node library"),
        (lambda mrm: (mrm / "mrm_ng.mtlx").unlink(), "library", "files are missing, changed, or of another version"),
        (lambda mrm: (mrm / "mrm_ng.mtlx").write_text("x"), "library", "files are missing, changed, or of another"),
        (lambda mrm: (mrm / "mrm_surface_models.mtlx").unlink(), "models", "mrm_surface_models.mtlx is missing"),
        (lambda mrm: (mrm / "mrm_surface_models.mtlx").write_text("x"), "models", "made from MaterialX of no known"),
    ],
)
def test_the_doctor_sees_a_library_that_is_damaged(here, monkeypatch, tmp_path, damage, name, found):
    here("library", "install", "hosts", "--host", "usd-26.08")
    damage(tmp_path / "hosts" / "mrm")
    report = doctor(here, "usd-26.08")
    assert report["ok"] is False
    assert found in next(check["found"] for check in report["checks"] if check["name"] == name and not check["ok"])


def test_the_doctor_sees_the_library_of_another_host(here, tmp_path):
    here("library", "install", "hosts", "--host", "usd-26.08")
    checks = {c["name"]: c for c in doctor(here, "blender-4.5")["checks"]}
    assert checks["library"]["found"] == "for MaterialX 1.39.5 or 1.39.6, not for 1.39.2"
    assert checks["models"]["found"] == f"made from MaterialX {mx.getVersionString()}, not 1.39.2"
    here("library", "install", "hosts")
    checks = {c["name"]: c for c in doctor(here, "usd-26.08")["checks"]}
    assert checks["models"]["found"] == "written for hosts that choose a definition in another way"


def test_what_the_doctor_and_the_installation_say_can_be_typed_as_it_is(here):
    version = mx.getVersionString()
    host = next(name for name in ("usd-25.08", "usd-26.08") if HOSTS[name].materialx != version)
    done = here("library", "install", "my hosts", "--host", host, "--for", version)
    assert done.stderr.splitlines()[-1] == f"Then: mrm doctor --host {host} --for {version}"
    told = here("doctor", "--host", host, "--for", "1.39.0", "--path", "my hosts").stdout
    assert f"to do: mrm library install 'my hosts' --host {host} --for 1.39.0\n" in told
    assert "--path 'my hosts' --library mrm" in here("library", "install", "my hosts").stderr


def test_a_program_is_asked_also_before_anything_is_installed(here):
    told = here("doctor", "--host", "usd-26.08", "--ask", sys.executable).stdout
    assert "folder     -      no folder is named" in told
    assert "knows no definition of MaterialX" in told  # usd-core


def doctor(here, host: str) -> dict:
    return json.loads(here("doctor", "--host", host, "--path", "hosts", "--format", "json").stdout)


def test_the_doctor_sees_a_variable_that_names_another_folder(here, monkeypatch, tmp_path):
    here("library", "install", "hosts", "--host", "usd-26.08")
    monkeypatch.setenv(PLUGIN_VARIABLE, os.pathsep.join([str(tmp_path / "materials"), "x\x1by"]))
    found = here("doctor", "--host", "usd-26.08").stdout
    assert f"{PLUGIN_VARIABLE} names no folder of the node library, but " in found
    assert "\x1b" not in found
    monkeypatch.setenv(PLUGIN_VARIABLE, os.pathsep.join([str(tmp_path / "materials"), str(tmp_path / "hosts")]))
    assert here("doctor", "--host", "usd-26.08").exit_code == 0


@pytest.mark.parametrize(
    ("program", "found"),
    [
        ("nowhere/python", "nowhere/python does not answer: No such file or directory"),
        (sys.executable, "knows no definition of MaterialX"),  # usd-core
    ],
)
def test_the_doctor_asks_a_program_and_says_what_it_lacks(here, monkeypatch, tmp_path, program, found):
    here("library", "install", "hosts", "--host", "usd-26.08")
    monkeypatch.setenv(PLUGIN_VARIABLE, str(tmp_path / "hosts"))
    done = here("doctor", "--host", "usd-26.08", "--ask", program)
    assert done.exit_code == 1
    assert found in done.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--path", "x"], "Invalid value for --path: goes with --host"),
        (["--ask", "x"], "Invalid value for --ask: goes with --host"),
        (["--host", "usd-26.08", "--coverage"], "Invalid value for --coverage: not with --host"),
        (["--host", "blender"], "Invalid value for --host: no host is called 'blender'; did you mean blender-"),
        (
            ["--host", "plain"],
            "Invalid value for --path: plain has no variable that names the folder of the node library",
        ),
    ],
)
def test_a_wrong_call_of_the_doctor_is_refused(here, arguments, message):
    done = here("doctor", *arguments)
    assert done.exit_code == 2
    assert message in done.stderr
