"""Many documents in processes that may die: every document gets its verdict, and the same one every time."""

from __future__ import annotations

import multiprocessing
import os
import re
import shutil
from pathlib import Path

import pytest

from mrm_mtlx import __version__
from mrm_mtlx.documents.files import shown_path
from mrm_mtlx.findings.finding import Severity
from mrm_mtlx.library import materialx_version
from mrm_mtlx.shadergen import TARGETS
from mrm_mtlx.system.versions import versions
from mrm_mtlx.validation import reports
from mrm_mtlx.validation.collecting import collect
from mrm_mtlx.validation.runner import engines, validate

# Seconds for one document where one of them takes hours. The others take about two; a busy machine needs some more.
PATIENCE_S = 12.0


def codes(result) -> dict[str, list[str]]:
    return {document.path: [f.code for f in document.findings] for document in result.documents}


@pytest.fixture
def folder(tmp_path, monkeypatch, documents):
    """Function that copies documents of the rules into the current folder: name = (code, which)."""
    monkeypatch.chdir(tmp_path)

    def make(**chosen: tuple[str, str]) -> Path:
        for name, (code, which) in chosen.items():
            parts = documents / code / "parts"
            if parts.is_dir():
                shutil.copytree(parts, tmp_path / "parts", dirs_exist_ok=True)
            shutil.copy(documents / code / f"{which}.mtlx", tmp_path / f"{name}.mtlx")
        return Path()

    return make


# What one document does to the others ---------------------------------------------------------------------------------


def test_a_crash_and_a_hang_leave_the_other_documents_checked(gl, folder, settings):
    path = folder(
        a_fine=("READ_XML", "passes"),
        b_crashes=("CHECK_CRASHED", "triggers"),
        c_hangs=("CHECK_TIMEOUT", "triggers"),
        d_wrong=("DOC_UNKNOWN_NODE", "triggers"),
        e_fine=("READ_XML", "passes"),
    )
    heard: list[tuple[int, int]] = []
    result = validate(
        [path, Path("nothing.mtlx")],
        settings(jobs=2, timeout_s=PATIENCE_S),
        lambda done, total: heard.append((done, total)),
    )
    assert codes(result) == {
        "a_fine.mtlx": [],
        "b_crashes.mtlx": ["CHECK_CRASHED"],
        "c_hangs.mtlx": ["CHECK_TIMEOUT"],
        "d_wrong.mtlx": ["DOC_UNKNOWN_NODE"],
        "e_fine.mtlx": [],
        "nothing.mtlx": ["READ_MISSING"],
    }
    by_path = {document.path: document for document in result.documents}
    for name in ("a_fine.mtlx", "e_fine.mtlx"):
        (renderable,) = by_path[name].renderables
        assert renderable.targets["glsl"].status == "pass"
    assert by_path["c_hangs.mtlx"].findings[0].message == f"glsl: not finished within {PATIENCE_S:g} s"
    assert re.search(r"^glsl: the process that checked it died \(.+\)$", by_path["b_crashes.mtlx"].findings[0].message)
    assert heard == [(k, 5) for k in range(1, 6)]
    assert reports.exit_status(result, strict=False) == 1
    assert multiprocessing.active_children() == []


def test_an_exception_inside_a_check_is_a_finding_that_names_it(folder, settings, tmp_path):
    folder(fine=("READ_XML", "passes"))
    # A target that no generator has. The command line does not let it through; here it is an error inside the check.
    result = validate([tmp_path], settings(targets=("cobol",)))
    assert codes(result) == {"fine.mtlx": ["CHECK_CRASHED"]}
    assert result.documents[0].findings[0].message == "cobol: internal error: KeyError: 'cobol'"


# Same input, same verdict ---------------------------------------------------------------------------------------------


def test_reports_are_the_same_bytes_whatever_the_number_of_processes(gl, folder, settings):
    path = folder(
        a=("SHADER_IGNORES_RETRO", "triggers"),
        b=("DOC_UNIFORM_CONNECTED", "triggers"),
        c=("ENERGY_GAIN", "passes"),
        d=("READ_XML", "triggers"),
    )
    one, two, seeded = (
        reports.to_json(validate([path], settings(jobs=jobs, targets=("glsl", "mdl"), seed=seed)))
        for jobs, seed in ((1, 0), (2, 0), (2, 1))
    )
    assert one == two
    assert one != seeded  # the seed matters: the equality above is not that of constants


def test_a_documents_verdict_does_not_depend_on_its_neighbours(gl, folder, check, tmp_path):
    folder(a=("ENERGY_GAIN", "passes"), b=("READ_XML", "passes"))
    together = check(tmp_path)
    alone = [check(tmp_path / name)[0] for name in ("b.mtlx", "a.mtlx")]
    assert together == alone[::-1]


# Which documents, and which findings ----------------------------------------------------------------------------------


def test_folders_are_searched_in_order_and_each_document_is_taken_once(folder, settings, tmp_path):
    folder(b=("READ_XML", "passes"), a=("READ_XML", "passes"))
    (tmp_path / "sub").mkdir()
    for name in ("sub/c.mtlx", "sub/notes.txt", "sub/d.MTLX.bak"):
        shutil.copy("a.mtlx", name)
    missing, requests = collect([Path("b.mtlx"), Path(), Path("sub"), tmp_path / "a.mtlx"], settings())
    assert missing == []
    assert [request.shown for request in requests] == ["b.mtlx", "a.mtlx", "sub/c.mtlx"]


def test_documents_are_reported_by_path_and_the_missing_among_them(folder, settings):
    folder(b=("READ_XML", "triggers"), d=("READ_XML", "triggers"))
    result = validate([Path("d.mtlx"), Path("c.mtlx"), Path("b.mtlx"), Path("a")], settings())
    assert codes(result) == {
        "a": ["READ_MISSING"],
        "b.mtlx": ["READ_XML"],
        "c.mtlx": ["READ_MISSING"],
        "d.mtlx": ["READ_XML"],
    }
    assert [document.path for document in result.documents] == ["a", "b.mtlx", "c.mtlx", "d.mtlx"]


def test_a_folder_without_documents_gives_an_empty_result(tmp_path, settings):
    result = validate([tmp_path], settings())
    assert result.documents == []
    assert reports.exit_status(result, strict=False) == 3


@pytest.mark.parametrize(
    ("select", "ignore", "kept"),
    [
        ((), (), True),
        (("READ",), (), True),
        (("DOC", "READ_MISSING"), (), True),
        (("DOC",), (), False),
        ((), ("DOC",), True),
        ((), ("R",), False),
        (("READ",), ("READ_MISSING",), False),
    ],
)
def test_findings_are_selected_and_ignored_by_their_beginning(settings, select, ignore, kept):
    result = validate([Path("nothing.mtlx")], settings(select=select, ignore=ignore))
    assert codes(result) == {"nothing.mtlx": ["READ_MISSING"] if kept else []}


def test_findings_of_one_document_are_selected_one_by_one(tmp_path, settings):
    (tmp_path / "three.mtlx").write_text(
        '<?xml version="1.0"?><materialx version="1.39"><conductor_bsdf name="a" type="BSDF"/>'
        '<conductor_bsdf name="a" type="BSDF"/><conducter_bsdf name="b" type="BSDF"/>'
        '<conductor_bsdf name="c" type="BSDF"><input name="k" type="float" value="1"/></conductor_bsdf></materialx>',
        encoding="utf-8",
    )
    result = validate([tmp_path], settings(select=("DOC_UNKNOWN", "DOC_DUP"), ignore=("DOC_UNKNOWN_NODE",)))
    assert list(codes(result).values()) == [["DOC_DUPLICATE_NAME", "DOC_UNKNOWN_INPUT"]]


# Paths ----------------------------------------------------------------------------------------------------------------


def test_paths_are_shown_from_the_current_folder_or_by_their_last_two_parts(tmp_path, monkeypatch):
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    assert shown_path(Path("a.mtlx")) == "a.mtlx"
    assert shown_path(here / "sub" / "a.mtlx") == "sub/a.mtlx"
    assert shown_path(tmp_path / "there" / "sub" / "a.mtlx") == "sub/a.mtlx"
    assert not shown_path(Path(os.sep) / "a.mtlx").startswith(os.sep)


def test_documents_of_the_same_name_in_several_folders_are_all_checked(tmp_path, settings, documents):
    for library in ("metal", "paint"):
        (tmp_path / library / "v1").mkdir(parents=True)
        shutil.copy(documents / "READ_XML" / "passes.mtlx", tmp_path / library / "v1" / "white.mtlx")
    _, requests = collect([tmp_path], settings())
    assert len(requests) == 2


# What a report says about the machine ---------------------------------------------------------------------------------


def test_versions_are_those_of_what_a_verdict_depends_on():
    found = versions()
    assert list(found) == ["mrm", "materialx", "numpy", "openimageio", "moderngl", "usd"]
    assert (found["mrm"], found["materialx"]) == (__version__, materialx_version())
    assert all(re.match(r"\d+\.\d+", version) for version in found.values())


def test_engines_say_whether_they_are_there_and_why_not(monkeypatch):
    found = engines(TARGETS)
    assert list(found) == ["gl", "vulkan", "slang", "osl"]
    for state in found.values():
        assert list(state) == ["available", "renderer" if state["available"] else "reason"]
        assert state[list(state)[1]]
    monkeypatch.setenv("PATH", "")  # no compiler is found
    assert engines(("glsl", "vulkan"))["vulkan"] == {"available": False, "reason": "glslangValidator not found"}


def test_severities_are_counted(settings, documents):
    result = validate([documents / "DOC_INPUT_VALUE" / "triggers.mtlx", documents / "DOC_NO_RENDERABLE"], settings())
    assert (result.count(Severity.ERROR), result.count(Severity.WARNING)) == (1, 1)
