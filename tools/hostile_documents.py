"""Documents of all formats that name files which are not theirs, and the folder that they lie in.

Each is a way of naming a file times a name: one that climbs, a link that leaves, an absolute path, a pipe, and so on.
"""

from __future__ import annotations

import json
import os
import zipfile
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


class Place(NamedTuple):
    """The folder of the documents, and the one beside it that nothing is to be opened in."""

    documents: Path
    outside: Path


_MATERIAL = """  <oren_nayar_diffuse_bsdf name="b" type="BSDF">{}</oren_nayar_diffuse_bsdf>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="b"/></surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
"""
_ROOT = '<?xml version="1.0"?>\n<materialx version="1.39" xmlns:xi="http://www.w3.org/2001/XInclude">\n{}</materialx>\n'
# Metadata of the layer, metadata of the material, and an asset that nothing or the base colour uses.
_LAYER = """#usda 1.0
({})
def Scope "Library"
{{
    def Material "Paint" {}
    {{
        uniform string config:mtlx:version = "1.39"
        token outputs:mtlx:surface.connect = </Library/Paint/S.outputs:out>
        def Shader "S"
        {{
            uniform token info:id = "ND_standard_surface_surfaceshader"
            color3f inputs:base_color.connect = </Library/Paint/T.outputs:out>
            token outputs:out
        }}
        def Shader "T"
        {{
            uniform token info:id = "ND_image_color3"
{}            color3f outputs:out
        }}
    }}
}}
"""
_PICTURE_ENDING, _LAYER_ENDING = "png", "usda"


def lay_out(folder: Path) -> Place:
    """Make the two folders, without documents: what these may and may not name."""
    place = Place(folder / "documents", folder / "outside")
    for each in (*place, place.documents / "parts"):
        each.mkdir(parents=True)
    for each in (place.documents, place.documents / "parts", place.outside):
        stem = "secret" if each == place.outside else "own"
        _write_picture(each / f"{stem}.png")
        _write_picture(each / f"{stem}.1001.png")
        (each / f"{stem}.mtlx").write_text(_ROOT.format(f'  <constant name="{stem}" type="float"/>\n'))
        (each / f"{stem}.usda").write_text(_LAYER.format("", "", ""))
        (each / f"{stem}.glsl").write_text("void mx_own(out float result) { result = 1.0; }\n")
        (each / f"{stem}.bin").write_bytes(b"\0" * 64)
        (each / f"{stem}.usdz").write_bytes(_package([("s.usda", _LAYER.format("", "", "").encode())]))
    if hasattr(os, "mkfifo"):
        (place.documents / "linked").symlink_to(place.outside)
        for ending in ("png", "mtlx", "usda", "glsl", "bin", "usdz"):
            (place.documents / f"link.{ending}").symlink_to(place.outside / f"secret.{ending}")
            (place.documents / f"loop.{ending}").symlink_to(place.documents / f"loop.{ending}")
            os.mkfifo(place.documents / f"pipe.{ending}")
        (place.documents / "tiles.1001.png").symlink_to(place.outside / "secret.1001.png")
    return place


def names(place: Place, ending: str) -> dict[str, str]:
    """Names of files by what is hostile about each; the first is harmless."""
    found = {
        "own": f"own.{ending}",
        "climbs": f"../outside/secret.{ending}",
        "climbs_from_a_folder": f"parts/../../outside/secret.{ending}",
        "climbs_with_backslashes": f"..\\outside\\secret.{ending}",
        "absolute": str(place.outside / f"secret.{ending}"),
        "url": f"file://{place.outside}/secret.{ending}",
        "system": "/etc/hostname",
        "link": f"link.{ending}",
        "folder_link": f"linked/secret.{ending}",
        "loop": f"loop.{ending}",
        "pipe": f"pipe.{ending}",
        "folder": "parts",
    }
    if ending == _PICTURE_ENDING:
        found |= {
            "tiles_outside": "linked/secret.<UDIM>.png",
            "tile_link": "tiles.<UDIM>.png",
            "climbing_tiles": "../outside/secret.<UDIM>.png",
        }
    return found


def write_all(place: Place) -> list[Path]:
    """Write the documents; data files last."""
    made = (*_materialx(place), *_usd(place), *_gltf(place), *_data())
    written = []
    for name, content in made:
        path = place.documents / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        written.append(path)
    return written


def _materialx(place: Place) -> Iterator[tuple[str, str]]:
    for what, name in names(place, "mtlx").items():
        include = _ROOT.format('  <xi:include href="{}"/>\n{}')
        yield f"include_{what}.mtlx", include.format(name, _MATERIAL.format(""))
        # Through two files in folders of their own: names are relative to the file that has them, or to the first.
        yield f"parts/third_{what}.mtlx", include.format(name, "")
        yield f"parts/second_{what}.mtlx", include.format(f"third_{what}.mtlx", "")
        yield f"deep_{what}.mtlx", include.format(f"parts/second_{what}.mtlx", _MATERIAL.format(""))
    yield from _images(place)
    yield from _sources(place)


def _images(place: Place) -> Iterator[tuple[str, str]]:
    """An image by its value, with a prefix, through a graph's interface, and by a definition's default."""
    surface = _MATERIAL.format('<input name="color" type="color3" nodename="i"/>')
    through = _MATERIAL.format('<input name="color" type="color3" nodegraph="g" output="out"/>')
    image = '  <image name="i" type="color3"{}><input name="file" type="filename" {}/></image>\n'
    inside = image.format("", 'interfacename="f"') + '  <output name="out" type="color3" nodename="i"/>\n'
    for what, real in names(place, _PICTURE_ENDING).items():
        name = real.replace("<", "&lt;")
        folder, _, last = name.rpartition("/")
        given = f'<input name="f" type="filename" value="{name}"/>'
        direct = image.format("", f'value="{name}"')
        prefixed = image.format(f' fileprefix="{folder}/"', f'value="{last}"')
        graph = f'  <nodegraph name="g">{given}\n{inside}  </nodegraph>\n'
        definition = (
            f'  <nodedef name="ND_own" node="own">{given}<output name="out" type="color3"/></nodedef>\n'
            f'  <nodegraph name="NG_own" nodedef="ND_own">\n{inside}  </nodegraph>\n  <own name="i" type="color3"/>\n'
        )
        yield f"image_{what}.mtlx", _ROOT.format(direct + surface)
        yield f"prefix_{what}.mtlx", _ROOT.format(prefixed + surface)
        yield f"interface_{what}.mtlx", _ROOT.format(graph + through)
        yield f"default_{what}.mtlx", _ROOT.format(definition + surface)


def _sources(place: Place) -> Iterator[tuple[str, str]]:
    """An implementation's file, and what a file or a line of source includes."""
    surface = _MATERIAL.format('<input name="roughness" type="float" nodename="o"/>')
    coded = (
        '  <nodedef name="ND_own" node="own"><output name="out" type="float"/></nodedef>\n'
        '  <implementation name="IM_own" nodedef="ND_own" target="{}" {} function="mx_own"/>\n'
        '  <own name="o" type="float"/>\n'
    )
    for what, name in names(place, "glsl").items():
        yield f"{what}.included.glsl", f'#include "{name}"\nvoid mx_own(out float result) {{ result = 1.0; }}\n'
        forms = {
            "source": ("genglsl", f'file="{name}"'),
            "osl_source": ("genosl", f'file="{name}"'),
            "source_includes": ("genglsl", f'file="{what}.included.glsl"'),
            "source_inline": ("genglsl", f'sourcecode="#include &quot;{name}&quot;"'),
        }
        for form, (target, attribute) in forms.items():
            yield f"{form}_{what}.mtlx", _ROOT.format(coded.format(target, attribute) + surface)


def _usd(place: Place) -> Iterator[tuple[str, str | bytes]]:
    asset = "            asset inputs:file = @{}@\n"
    clips = '( clips = {{ dictionary a = {{ asset[] assetPaths = [@{}@] string primPath = "/Library" }} }} )'
    for what, name in names(place, _LAYER_ENDING).items():
        forms = {
            "sublayer": _LAYER.format(f"subLayers = [@{name}@]", "", ""),
            "reference": _LAYER.format("", f"( references = @{name}@</Library> )", ""),
            "payload": _LAYER.format("", f"( payload = @{name}@</Library> )", ""),
            "arguments": _LAYER.format("", "", asset.format(f"{name}:SDF_FORMAT_ARGS:a=b")),
            "asset": _LAYER.format("", "", asset.format(name)),
            "clips": _LAYER.format("", clips.format(name), ""),
        }  # fmt: skip
        for form, text in forms.items():
            yield f"{form}_{what}.usda", text
        yield f"sublayer_{what}.usdz", _package([("s.usda", forms["sublayer"].encode())])
        yield f"asset_{what}.usdz", _package([("s.usda", forms["asset"].encode())])
    for what, name in names(place, "usdz").items():
        yield f"packed_{what}.usda", _LAYER.format("", "", asset.format(f"{name}[s.usda]"))
        yield f"packed_reference_{what}.usda", _LAYER.format("", f"( references = @{name}[s.usda]@</Library> )", "")
    for what, name in names(place, "mtlx").items():
        yield f"document_{what}.usda", _LAYER.format("", f"( references = @{name}@</MaterialX> )", "")
    for what, name in names(place, _PICTURE_ENDING).items():
        texture = _LAYER.format("", "", asset.format(name))
        yield f"texture_{what}.usda", texture
        yield f"texture_{what}.usdz", _package([("s.usda", texture.encode())])


def _gltf(place: Place) -> Iterator[tuple[str, str]]:
    for what, name in names(place, _PICTURE_ENDING).items():
        for form, uri in (("image", name), ("escaped", name.replace(".", "%2E").replace("/", "%2F"))):
            asset = {
                "asset": {"version": "2.0"},
                "materials": [{"name": "m", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
                "textures": [{"source": 0}],
                "images": [{"uri": uri}],
            }
            yield f"{form}_{what}.gltf", json.dumps(asset)
    for what, name in names(place, "bin").items():
        stored = {
            "asset": {"version": "2.0"},
            "materials": [{"name": "m", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}],
            "images": [{"bufferView": 0, "mimeType": "image/png"}],
            "bufferViews": [{"buffer": 0, "byteLength": 16}],
            "buffers": [{"uri": name, "byteLength": 64}],
        }
        yield f"buffer_{what}.gltf", json.dumps(stored)


def _data() -> Iterator[tuple[str, str]]:
    """Measured data name no files; these have what programs take for names and commands."""
    columns = "observation_deg, entrance_deg, ra_cd_per_lx_m2\n"
    yield "names.csv", f"# name: ../outside/secret\n{columns}0.2, -4, 250\n0.5, -4, 95\n1, -4, 10\n"
    yield "formula.csv", f"{columns}=cmd|'/etc/hostname'!A1, -4, 250\n"
    header = "#DIM 3 1\n#VS 0\n#PARAM_IN ../outside/secret\n#PARAM_OUT X\n"
    yield "include.alta", f'#include "../outside/secret"\n{header}0 0 0 1\n'
    block = {"coefficientOfRetroreflection": 1.0, "sources": "../outside/secret.mtlx"}
    yield "names.json", json.dumps({"$ref": "/etc/hostname", "retroreflectivityData": block})


def _write_picture(path: Path) -> None:
    import numpy as np
    import OpenImageIO as oiio

    out = oiio.ImageOutput.create(str(path))
    out.open(str(path), oiio.ImageSpec(2, 2, 3, "uint8"))
    out.write_image(np.zeros((2, 2, 3), dtype=np.uint8))
    out.close()


def _package(entries: list[tuple[str, bytes]]) -> bytes:
    """A package whose entries begin at multiples of 64 bytes, as USD wants them."""
    from tools.fuzz.text import packed

    return packed(entries, zipfile.ZIP_STORED)
