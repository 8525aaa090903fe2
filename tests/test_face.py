"""The public face: what `import mrm_mtlx` gives, how lazily, and that each command is a function of it."""

from __future__ import annotations

import ast
import inspect
import pickle
import re
import subprocess
import sys
from enum import Enum
from html.parser import HTMLParser
from importlib import import_module
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.cli import (  # fmt: skip
    conformance,
    convert,
    doctor,
    fit,
    generate,
    library,
    photometry,
    plot,
    render,
    rules,
    validate,
    vectors,
)
from mrm_mtlx.findings import rules as catalogue
from mrm_mtlx.photometry.result import PhotometryReport
from mrm_mtlx.validation.results import DocumentResult, RenderableResult, Stage, Status, TargetResult
from mrm_mtlx.validation.screen import CheckReport, ValidationReport, console, print_result
from tests.test_architecture import HEAVY

if TYPE_CHECKING:
    from pathlib import Path

FUNCTIONS = {name: getattr(mrm, name) for name in mrm.__all__ if isinstance(getattr(mrm, name), FunctionType)}
# By command, the functions that its options go to, in order; and what only a command line has.
COMMANDS = {
    validate.validate: ((mrm.validate,), {"report_format", "output"}),
    conformance.conformance: ((mrm.conformance,), {"report_format", "output"}),
    generate.generate: ((mrm.generate,), {"timeout"}),
    render.render: ((mrm.render,), {"timeout"}),
    plot.plot: ((mrm.plot, mrm.plot_figures), {"timeout"}),
    photometry.photometry: ((mrm.photometry,), {"list_standards", "report_format", "output", "timeout"}),
    fit.fit: ((mrm.fit, mrm.fit_class, mrm.fit_classes), {"classes", "report_format"}),
    convert.convert: ((mrm.convert, mrm.compare), {"option", "timeout", "options"}),
    vectors.vectors: ((mrm.vectors,), {"form", "output"}),
    rules.rules: ((mrm.rules,), {"markdown"}),
    doctor.doctor: ((mrm.doctor, mrm.check_host), {"report_format", "coverage"}),
    library.install: ((mrm.install_library,), set()),
}
HOSTILE = '<img src=x onerror="alert(1)">\x1b[31m & "quoted"'


@pytest.fixture
def metal(documents: Path) -> Path:
    """A document of a retroreflective metal."""
    return documents / "SHADER_IGNORES_RETRO" / "triggers.mtlx"


def printed(code: str, *arguments: str) -> str:
    done = subprocess.run([sys.executable, *arguments, *(() if arguments else ("-c", code))], capture_output=True,
                          text=True, input=code if arguments == ("-",) else None, check=True)  # fmt: skip
    return done.stdout


def test_the_package_loads_nothing_before_it_is_used() -> None:
    code = (
        "import sys, mrm_mtlx as mrm\n"
        "before = set(sys.modules); names = dir(mrm)\n"
        f"print([m for m in {(*HEAVY, 'typer')!r} if m in sys.modules], set(sys.modules) - before)\n"
        "mrm.render; mrm.ArgumentError\n"
        f"print([m for m in {(*HEAVY, 'typer')!r} if m in sys.modules])\n"
        "print(set(mrm.__all__) - set(names))"
    )
    assert printed(code).splitlines() == ["[] set()", "[]", "set()"]


def test_what_is_no_name_of_it_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'mrm_mtlx' has no attribute 'frobnicate'"):
        mrm.frobnicate  # type: ignore[attr-defined]  # noqa: B018


@pytest.mark.parametrize("room", ["photometry", "render", "conformance"])
def test_a_function_stays_one_when_the_room_of_its_name_is_imported(room: str) -> None:
    code = (
        f"import mrm_mtlx.{room}\nfrom mrm_mtlx import {room}\nprint(type({room}).__name__, mrm_mtlx.{room} is {room})"
    )
    assert printed(code).split() == ["function", "True"]
    assert isinstance(import_module(f"mrm_mtlx.{room}"), ModuleType)


@pytest.mark.parametrize("name", mrm.__all__)
def test_every_public_name_is_documented_and_keywords_are_named(name: str) -> None:
    value = getattr(mrm, name)
    if name == "__version__":
        return
    assert (value.__doc__ or "").strip()
    if name in FUNCTIONS:
        parameters = inspect.signature(value).parameters.values()
        for parameter in parameters:
            # `arguments, as validate` in the docstring of a sister function names them too.
            assert re.search(rf"\b{parameter.name}\b", value.__doc__), parameter.name
            assert parameter.annotation is not inspect.Parameter.empty
        positional = [p for p in parameters if p.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD]
        assert len(positional) <= 2


def plain(value: Any) -> Any:
    """A default as it is compared: what is empty, off or absent is one thing; names of choices are texts."""
    value = value.value if isinstance(value, Enum) else value
    return None if value in ((), False, inspect.Parameter.empty) else value


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.__name__)
def test_defaults_are_those_of_the_command_line(command: Any) -> None:
    functions, own = COMMANDS[command]
    for name, parameter in inspect.signature(command).parameters.items():
        if name in own:
            continue
        takers = [taker for taker in functions if name in inspect.signature(taker).parameters]
        assert takers, f"{name} goes to no function"
        for taker in takers:
            default = plain(inspect.signature(taker).parameters[name].default)
            # What a command has to have may be left out where a result can be saved.
            assert default == plain(parameter.default) or (name == "output" and default is None)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.__name__)
def test_no_option_of_a_function_is_missing_on_the_command_line(command: Any) -> None:
    functions, _ = COMMANDS[command]
    for taker in functions:
        missing = set(inspect.signature(taker).parameters) - set(inspect.signature(command).parameters)
        assert missing <= {"listener", "options"}


class Reader(HTMLParser):
    """The elements and the text of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: set[str] = set()
        self.words = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        del attrs
        self.elements.add(tag)

    def handle_data(self, data: str) -> None:
        self.words += data


def hostile_results() -> dict[str, Any]:
    """Results with a name that would be markup, of each kind that shows names of documents."""
    found = catalogue.DOC_CYCLE.at(f"/{HOSTILE}", HOSTILE, HOSTILE)
    target = TargetResult(Stage.COMPILE, Status.SKIP, HOSTILE)
    document = DocumentResult(HOSTILE, [found], [RenderableResult(HOSTILE, {"glsl": target})])
    from pathlib import Path

    from mrm_mtlx.photometry.formatting import DocumentReport
    from mrm_mtlx.photometry.report import PhotometryOptions

    return {
        "validation": ValidationReport({}, {}, [document]),
        "check": CheckReport([document]),
        "opened": mrm.OpenDocument(Path(HOSTILE), (found,), (HOSTILE,), None, None),  # type: ignore[arg-type]
        "converted": mrm.Converted(Path(HOSTILE), (found,)),
        "photometry": PhotometryReport((DocumentReport(HOSTILE, reason="broken"),), (), PhotometryOptions()),
    }


@pytest.mark.parametrize("kind", hostile_results())
def test_a_notebook_shows_hostile_names_as_text(kind: str) -> None:
    page = hostile_results()[kind]._repr_html_()
    read = Reader(page)
    assert "img" not in read.elements
    assert "<img src=x" in read.words
    assert "\x1b" not in page
    assert "\x1b" not in repr(hostile_results()[kind])


def test_a_page_that_does_not_escape_would_be_seen() -> None:
    assert "img" in Reader(f"<pre>{HOSTILE}</pre>").elements


SCRIPT = "import mrm_mtlx as mrm\nprint(mrm.check({path!r}).verdict())\n"


@pytest.mark.parametrize("way", ["script", "-c", "-"])
def test_documents_are_checked_from_a_script_without_a_guard_and_from_standard_input(
    metal: Any, tmp_path: Any, way: str
):
    code = SCRIPT.format(path=str(metal))
    (tmp_path / "script.py").write_text(code, encoding="utf-8")
    arguments = {"script": (str(tmp_path / "script.py"),), "-c": (), "-": ("-",)}[way]
    assert printed(code, *arguments) == "PASSED  0 errors, 0 warnings, 1 document\n"


def test_check_finds_what_reading_and_the_structure_show_and_runs_nothing(documents: Any) -> None:
    found = mrm.check([documents / name / "triggers.mtlx" for name in ("DOC_CYCLE", "READ_XML", "ENERGY_GAIN")])
    assert [finding.code for _, finding in found.findings] == ["DOC_CYCLE", "READ_XML"]
    assert not found.passed
    assert all(document.renderables == [] for document in found.documents)
    assert mrm.check(documents / "DOC_VALUE_RANGE" / "triggers.mtlx").passed
    assert not mrm.check(documents / "DOC_VALUE_RANGE" / "triggers.mtlx", strict=True).passed


def test_a_document_that_is_broken_is_an_exception_with_its_findings(documents: Any) -> None:
    with pytest.raises(mrm.DocumentError, match="DOC_CYCLE /second: the nodes feed each other") as caught:
        mrm.open_document(documents / "DOC_CYCLE" / "triggers.mtlx")
    assert [found.code for found in caught.value.findings] == ["DOC_CYCLE"]
    copied = pickle.loads(pickle.dumps(caught.value))
    assert (str(copied), copied.findings) == (str(caught.value), caught.value.findings)


def test_a_file_of_coefficients_is_the_source_of_what_is_found_in_it(
    metal: Any, tmp_path: Any, monkeypatch: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.json").write_text("{}", encoding="utf-8")
    with pytest.raises(mrm.DocumentError) as caught:
        mrm.convert("empty.json", "a.mtlx")
    mrm.convert(metal, "metal.json")
    assumed = mrm.convert("metal.json", "a.mtlx").lost
    assert [found.source.file for found in (*caught.value.findings, *assumed)] == ["empty.json", "metal.json"]


def test_a_wrong_argument_is_a_value_error_that_names_it(metal: Any) -> None:
    for call, argument in (
        (lambda: mrm.render(metal, shape="cube"), "shape"),  # type: ignore[arg-type]
        (lambda: mrm.validate(metal, samples=3), "samples"),
        (lambda: mrm.generate(metal, target="cobol"), "target"),
        (lambda: mrm.open_document(metal, element="other"), "element"),
        (lambda: mrm.open_document(metal, root=["nowhere"]), "root"),
        (lambda: mrm.fit(), "data"),
        (lambda: mrm.fit(ra=[(0.2, -4.0, 250.0)], output="x.json"), "output"),
        (lambda: mrm.plot(light=[99.0]), "light"),
        (lambda: mrm.check([]), "paths"),
        (lambda: mrm.render(metal, environment="nowhere.exr"), "environment"),
        (lambda: mrm.render(metal, environment=3), "environment"),  # type: ignore[arg-type]
        (lambda: mrm.validate(metal, samples="256"), "samples"),  # type: ignore[arg-type]
        (lambda: mrm.validate(metal, samples=256.0), "samples"),  # type: ignore[arg-type]
        (lambda: mrm.validate(metal, timeout="1"), "timeout"),  # type: ignore[arg-type]
        (lambda: mrm.check(3), "paths"),  # type: ignore[arg-type]
        (lambda: mrm.check([None]), "paths"),  # type: ignore[list-item]
        (lambda: mrm.check(metal, jobs=None), "jobs"),  # type: ignore[arg-type]
        (lambda: mrm.open_document(None), "path"),  # type: ignore[arg-type]
        (lambda: mrm.generate([metal]), "path"),  # type: ignore[arg-type]
        (lambda: mrm.generate(metal, target=None), "target"),  # type: ignore[arg-type]
        (lambda: mrm.generate(metal, osl_mode="cycles"), "osl_mode"),
        (lambda: mrm.generate(metal, stated_precision=True), "stated_precision"),
        (lambda: mrm.generate(metal, osl_mode=["aligned"]), "osl_mode"),  # type: ignore[arg-type]
        (lambda: mrm.render(metal, size="64"), "size"),  # type: ignore[arg-type]
        (lambda: mrm.render(metal, light=None), "light"),  # type: ignore[arg-type]
        (lambda: mrm.render(metal, exposure="1"), "exposure"),  # type: ignore[arg-type]
        (lambda: mrm.plot_figures(3, output="a.svg"), "figure"),  # type: ignore[arg-type]
        (lambda: mrm.plot_figures(2, output="a.txt"), "output"),
        (lambda: mrm.convert(metal, None), "output"),  # type: ignore[arg-type]
        (lambda: mrm.convert(metal, "a.usda", preview="no"), "preview"),
        (lambda: mrm.convert(metal, "a.glb", exact=1), "exact"),
        (lambda: mrm.convert(metal, "a.glb", preview=False), "preview"),
        (lambda: mrm.photometry(metal, observation=["0.2"]), "observation"),  # type: ignore[list-item]
        (lambda: mrm.photometry(metal, area="10"), "area"),  # type: ignore[arg-type]
        (lambda: mrm.plot(light="45"), "light"),  # type: ignore[arg-type]
    ):
        with pytest.raises(mrm.ArgumentError) as caught:
            call()
        assert isinstance(caught.value, ValueError)
        assert caught.value.argument == argument
        assert str(caught.value).startswith(f"{argument}: ")


def test_what_takes_several_takes_one_without_a_list(metal: Any, documents: Any) -> None:
    assert mrm.check(metal, exclude="*.tmp").passed
    folder = documents / "DOC_CYCLE"
    assert len(mrm.check(folder, exclude="t*", root=folder).documents) == len(mrm.check(folder).documents) - 1
    assert [found.code for _, found in mrm.check(folder, select="DOC_CYCLE").findings] == ["DOC_CYCLE"]
    assert mrm.check(folder, ignore="DOC_CYCLE").findings == []
    assert str(mrm.plot(model="lambert", light=20)) == str(mrm.plot(model="lambert", light=[20]))
    assert list(mrm.validate(metal, target="mdl").documents[0].renderables[0].targets) == ["mdl"]
    several = str(mrm.fit(ra=[(0.2, -4.0, 250.0)]))
    assert str(mrm.fit(ra=(0.2, -4.0, 250.0))) == str(mrm.fit(ra="0.2:-4:250")) == several
    one = mrm.photometry(metal, observation=0.2, entrance=-4, rotation=0.0)
    assert str(one) == str(mrm.photometry(metal, observation=[0.2], entrance=[-4], rotation=[0.0]))


def test_an_open_document_serves_several_calls_and_is_not_changed(metal: Any, tmp_path: Any) -> None:
    opened = mrm.open_document(metal)
    before = opened.document.asString() if hasattr(opened.document, "asString") else str(opened.document)
    assert mrm.generate(opened, target="osl").files.keys() == {"material.osl"}
    assert mrm.photometry(opened).outcome == "met"
    assert mrm.convert(opened, tmp_path / "a.usda").complete
    assert (opened.document.asString() if hasattr(opened.document, "asString") else str(opened.document)) == before
    with pytest.raises(mrm.ArgumentError, match="root: not with a document that is open"):
        mrm.generate(opened, root=[tmp_path])


def test_what_is_opened_and_what_is_written_shows_itself_with_the_verdict_last(metal: Any, tmp_path: Any) -> None:
    opened = mrm.open_document(metal)
    found = catalogue.INTERCHANGE_LOST.at("/M_a", "a lobe is lost", "")
    assert str(opened) == f"{metal}\nOPENED  1 surface: {opened.elements[0]}"
    file = tmp_path / "a.usda"
    assert str(mrm.Converted(file, ())) == f"WRITTEN  {file}"
    lost, verdict = str(mrm.Converted(file, (found,))).splitlines()
    assert (lost, verdict.startswith(f"WRITTEN  {file}")) == (f"  {found}", True)
    broken = mrm.Converted(file, (catalogue.DOC_CYCLE.at("/M_a", "no", ""),))
    assert not broken.complete
    assert "without what the format cannot say" in str(broken)


def test_a_picture_is_an_array_and_shows_itself(gl: Any, metal: Any, tmp_path: Any) -> None:
    picture = mrm.render(metal, size=16)
    assert np.asarray(picture).shape == (16, 16, 3)
    assert np.asarray(picture, dtype=np.float32).dtype == np.float32
    assert (picture.pixels.dtype, picture.pixels.shape) == (np.dtype(np.uint8), (16, 16, 3))
    assert picture._repr_png_().startswith(b"\x89PNG")
    assert repr(picture).startswith("<Picture of 16 x 16 pixels, radiance up to ")
    picture.save(tmp_path / "a.exr")
    assert (tmp_path / "a.exr").stat().st_size > 0
    with pytest.raises(mrm.ArgumentError, match=r"expected a name that ends in \.png or \.exr"):
        picture.save(tmp_path / "a.jpg")


def test_a_table_that_is_wider_than_the_terminal_is_lines() -> None:
    targets = ("glsl", "essl", "vulkan", "msl", "slang", "wgsl", "osl", "mdl")
    compared = TargetResult(Stage.COMPARE, Status.PASS, median_error=1.2e-7)
    result = ValidationReport(
        {}, {}, [DocumentResult("a.mtlx", [], [RenderableResult("M_a", dict.fromkeys(targets, compared))])]
    )
    for width, lines in ((200, 2), (80, 3)):
        screen = console()
        screen.width = width
        with screen.capture() as captured:
            print_result(screen, result)
        table = captured.get().split("\n")[1 : 1 + lines]
        assert max(map(len, table)) <= width
        assert all(re.search(rf"\b{target}\b", " ".join(table)) for target in targets)
        assert " ".join(table).count("1.2e-07") == len(targets)
        assert "…" not in captured.get()


def test_what_type_checkers_see_is_what_there_is() -> None:
    tree = ast.parse(inspect.getsource(mrm))
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    seen = {
        alias.name: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.asname == alias.name  # what is imported again under its own name is public
    }
    assert seen == mrm._HOMES


def test_what_a_public_function_returns_has_a_public_name() -> None:
    functions = [value for name in mrm.__all__ if inspect.isfunction(value := getattr(mrm, name))]
    returned = {str(inspect.signature(function).return_annotation) for function in functions}
    assert {name for name in returned if not hasattr(mrm, name)} == {"Path", "list[Path]", "str"}
