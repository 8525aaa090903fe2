"""`mrm` with stages of USD: converted both ways, validated, rendered, and what it says when it cannot."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from mrm_mtlx.documents.images import read_image
from mrm_mtlx.validation.collecting import documents_of

MATERIALS = Path(__file__).parents[2] / "materials"
PICTURE = Path(__file__).parents[1] / "rules" / "USD_VALIDATOR_WARNING" / "parts" / "normal.png"
PLATE = MATERIALS / "licence_plate.mtlx"


@pytest.fixture
def here(in_process, tmp_path):
    """Function from arguments of `mrm` to the finished command, run beside the materials."""
    (tmp_path / "materials").symlink_to(MATERIALS)
    return in_process


def test_the_commands_of_omniverses_page_run(here, page_commands):
    commands = page_commands("hosts/omniverse.md")
    assert [command[0] for command in commands] == ["convert", "convert"]
    for command in commands:
        done = here(*command)
        assert done.exit_code == 0, done.stderr
        assert 'uniform token info:id = "UsdPreviewSurface"' in Path("collar.usda").read_text(encoding="utf-8")


def test_the_commands_of_the_page_run(here, page_commands, gl):
    commands = page_commands("usd.md")
    assert {command[0] for command in commands} >= {"convert", "validate", "render", "library"}
    for command in commands:
        small = {"validate": ["--samples", "64", "--target", "glsl", "-j", "1"], "render": ["--size", "16"]}
        done = here(*command, *small.get(command[0], []))
        assert done.exit_code == 0, done.stderr


def test_there_and_back_by_position_or_option_and_nothing_lost(here):
    done = here("convert", PLATE, "plate.usda", "--no-preview")
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", "wrote plate.usda\n")
    assert here("convert", "plate.usda", "-o", "back.mtlx").stderr == "wrote back.mtlx\n"
    assert "<nodegraph name=" in Path("back.mtlx").read_text(encoding="utf-8")


def test_a_look_for_hosts_without_materialx_is_added_and_what_it_lacks_is_told(here):
    done = here("convert", PLATE, "plate.usda")
    assert (done.exit_code, done.stdout) == (0, "")
    first, hint, last = done.stderr.splitlines()
    assert "warning INTERCHANGE_PREVIEW /M_licence_plate: its look for hosts without MaterialX" in first
    assert "--no-preview" in hint
    assert last == "wrote plate.usda"
    assert 'uniform token info:id = "UsdPreviewSurface"' in Path("plate.usda").read_text(encoding="utf-8")
    # It is none of what is read: nothing more is said, and what is written is the same.
    assert here("convert", "plate.usda", "back.mtlx").stderr == "wrote back.mtlx\n"
    assert here("convert", PLATE, "bare.usda", "--no-preview").exit_code == 0
    assert here("convert", "bare.usda", "again.mtlx").exit_code == 0
    assert Path("back.mtlx").read_bytes() == Path("again.mtlx").read_bytes()
    done = here("convert", PLATE, "plate.glb", "--no-preview")
    assert done.exit_code == 2
    assert "only for .usda, .usdc, .usd, .usdz, USD" in " ".join(done.stderr.split())


def test_a_folder_is_searched_for_stages_and_documents(here, tmp_path):
    (tmp_path / "in" / "deep").mkdir(parents=True)
    for name in ("b.usda", "deep/a.mtlx", "c.USDC", "d.usdz", "e.txt", "f.usd"):
        (tmp_path / "in" / name).write_text("")
    found = [path.relative_to(tmp_path / "in").as_posix() for path in documents_of(tmp_path / "in")]
    assert found == ["b.usda", "c.USDC", "d.usdz", "deep/a.mtlx", "f.usd"]


def test_a_picture_of_the_stage_is_that_of_the_document(here, gl):
    here("convert", PLATE, "plate.usdc")
    for source, picture in ((PLATE, "a.exr"), ("plate.usdc", "b.exr")):
        assert here("render", source, "-o", picture, "--size", "32").exit_code == 0
    first, second = read_image(Path("a.exr")), read_image(Path("b.exr"))
    # The same code but for the names of variables: the same pixels.
    assert np.array_equal(first, second)
    assert first[..., :3].std() > 0.01


def test_images_of_a_package_are_copied_beside_the_document(here, tmp_path):
    (tmp_path / "tex").mkdir()
    shutil.copy(PICTURE, tmp_path / "tex" / "a.png")
    Path("t.mtlx").write_text(
        '<materialx version="1.39"><image name="i" type="color3">'
        '<input name="file" type="filename" value="tex/a.png" /></image><surface_unlit name="s" type="surfaceshader">'
        '<input name="emission_color" type="color3" nodename="i" /></surface_unlit>'
        '<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s" />'
        "</surfacematerial></materialx>"
    )
    assert here("convert", "t.mtlx", "t.usdz").exit_code == 0
    assert here("convert", "t.usdz", "u.mtlx").stderr == "wrote u.mtlx\n"
    assert 'value="u/t/tex/a.png"' in Path("u.mtlx").read_text(encoding="utf-8")
    assert Path("u/t/tex/a.png").read_bytes() == Path("tex/a.png").read_bytes()
    # And those of a document beside a stage in another folder, which is checked without the first.
    (tmp_path / "other").mkdir()
    assert here("convert", "t.mtlx", "other/x.usda").exit_code == 0
    checked = here("validate", "other/x.usda", "--target", "vulkan", "-j", "1")
    assert "READ_OUTSIDE" not in checked.stdout
    assert Path("other/x/tex/a.png").read_bytes() == Path("tex/a.png").read_bytes()


def test_what_usd_thinks_of_a_stage_is_told_by_validate_alone(here):
    assert here("convert", PLATE, "plate.usda").exit_code == 0
    text = Path("plate.usda").read_text(encoding="utf-8")
    Path("bare.usda").write_text(text.replace('    defaultPrim = "Materials"\n', ""), encoding="utf-8")
    assert "USD_VALIDATOR" in here("validate", "bare.usda", "--target", "vulkan", "-j", "1").stdout
    done = here("convert", "bare.usda", "back.mtlx")
    assert (done.exit_code, done.stderr) == (0, "wrote back.mtlx\n")


def test_what_is_lost_is_told_and_the_rest_is_written(here):
    text = PLATE.read_text(encoding="utf-8").replace("</materialx>", '<look name="looks" /></materialx>')
    Path("look.mtlx").write_text(text, encoding="utf-8")
    done = here("convert", "look.mtlx", "look.usda", "--no-preview")
    assert done.exit_code == 0
    first, hint, last = done.stderr.splitlines()
    line = text[: text.index("<look ")].count("\n") + 1
    assert first.startswith(f"look.mtlx:{line}:")
    assert first.endswith(": warning INTERCHANGE_LOST /looks: a look has no form in a USD material")
    assert hint.startswith("    ")
    assert last == "wrote look.usda"


CONTROLS = """#usda 1.0
(
    defaultPrim = "M"
    metersPerUnit = 1
    upAxis = "Y"
)
def Material "M" (
    doc = "a\\x01\\x1b[31mb"
)
{
    token outputs:mtlx:surface.connect = </M/s.outputs:out>
    def Shader "s"
    {
        uniform token info:id = "ND_surface"
        token outputs:out
    }
}
"""


def test_control_characters_of_a_stage_reach_no_document(here):
    Path("a.usda").write_text(CONTROLS, encoding="utf-8")
    done = here("convert", "a.usda", "b.mtlx")
    assert done.exit_code == 0
    assert done.stderr.startswith("a.usda: warning INTERCHANGE_LOST /M: its doc has control characters")
    assert 'doc="a[31mb"' in Path("b.mtlx").read_text(encoding="utf-8")
    assert here("convert", "b.mtlx", "c.usda").exit_code == 0


def test_control_characters_of_a_document_do_not_reach_the_terminal(here):
    """U+009B is one that XML may hold, and begins a command to some terminals."""
    declared = '<input name="a\u009bx" type="float" value="0" /><output name="out" type="float" />'
    node = '<own name="o" type="float"><input name="z" type="float" value="1" /></own>'
    Path("own.mtlx").write_text(
        f'<materialx version="1.39"><nodedef name="ND_o" node="own">{declared}</nodedef>{node}</materialx>',
        encoding="utf-8",
    )
    for command in (("convert", "own.mtlx", "own.usda"), ("validate", "own.mtlx", "-j", "1", "--target", "mdl")):
        done = here(*command)
        assert done.exit_code == 1
        assert "Its inputs are a x." in done.output
        assert "\u009b" not in done.output


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        ((PLATE, "no/a.usda"), 2, "the folder no does not exist"),
        ((PLATE, "a.xyz"), 2, "expected a name that ends in .mtlx, .usda,"),
        (("plate.mtlx", "plate.mtlx"), 2, "is the file to be read"),
        ((PLATE, "a.mtlx"), 2, "is MaterialX already"),
        (("a.usda", "b.usdz"), 2, "is USD already"),
        ((PLATE, "a.usda", "-o", "b.usda"), 2, "a.usda is to be written already"),
        ((PLATE, "a.usda", "--observation", "1"), 2, "only for .json"),
        ((PLATE, "folder.usda"), 2, "folder.usda cannot be written: it is not a regular file"),
        (("absent.mtlx", "a.usda"), 1, "error READ_MISSING"),
        (("text.usdc", "a.mtlx"), 1, "error READ_FORMAT: text.usdc is no file of USD"),
        (("nothing.mtlx", "a.usda"), 3, "nothing.mtlx has nothing to render"),
    ],
    ids=str,
)
def test_a_wrong_call_is_told_so_and_writes_nothing(here, arguments, status, message):
    shutil.copy(PLATE, "plate.mtlx")
    Path("text.usdc").write_text("hello")
    Path("nothing.mtlx").write_text('<materialx version="1.39" />')
    Path("folder.usda").mkdir()
    before = sorted(p.name for p in Path().iterdir())
    done = here("convert", *arguments)
    assert (done.exit_code, done.stdout) == (status, "")
    # A usage message is wrapped to the terminal's width.
    assert message in " ".join(done.stderr.split())
    assert sorted(p.name for p in Path().iterdir()) == before
    assert Path("plate.mtlx").read_bytes() == PLATE.read_bytes()


def test_what_is_missing_around_a_material_does_not_fail_its_conversion(mrm_here, documents, tmp_path):
    done = mrm_here("convert", documents / "USD_MISSING" / "triggers.usda", tmp_path / "out.mtlx")
    assert (done.returncode, (tmp_path / "out.mtlx").exists()) == (0, True)
    assert "error USD_MISSING" in done.stderr
