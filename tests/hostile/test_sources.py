"""Shader sources of documents that had generators, or the compilers behind them, open what they should not."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from mrm_mtlx.system.limits import MAXIMUM_DOCUMENT_BYTES, MAXIMUM_INCLUDES

DUST = "void dust(out float x) { x = 0.5; }\n"
INCLUDING = '<?xml version="1.0"?><materialx version="1.39"><xi:include href="parts/m.mtlx"/></materialx>'


@pytest.fixture
def dust(place, document_text):
    """Function from attributes of an implementation to the path of a document whose material needs it."""

    def write(attributes: str, name: str = "m.mtlx", target: str = "genglsl") -> Path:
        elements = (
            '<nodedef name="ND_dust" node="dust"><output name="out" type="float"/></nodedef>'
            f'<implementation name="IM_dust" nodedef="ND_dust" target="{target}" function="dust" {attributes}/>'
            '<dust name="d" type="float"/>'
        )
        return place.write(name, document_text(elements, '<input name="weight" type="float" nodename="d"/>'))

    return write


@pytest.fixture
def codes(check):
    """Function from the path of a document to the codes and messages of what is found in it."""

    def of(path: Path, target: str = "glsl") -> list[tuple[str, str]]:
        return [(f.code, f.message) for result in check(path, targets=(target,)) for f in result.findings]

    return of


def assert_only(found: list[tuple[str, str]], code: str, words: str) -> None:
    assert [f[0] for f in found] == [code]
    assert words in found[0][1]


def test_a_source_beside_the_document_and_what_it_includes_are_used(gl, codes, dust, place):
    place.write("src/dust.glsl", '#include "lib/half.glsl"\n' + DUST.replace("0.5", "HALF"))
    place.write("src/lib/half.glsl", "#define HALF 0.5\n")
    assert codes(dust('file="src/dust.glsl"')) == []
    assert codes(dust('file="src\\dust.glsl"')) == []


def test_what_the_libraries_have_may_be_included(gl, codes, dust, place):
    place.write("dust.glsl", '#include "libraries/stdlib/genglsl/lib/$fileTransformUv"\n' + DUST)
    assert codes(dust('file="dust.glsl"')) == []


@pytest.mark.parametrize("command", ["generate", "validate", "render"])
def test_a_pipe_as_a_source_does_not_make_a_command_wait(in_process, gl, dust, place, pipe, command):
    pipe(place.folder / "dust.glsl")
    path = dust('file="dust.glsl"')
    more = {"generate": (), "validate": ("--target", "glsl"), "render": ("-o", "a.png", "--size", "16")}[command]
    done = in_process(command, path, *more)
    assert done.exit_code == 1
    assert "not a regular file" in " ".join(done.output.split())


# What stands beside a document, and what is wrong with it.
NO_FILES = {"pipe": "is not a regular file", "folder": "is not a regular file", "empty": "is empty"}


@pytest.mark.parametrize("included", [False, True], ids=["named", "included"])
@pytest.mark.parametrize("kind", NO_FILES)
def test_a_source_that_is_no_file_is_not_opened(codes, dust, place, pipe, kind, included):
    path = place.folder / "x.glsl"
    {"pipe": pipe, "folder": Path.mkdir, "empty": Path.touch}[kind](path)
    place.write("dust.glsl", '#include "x.glsl"\n' + DUST)
    found = codes(dust(f'file="{"dust" if included else "x"}.glsl"'))
    assert_only(found, "DOC_FILE", f"'x.glsl' {NO_FILES[kind]}")


@pytest.mark.parametrize("included", [False, True], ids=["named", "included"])
def test_a_source_that_is_nowhere_is_not_taken_from_the_folder_of_the_command(
    codes, dust, place, monkeypatch, included
):
    monkeypatch.chdir(place.outside)
    place.write("dust.glsl", '#include "secret.glsl"\n' + DUST)
    found = codes(dust(f'file="{"dust" if included else "secret"}.glsl"'))
    assert_only(found, "DOC_FILE", "'secret.glsl' does not exist")


def test_a_source_of_an_included_file_is_looked_for_beside_that(gl, codes, dust, place, pipe):
    dust('file="dust.glsl"', "parts/m.mtlx")
    place.write("parts/dust.glsl", DUST)
    pipe(place.folder / "dust.glsl")
    top = place.write(
        "m.mtlx", '<?xml version="1.0"?><materialx version="1.39"><xi:include href="parts/m.mtlx"/></materialx>'
    )
    assert codes(top) == []
    (place.folder / "parts" / "dust.glsl").unlink()
    assert_only(codes(top), "DOC_FILE", "'dust.glsl' does not exist")


def test_a_pipe_beside_an_included_file_is_not_opened(codes, dust, place, pipe):
    dust('file="dust.glsl"', "parts/m.mtlx")
    place.write("dust.glsl", DUST)
    pipe(place.folder / "parts" / "dust.glsl")
    top = place.write(
        "m.mtlx", '<?xml version="1.0"?><materialx version="1.39"><xi:include href="parts/m.mtlx"/></materialx>'
    )
    assert_only(codes(top), "DOC_FILE", "'dust.glsl' is not a regular file")


@pytest.mark.parametrize("included", [False, True], ids=["named", "included"])
def test_a_link_out_of_the_folder_is_not_followed(codes, dust, place, link, included):
    link(place.folder / "x.glsl", place.secrets[".glsl"])
    place.write("dust.glsl", '#include "x.glsl"\n' + DUST)
    found = codes(dust(f'file="{"dust" if included else "x"}.glsl"'))
    assert_only(found, "READ_OUTSIDE", "'x.glsl' lies outside")


def test_steps_to_the_parent_of_a_link_lead_where_materialx_goes(codes, dust, place, link):
    """It takes "deep/../.." for the folder above, and looks whether the file is there by following the link."""
    place.write("a/b/c/x.txt", "")
    place.write("secret.glsl", DUST)
    link(place.folder / "deep", place.folder / "a" / "b" / "c")
    place.write("a/outside/secret.glsl", DUST)  # what the link leads to, three steps up
    assert_only(codes(dust('file="deep/../../outside/secret.glsl"')), "READ_OUTSIDE", "lies outside")


def test_steps_to_the_parent_of_a_link_lead_where_the_system_goes_too(codes, dust, place, link):
    """MaterialX looks whether the file is there by following the link, before it opens another one."""
    place.write("dust.glsl", DUST)
    link(place.folder / "deep", place.secrets[".glsl"].parent)
    (place.secrets[".glsl"].parent.parent / "dust.glsl").write_text(DUST, encoding="utf-8")
    assert_only(codes(dust('file="deep/../dust.glsl"')), "READ_OUTSIDE", "lies outside")


def test_a_tokens_text_does_not_hide_a_pipe(codes, dust, place, pipe):
    place.write("dust.glsl", '#include "$fileTransformUv"\n' + DUST)
    place.write("$fileTransformUv", "// harmless\n")
    pipe(place.folder / "mx_transform_uv.glsl")
    found = codes(dust('file="dust.glsl"'))
    assert_only(found, "DOC_FILE", "'$fileTransformUv' is not a regular file")


# Ways of inclusion that MaterialX leaves to the compiler; "{}" is the file.
LEFT = {
    "a space": '# include "{}"',
    "angle brackets": "# include <{}>",
    "two lines": '#inc\\\nlude "{}"',
    "a comment": '#/* */include "{}"',
    "a digraph": '%:include "{}"',
    "a macro": '#define F "{}"\n# include F',
    "an import": '#import "{}"',
    "an embedding": '#embed "{}"',
    "a question": '#if __has_include("{}")\n#endif',
}


@pytest.mark.parametrize("way", LEFT)
def test_no_compiler_is_left_to_include_a_file(codes, dust, place, way):
    place.write("dust.glsl", LEFT[way].format(place.secrets[".glsl"]) + "\n" + DUST)
    assert_only(codes(dust('file="dust.glsl"')), "READ_INCLUDE", "only a compiler")


def test_code_within_a_document_includes_nothing(codes, dust, place):
    code = f'sourcecode="0.5;&#13;#include &quot;{place.secrets[".glsl"]}&quot;&#13;"'
    assert_only(codes(dust(code)), "READ_INCLUDE", "its code includes a file")


def test_slang_does_not_import_a_module(codes, dust, place):
    place.write("dust.slang", "import secret;\n" + DUST)
    assert_only(codes(dust('file="dust.slang"', target="genslang"), "slang"), "READ_INCLUDE", "only a compiler")


def test_a_line_of_a_comment_is_opened_by_materialx_too(codes, dust, place, pipe):
    pipe(place.folder / "x.glsl")
    place.write("dust.glsl", '// see #include "x.glsl"\n' + DUST)
    assert_only(codes(dust('file="dust.glsl"')), "DOC_FILE", "'x.glsl' is not a regular file")


def test_a_source_without_end_is_not_read(codes, dust, place):
    path = place.write("dust.glsl", DUST)
    os.truncate(path, 2 * MAXIMUM_DOCUMENT_BYTES)
    assert_only(codes(dust('file="dust.glsl"')), "READ_TOO_LARGE", "MiB")


def test_sources_that_include_each_other_in_a_circle_end(gl, codes, dust, place):
    place.write("dust.glsl", '#include "other.glsl"\n' + DUST)
    place.write("other.glsl", '#include "dust.glsl"\n')
    assert {code for code, _ in codes(dust('file="dust.glsl"'))} <= {"SHADER_COMPILE"}


def test_a_chain_of_sources_is_bounded(codes, dust, place):
    last = MAXIMUM_INCLUDES + 1
    for k in range(last):
        place.write(f"x{k}.glsl", f'#include "x{k + 1}.glsl"\n')
    place.write(f"x{last}.glsl", DUST)
    assert_only(codes(dust('file="x0.glsl"')), "READ_INCLUDE", f"more than {MAXIMUM_INCLUDES} levels")


def test_a_folder_that_contains_itself_by_a_link_is_bounded(codes, dust, place, link):
    place.write("a/x.glsl", '#include "loop/x.glsl"\n' + DUST)
    link(place.folder / "a" / "loop", place.folder / "a")
    (found,) = codes(dust('file="a/x.glsl"'))
    assert found[0] in ("READ_INCLUDE", "READ_OUTSIDE", "DOC_FILE")
