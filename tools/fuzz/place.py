"""The folder that a mutant lies in: files that it may name, and such that nothing is to open."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING

from tools.fuzz import text

if TYPE_CHECKING:
    from pathlib import Path

_PART = """<?xml version="1.0"?>
<materialx version="1.39" xmlns:xi="http://www.w3.org/2001/XInclude">{}
  <nodegraph name="NG_{}"><constant name="c" type="float"/><output name="out" type="float" nodename="c"/></nodegraph>
</materialx>
"""
_LAYER = '#usda 1.0\ndef Scope "Library"\n{{\n    def Scope "{}"\n    {{\n    }}\n}}\n'


def lay_out(folder: Path, pictures: Path) -> Path:
    """Make the folder `folder/documents`, with `folder/outside` beside it; return the former.

    In it are pictures of every format, parts of documents and stages, sources, links that leave, and pipes.
    """
    place, outside = folder / "documents", folder / "outside"
    for each in (place / "parts", outside):
        each.mkdir(parents=True, exist_ok=True)
    for suffix in ("png", "jpg", "exr", "hdr", "tif"):
        shutil.copy(pictures / f"a.{suffix}", place / f"i.{suffix}")
        shutil.copy(pictures / f"a.{suffix}", place / "parts" / f"i.{suffix}")
    shutil.copy(pictures / "a.png", place / "i.1001.png")
    shutil.copy(pictures / "a.png", outside / "secret.png")
    (place / "part.mtlx").write_text(_PART.format('<xi:include href="parts/deep.mtlx"/>', "part"))
    (place / "parts" / "deep.mtlx").write_text(_PART.format("", "deep"))
    (outside / "secret.mtlx").write_text(_PART.format("", "secret"))
    for name in ("part", "i"):
        (place / f"{name}.usda").write_text(_LAYER.format("Lobe"))
    (outside / "secret.usda").write_text(_LAYER.format("Secret"))
    (place / "p.usdz").write_bytes(text.packed([("s.usda", _LAYER.format("Lobe").encode())], 0))
    (place / "code.glsl").write_text("void mx_coded(float x, out float result) { result = x; }\n")
    (place / "code.osl").write_text("void mx_coded(float x, output float result) { result = x; }\n")
    if hasattr(os, "mkfifo"):
        (place / "link.png").symlink_to(outside / "secret.png")
        (place / "loop.png").symlink_to(place / "loop.png")
        for name in ("pipe.png", "pipe.mtlx", "pipe.usda"):
            os.mkfifo(place / name)
    return place
