"""What the tests share: data libraries, engines, documents from text, the check, the command, and directions to try."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from zlib import crc32

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.library import DataLibrary, Origin, load_library
from mrm_mtlx.validation.collecting import collect
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.options import ValidationOptions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.validation.results import DocumentResult

# The tools lie beside the package, which may be an installed one: it comes first. Worker processes take the path over.
sys.path.append(str(Path(__file__).parents[1]))

pytest_plugins = [
    "tests.fixtures.checks",
    "tests.fixtures.commands",
    "tests.fixtures.drivers",
    "tests.fixtures.environments",
    "tests.fixtures.files",
    "tests.fixtures.material",
    "tests.fixtures.plugins",
    "tests.fixtures.quadrature",
    "tests.fixtures.skips",
]

SEED = 2026

# Chance that any statistical test of the whole suite rejects what is right, and how many tests share it. The reasons,
# and the test that keeps the number true, are in test_false_alarms.py.
FALSE_ALARMS = 1e-3
STATISTICAL_TESTS = 80

# Cosine of the steepest direction drawn: 0.06 degrees from the tangent plane.
GRAZING = 1e-3


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "statistical: decides by random numbers; set on all that ask for `significance`")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if "significance" in getattr(item, "fixturenames", ()):
            item.add_marker("statistical")


@dataclass
class Significance:
    """The chance of a false alarm that a test has, to be shared by its decisions (Sidak)."""

    test: float
    asked: bool = False

    def level(self, decisions: int = 1) -> float:
        """Probability below which each of the test's decisions rejects."""
        self.asked = True
        return float(-np.expm1(np.log1p(-self.test) / decisions))

    def sigmas(self, decisions: int = 1) -> float:
        """The same for means of many numbers: standard deviations, to both sides, beyond which each rejects."""
        from scipy import special

        return float(-special.ndtri(0.5 * self.level(decisions)))


@pytest.fixture(scope="session")
def false_alarms() -> tuple[float, int]:
    """Chance of a false alarm of the whole suite, and the number of tests that share it."""
    return FALSE_ALARMS, STATISTICAL_TESTS


@pytest.fixture(scope="session")
def share_of_false_alarms(false_alarms: tuple[float, int]) -> Callable[[], Significance]:
    """Function that gives the share of one test."""
    rate, tests = false_alarms
    return lambda: Significance(float(-np.expm1(np.log1p(-rate) / tests)))


@pytest.fixture
def significance(share_of_false_alarms: Callable[[], Significance]) -> Iterator[Significance]:
    """The thresholds of a statistical test: from here alone, so that the false alarms of the suite are known."""
    share = share_of_false_alarms()
    yield share
    assert share.asked, "a test that asks for no threshold is not a statistical one"


@pytest.fixture(scope="session")
def library() -> DataLibrary:
    """The node library over the standard one."""
    return load_library()


@pytest.fixture(scope="session")
def upstream_library() -> DataLibrary:
    """The standard library alone."""
    return load_library(Origin.UPSTREAM)


@pytest.fixture(scope="session")
def repository() -> Path:
    """Root of the checkout."""
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def documents(repository: Path) -> Path:
    """Folder with a pair of documents per rule."""
    return repository / "tests" / "rules"


@pytest.fixture(scope="session")
def settings() -> Callable[..., ValidationOptions]:
    """Function to settings of a small run, with some of them changed."""

    def make(**changes: object) -> ValidationOptions:
        small = {"targets": ("glsl",), "samples": 512, "seed": 0, "origin": Origin.MRM, "jobs": 1, "timeout_s": 120.0}
        return ValidationOptions(**{**small, **changes})

    return make


@pytest.fixture(scope="session")
def check(settings: Callable[..., ValidationOptions]) -> Callable[..., list[DocumentResult]]:
    """Function from a path to the results of its documents, checked in this process."""

    def run(path: Path, **changes: object) -> list[DocumentResult]:
        missing, requests = collect([path], settings(**changes))
        return missing + [check_document(request) for request in requests]

    return run


@pytest.fixture
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    """Random numbers that depend on the name of the test alone."""
    return np.random.default_rng([SEED, crc32(request.node.nodeid.encode())])


@pytest.fixture(scope="session")
def make_document(library: DataLibrary) -> Callable[..., mx.Document]:
    """Function from the elements of a document, as text, to the document with its data library set."""

    def make(elements: str, data: DataLibrary = library, attributes: str = "") -> mx.Document:
        document = mx.createDocument()
        text = f'<?xml version="1.0"?><materialx version="1.39" {attributes}>{elements}</materialx>'
        mx.readFromXmlString(document, text)
        document.setDataLibrary(data.document)
        return document

    return make


@pytest.fixture(scope="session")
def surface_document(make_document: Callable[..., mx.Document]) -> Callable[..., mx.Document]:
    """Function from BSDF nodes, as text, to a valid document whose material `m` shows the node `bsdf`."""

    def make(nodes: str, data: DataLibrary | None = None, attributes: str = "") -> mx.Document:
        surface = (
            '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf"/></surface>'
            '<surfacematerial name="m" type="material">'
            '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
        )
        chosen = {} if data is None else {"data": data}
        document = make_document(nodes + surface, attributes=attributes, **chosen)
        valid, message = document.validate()
        assert valid, message
        return document

    return make


@pytest.fixture(scope="session")
def polar() -> Callable[..., Array]:
    """Function from polar angle and azimuth [rad], broadcast, to unit directions."""

    def make(theta: float | Array, phi: float | Array = 0.0) -> Array:
        theta, phi = np.broadcast_arrays(np.asarray(theta, dtype=float), np.asarray(phi, dtype=float))
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)

    return make


@pytest.fixture(scope="session")
def hemisphere() -> Callable[..., Array]:
    """Function that draws unit directions over the upper hemisphere, one in eight of them grazing."""

    def draw(rng: np.random.Generator, count: int) -> Array:
        z = rng.uniform(GRAZING, 1.0, count)
        z[::8] = GRAZING * np.exp(rng.uniform(0.0, np.log(50.0), len(z[::8])))
        phi = rng.uniform(0.0, 2.0 * np.pi, count)
        sine = np.sqrt(1.0 - z * z)
        return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1)

    return draw


@pytest.fixture(scope="session")
def direction_pairs(hemisphere: Callable[..., Array]) -> Callable[..., tuple[Array, Array]]:
    """Function that draws pairs (v, l): a half at random, then v = l, v' = l, and both of these nearly."""

    def draw(rng: np.random.Generator, count: int, spread: float = 0.05) -> tuple[Array, Array]:
        v, l = hemisphere(rng, count), hemisphere(rng, count)
        mirror = np.array([-1.0, -1.0, 1.0])
        quarter = count // 8
        exact_v, exact_m, near_v, near_m = (slice(k * quarter, (k + 1) * quarter) for k in range(4))
        l[exact_v], l[exact_m] = v[exact_v], v[exact_m] * mirror
        for part, around in ((near_v, v[near_v]), (near_m, v[near_m] * mirror)):
            moved = around + rng.normal(0.0, spread, around.shape)
            moved[:, 2] = np.maximum(np.abs(moved[:, 2]), GRAZING)
            l[part] = moved / np.linalg.norm(moved, axis=-1, keepdims=True)
        return v, l

    return draw
