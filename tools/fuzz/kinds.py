"""The kinds of mutants: which endings, how often, and by which mutator."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from tools.fuzz import data, gltf, raw, text, xml

if TYPE_CHECKING:
    from collections.abc import Callable
    from random import Random

    Mutator = Callable[[bytes, Random, bytes], bytes]


class Form(NamedTuple):
    """One of the forms of a kind: the file's ending, its share of the mutants, and the mutator."""

    suffix: str
    share: float
    mutator: Mutator


def _image(content: bytes, rng: Random, other: bytes) -> bytes:
    for _ in range(rng.choice((1, 1, 2, 4))):
        content = raw.mutated(content, rng, other)
    return content


KINDS: dict[str, tuple[Form, ...]] = {
    "mtlx": (Form(".mtlx", 1.0, xml.mutated),),
    "usd": (Form(".usda", 0.45, text.text), Form(".usdc", 0.35, text.crate), Form(".usdz", 0.2, text.package)),
    "gltf": (Form(".gltf", 0.6, gltf.text), Form(".glb", 0.4, gltf.binary)),
    "data": (
        Form(".csv", 0.5, data.text), Form(".alta", 0.3, data.text), Form(".json", 0.19, data.openmaterial),
        Form(".binary", 0.01, data.merl),
    ),
    "image": (
        Form(".png", 0.3, _image), Form(".jpg", 0.2, _image), Form(".exr", 0.2, _image), Form(".hdr", 0.1, _image),
        Form(".tif", 0.2, _image),
    ),
}  # fmt: skip
