"""Documents of every kind, ours and those of the MaterialX project: our library takes none of them away."""

from __future__ import annotations

import MaterialX as mx
import pytest

from mrm_mtlx.shadergen import GenerationError, generate, renderable_elements


def outcomes(path, library, target: str) -> dict[str, str]:
    """Pixel source of every renderable element of a document; "" where it is refused."""
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(path))
    document.setDataLibrary(library.document)
    found = {}
    for element in renderable_elements(document):
        try:
            found[element.getNamePath()] = generate(element, target, library).sources["pixel"]
        except GenerationError:
            found[element.getNamePath()] = ""
    return found


# What is in the source wherever one of our nodes is.
WRAPPED = {"glsl": "mrm_mirror_view", "osl": "mrm_look_at"}


@pytest.mark.parametrize("target", WRAPPED)
def test_what_generates_with_the_standard_library_generates_with_ours(corpus, library, upstream_library, target):
    paths = sorted(corpus.rglob("*.mtlx"))
    assert paths
    wrapped = 0
    for path in paths:
        ours, stock = outcomes(path, library, target), outcomes(path, upstream_library, target)
        assert {name for name, source in ours.items() if source} == {name for name, source in stock.items() if source}
        wrapped += sum(WRAPPED[target] in source for source in ours.values())
        assert not any("mrm_" in source for source in stock.values())
    # The corpus has all three nodes, and surfaces made of them.
    assert wrapped > len(paths) / 2
