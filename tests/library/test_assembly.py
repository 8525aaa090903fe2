"""The node library for each version of MaterialX: one folder that is whole, of sources that are there once."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath
from posixpath import normpath

import MaterialX as mx
import pytest

from mrm_mtlx.library import node_library_folder
from mrm_mtlx.library.assembly import node_library_files
from mrm_mtlx.library.dialects import DIALECTS

PBRLIB = node_library_folder() / "pbrlib"
NODES = ("conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf")
# Every version of MaterialX that is served: its closures, and whether MSL has implementations of its own.
SERVED = {
    "1.39.0": ("1.39.0", True),
    "1.39.1": ("1.39.0", True),
    "1.39.2": ("1.39.0", False),
    "1.39.3": ("1.39.3", False),
    "1.39.4": ("1.39.3", False),
    "1.39.5": ("", False),
    "1.39.6": ("", False),
}
MSL_LIST = "genmsl/mrm_genmsl_impl.mtlx"


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def document(files: dict[str, bytes]) -> mx.Document:
    """All documents among some files, as one."""
    whole = mx.createDocument()
    for name, content in files.items():
        if name.endswith(".mtlx"):
            part = mx.createDocument()
            mx.readFromXmlString(part, content.decode())
            whole.importLibrary(part)
    return whole


def text_of(whole: mx.Document) -> str:
    options = mx.XmlWriteOptions()
    options.writeXIncludeEnable = False  # the elements themselves, not the files that they come from
    return str(mx.writeToXmlString(whole, options))


def missing(files: dict[str, bytes]) -> list[str]:
    """Sources that documents and sources among some files name, and that are not among them or the standard ones."""
    named = []
    for name, content in files.items():
        pattern = r'file="([^"]+)"' if name.endswith(".mtlx") else r'^#include "([^"]+)"'
        if name.endswith((".mtlx", ".glsl", ".osl")):
            found = re.findall(pattern, content.decode(), re.MULTILINE)
            # MaterialX looks beside the file first, then on the search path, which has the standard library's root.
            named += [
                normpath(PurePosixPath(name).parent / file) for file in found if not file.startswith("libraries/")
            ]
    return sorted(set(named) - files.keys())


@pytest.mark.parametrize("version", SERVED)
def test_each_version_gets_its_closures_and_what_is_common_to_all(version):
    closures, msl = SERVED[version]
    files = node_library_files(version)
    assert list(files) == sorted(files)
    common = {path.relative_to(PBRLIB).as_posix(): path for path in PBRLIB.rglob("*") if path.is_file()}
    common = {name: path for name, path in common.items() if not name.startswith("dialects/")}
    assert files.keys() == common.keys() | ({MSL_LIST} if msl else set())
    own = {
        p.relative_to(PBRLIB / "dialects" / closures).as_posix() for p in (PBRLIB / "dialects" / closures).rglob("*")
    }
    for name, path in common.items():
        if closures and name in own:
            assert files[name] == (PBRLIB / "dialects" / closures / name).read_bytes() != path.read_bytes()
        else:
            assert files[name] == path.read_bytes()


@pytest.mark.parametrize("version", SERVED)
def test_nothing_that_is_named_is_missing(version):
    files = node_library_files(version)
    assert missing(files) == []
    name = "genglsl/lib/mrm_retroreflection.glsl"
    assert missing({other: content for other, content in files.items() if other != name}) == [name]


@pytest.mark.parametrize("version", SERVED)
def test_all_of_it_is_one_valid_library(version, upstream_library):
    whole = document(node_library_files(version))
    names = {implementation.getName() for implementation in whole.getImplementations()}
    targets = ("glsl", "osl", "msl") if SERVED[version][1] else ("glsl", "osl")
    assert names == {f"IM_mrm_{n}_gen{t}" for n in NODES for t in targets} | {"IM_mrm_surface_genosl"}
    whole.importLibrary(upstream_library.document)
    valid, message = whole.validate()
    assert valid, message


def test_the_list_for_msl_is_that_for_glsl():
    whole = document(node_library_files("1.39.1"))
    for node in NODES:
        glsl, msl = (whole.getImplementation(f"IM_mrm_{node}_gen{target}") for target in ("glsl", "msl"))
        assert (msl.getTarget(), msl.getFile()) == ("genmsl", f"../genglsl/{glsl.getFile()}")
        for attribute in ("nodedef", "function"):
            assert msl.getAttribute(attribute) == glsl.getAttribute(attribute) != ""


def test_every_dialect_has_a_version_that_uses_it_and_closures_for_each_node():
    folders = {path.name for path in (PBRLIB / "dialects").iterdir()}
    assert folders == {closures for closures, _ in SERVED.values()} - {""}
    sources = {name for name in contents(PBRLIB) if name.startswith("genglsl/") and name.endswith(".glsl")}
    for folder in folders:
        assert contents(PBRLIB / "dialects" / folder).keys() == sources


def test_the_sources_loaded_as_they_lie_are_the_newest_dialect():
    # A host that scans the folder finds no second definition in the dialects: these have sources alone.
    as_they_lie = mx.createDocument()
    loaded = mx.loadLibraries(["pbrlib"], mx.FileSearchPath(str(node_library_folder())), as_they_lie)
    assert not any("pbrlib/dialects" in path for path in loaded)
    assert {path.suffix for path in (PBRLIB / "dialects").rglob("*") if path.is_file()} == {".glsl"}
    # Files are read in another order.
    assert sorted(text_of(as_they_lie).splitlines()) == sorted(
        text_of(document(node_library_files("1.39.5"))).splitlines()
    )


@pytest.mark.parametrize("version", ["1.38.10", "1.38", "1.36", "1.0"])
def test_a_version_that_is_not_served_is_named_with_the_reason(version):
    with pytest.raises(LookupError, match=rf"serves MaterialX 1\.39\.0 and later, not {version}: it refuses documents"):
        node_library_files(version)
    assert [v for v, spoken in DIALECTS.items() if spoken.unserved] == ["0.0"]


def test_what_is_no_version_is_refused():
    with pytest.raises(ValueError, match="'newest' is no version of MaterialX"):
        node_library_files("newest")
