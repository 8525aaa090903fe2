"""What is mutated: documents of the project, others made of every node definition, and what the project writes of them.

Nothing comes from elsewhere on the machine, so that a mutant is the same wherever it is made.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from tools.fuzz import gltf, text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.library import DataLibrary

REPOSITORY = Path(__file__).resolve().parents[2]
SEEDS = Path(__file__).resolve().parent / "seeds"
# Formats and storage types of the pictures, by ending; two of some.
_PICTURES = {
    "a.png": ("uint8", 3, 5), "b.png": ("uint16", 4, 3), "c.png": ("uint8", 1, 8), "a.jpg": ("uint8", 3, 16),
    "b.jpg": ("uint8", 1, 40), "a.exr": ("half", 3, 6), "b.exr": ("float", 4, 9), "a.hdr": ("float", 3, 12),
    "a.tif": ("uint8", 3, 7), "b.tif": ("float", 1, 5),
}  # fmt: skip


def build(folder: Path, kinds: frozenset[str]) -> None:
    """Write the corpora of some kinds, a folder per kind and ending: `folder/mtlx/.mtlx/000_name`."""
    pictures(folder / "pictures")
    if "mtlx" in kinds:
        _save(folder / "mtlx" / ".mtlx", list(_documents()))
    if "usd" in kinds or "gltf" in kinds:
        _write_converted(folder)
    if "data" in kinds:
        for suffix in (".csv", ".alta", ".json"):
            _save(folder / "data" / suffix, [p.read_bytes() for p in sorted(SEEDS.glob(f"*{suffix}"))])
    if "image" in kinds:
        for suffix in sorted({Path(name).suffix for name in _PICTURES}):
            _save(folder / "image" / suffix, [p.read_bytes() for p in sorted((folder / "pictures").glob(f"*{suffix}"))])


def load(folder: Path, kind: str) -> dict[str, list[bytes]]:
    """The corpus of a kind by ending; one without files has one empty seed."""
    found = sorted((folder / kind).glob("*/*"))
    seeds: dict[str, list[bytes]] = {}
    for path in found:
        seeds.setdefault(path.parent.name, []).append(path.read_bytes())
    return seeds


def pictures(folder: Path) -> None:
    """Write small pictures of all formats."""
    import numpy as np
    import OpenImageIO as oiio

    folder.mkdir(parents=True, exist_ok=True)
    for name, (kind, channels, size) in _PICTURES.items():
        pixels = np.linspace(0.0, 1.0, size * (size + 1) * channels, dtype=np.float32)
        spec = oiio.ImageSpec(size, size + 1, channels, kind)
        spec.attribute("DateTime", "2000:01:01 00:00:00")  # else that of now
        out: Any = oiio.ImageOutput.create(name)
        out.open(str(folder / name), spec)
        out.write_image(pixels.reshape(size + 1, size, channels))
        out.close()


def _save(folder: Path, contents: list[bytes]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number, content in enumerate(contents):
        (folder / f"{number:04}").write_bytes(content)


def _documents() -> Iterator[bytes]:
    """Our own documents, thrice, so that they are as many as those of the node definitions, and these."""
    from mrm_mtlx.library import load_library

    own = [*sorted(SEEDS.glob("*.mtlx")) * 10, *sorted((REPOSITORY / "materials").glob("*.mtlx")) * 4]
    own += sorted((REPOSITORY / "tests" / "rules").glob("*/*.mtlx"))
    for path in own:
        yield path.read_bytes()
    yield from of_definitions(load_library())


def of_definitions(library: DataLibrary) -> Iterator[bytes]:
    """A document for each node definition, with all its inputs written out."""
    for definition in sorted(library.document.getNodeDefs(), key=lambda d: str(d.getName())):
        kind, category = definition.getType(), definition.getNodeString()
        inputs = "".join(
            f'<input name="{i.getName()}" type="{i.getType()}" value="{_escaped(i.getValueString())}"/>'
            for i in definition.getActiveInputs()
            if i.getValueString()
        )
        node = f'<{category} name="n" type="{kind}">{inputs}</{category}>'
        yield f'<?xml version="1.0"?><materialx version="1.39">{node}{_shown(kind)}</materialx>'.encode()


def _escaped(value: str) -> str:
    return value.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")


def _shown(kind: str) -> str:
    """What makes a node of a type renderable."""
    if kind == "surfaceshader":
        return _material("n")
    if kind in ("BSDF", "EDF"):
        name = kind.lower()
        port = f'<input name="{name}" type="{kind}" nodename="n"/>'
        return f'<surface name="s" type="surfaceshader">{port}</surface>{_material("s")}'
    return f'<output name="o" type="{kind}" nodename="n"/>'


def _material(shader: str) -> str:
    port = f'<input name="surfaceshader" type="surfaceshader" nodename="{shader}"/>'
    return f'<surfacematerial name="m" type="material">{port}</surfacematerial>'


def _write_converted(folder: Path) -> None:
    """USD and glTF that the project writes of its materials, and seeds of these formats."""
    import tempfile

    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.formats.reading import read_document
    from mrm_mtlx.formats.registry import format_for
    from mrm_mtlx.library import load_library

    library = load_library()
    found: dict[str, list[bytes]] = {}
    picture = (folder / "pictures" / "a.png").read_bytes()
    with tempfile.TemporaryDirectory(prefix="mrm-") as name:
        work = Path(name)
        for path in sorted((REPOSITORY / "materials").glob("*.mtlx")):
            read = read_document(path, Reach.beside(path), library, work)
            for suffix in (".usda", ".usdc", ".usdz", ".gltf", ".glb"):
                written = work / f"w{suffix}"
                form = format_for(written)
                assert form is not None
                try:
                    form.write(read, written, library)
                except ValueError:  # nothing that the format can say
                    continue
                found.setdefault(suffix, []).append(written.read_bytes())
    own = [p.read_bytes() for p in sorted(SEEDS.glob("*.usda"))]
    own += [p.read_bytes() for p in sorted((REPOSITORY / "tests" / "rules").glob("*/*.usda"))]
    crates = [crate for crate in map(_crate, own) if crate]
    found[".usda"] += own * 3
    found[".usdc"] += crates * 3
    found[".usdz"] += [text.packed([("s.usda", own[0]), ("i.png", picture), ("parts/i.png", picture)], 0)] * 3
    found[".usdz"] += [text.packed([("s.usdc", crate), ("i.png", picture)], 0) for crate in crates]
    assets = list(gltf.assets(picture))
    found[".gltf"] += [asset for asset, _ in assets] * 5
    found[".glb"] += [binary for _, binary in assets] * 5
    for suffix, contents in found.items():
        _save(folder / ("gltf" if suffix.startswith(".gl") else "usd") / suffix, contents)


def _crate(layer: bytes) -> bytes:
    """A layer of text as a crate file; nothing if USD does not read it."""
    import tempfile

    from pxr import Sdf, Tf

    try:
        read = Sdf.Layer.CreateAnonymous(".usda")
        read.ImportFromString(layer.decode())
    except Tf.ErrorException:
        return b""
    with tempfile.TemporaryDirectory(prefix="mrm-") as name:
        path = Path(name) / "l.usdc"
        read.Export(str(path))
        return path.read_bytes()
