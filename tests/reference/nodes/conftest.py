"""Nodes of numbers, drawn by the generated GLSL and evaluated by the reference, many of them in one shader.

Each node has a stretch of the samples to itself, with inputs of its own from geometric properties; an integer property
says which node a sample shows. A matrix has a stretch per row. The reference evaluates each node alone: a tolerance is
that of one node.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple
from zlib import crc32

import numpy as np
import pytest

from mrm_mtlx.engines.base import Lighting
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import ShadingPoints, Surface
from mrm_mtlx.shadergen import generate
from tests.fixtures.versions import NODES_AS_WRITTEN

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    import MaterialX as mx

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.reference import Tolerance
    from mrm_mtlx.shadergen import Shader

# Samples of a stretch; the first quarter of them has special values: ends, middle, 0, halves and ones.
SAMPLES = 96

WIDTHS = {"float": 1, "color3": 3, "color4": 4, "vector2": 2, "vector3": 3, "vector4": 4, "integer": 1}
MATRICES = {"matrix33": (3, "vector3"), "matrix44": (4, "vector4")}
LETTERS = {"color": "rgba", "vector": "xyzw"}
TEXTS = ("string", "filename")

# How much of a fourth channel is shown.
PART = '<input name="in2" type="float" value="0.375"/>'

SEED = 2026


@dataclass(frozen=True)
class Domain:
    """Where an input is drawn from: [low, high], or also its negative; `special`: values on purpose among them."""

    low: float = -2.0
    high: float = 2.0
    signed: bool = False
    special: bool = True
    whole: bool = False

    def draw(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        values = rng.uniform(self.low, self.high, shape)
        if self.special:
            special = np.array([self.low, self.high, 0.5 * (self.low + self.high), 0.0, 0.5, -0.5, 1.0, -1.0])
            within = special[(special >= self.low) & (special <= self.high)]
            quarter = shape[0] // 4
            values[:quarter] = rng.choice(within, values[:quarter].shape)
        if self.signed:
            values *= rng.choice([-1.0, 1.0], shape)
        return np.round(values) if self.whole else np.asarray(values, dtype=np.float32).astype(float)


PROPER = Domain(0.0, 1.0)
APART = Domain(0.2, 2.0, signed=True, special=False)

# By node and input, or by input alone: where the function is defined.
DOMAINS = {
    ("acos", "in"): Domain(-1.0, 1.0),
    ("asin", "in"): Domain(-1.0, 1.0),
    ("atan2", "inx"): APART,
    ("burn", "fg"): Domain(0.1, 1.0),
    ("cos", "in"): Domain(-3.1, 3.1),
    ("divide", "in2"): APART,
    ("dodge", "fg"): Domain(0.0, 0.9),
    ("exp", "in"): Domain(-10.0, 5.0),
    ("ifequal", "value1"): Domain(-1.0, 1.0, whole=True),
    ("ifequal", "value2"): Domain(-1.0, 1.0, whole=True),
    ("invertmatrix", "in"): Domain(special=False),  # no singular ones
    ("ln", "in"): Domain(0.01, 20.0),
    ("modulo", "in2"): APART,
    ("normalize", "in"): Domain(special=False),  # no zero vectors, which have no direction
    ("transformnormal", "in"): Domain(special=False),
    ("power", "in1"): Domain(0.01, 3.0),
    ("power", "in2"): Domain(-3.0, 3.0),
    ("sin", "in"): Domain(-3.1, 3.1),
    ("smoothstep", "in"): Domain(-2.0, 3.0),
    ("sqrt", "in"): Domain(0.0, 4.0),
    ("tan", "in"): Domain(-1.5, 1.5),
    ("unpremult", "in"): Domain(0.1, 1.0),
    ("hsvtorgb", "in"): PROPER,
    ("rgbtohsv", "in"): PROPER,
    ("normalmap", "in"): Domain(0.0, 1.0, special=False),
    ("normalmap", "scale"): Domain(0.0, 2.0),
    "axis": Domain(special=False),
    "normal": Domain(special=False),
    "tangent": Domain(special=False),
    "bitangent": Domain(special=False),
    "amount": Domain(-400.0, 400.0),
    "bg": PROPER,
    "center": Domain(0.3, 0.45),
    "fg": PROPER,
    "high": Domain(0.5, 2.0),
    "inhigh": Domain(0.5, 2.0),
    "inlow": Domain(-1.0, 0.25),
    "low": Domain(-1.0, 0.25),
    "mask": PROPER,
    "mix": PROPER,
    "texcoord": Domain(-0.25, 1.25),
}

# What cannot vary from sample to sample, by node: each of these is a node of its own.
SPACES = [{"space": space} for space in ("object", "model", "world")]
CHANGES = [{}, {"fromspace": "object", "tospace": "world"}, {"fromspace": "world", "tospace": "object"}]
NUMBERS = {
    "float": "0.3",
    "color3": "0.1, 0.2, 0.3",
    "color4": "0.1, 0.2, 0.3, 0.4",
    "vector2": "0.1, 0.2",
    "vector3": "0.1, 0.2, 0.3",
    "vector4": "0.1, 0.2, 0.3, 0.4",
    "integer": "-7",
    "boolean": "true",
    "matrix33": "0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9",
    "matrix44": "0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6",
}
VARIANTS = {
    "position": SPACES,
    "normal": SPACES,
    "tangent": SPACES,
    "bitangent": SPACES,
    "viewdirection": SPACES,
    "transformpoint": CHANGES,
    "transformvector": CHANGES,
    "transformnormal": CHANGES,
}


def variants(definition: Any) -> list[dict[str, str]]:
    """Literal inputs of the nodes that stand for a definition."""
    kind = str(definition.getActiveOutputs()[0].getType())
    if definition.getNodeString() == "constant":
        return [{"value": NUMBERS[kind]}]
    if definition.getName() == "ND_geompropvalue_boolean":  # in GLSL a uniform, which the engine leaves at false
        return [{"geomprop": "absent", "default": "false"}]
    if definition.getNodeString() == "geompropvalue":  # of the property that its default is connected to as well
        return [{"geomprop": f"{kind}_0"}]
    return VARIANTS.get(definition.getNodeString(), [{}])


@dataclass(frozen=True)
class Shown:
    """A node, or one row of it: the surface that shows it, its samples, and what was drawn for these."""

    label: str
    document: mx.Document  # elements do not keep it alive
    surface: str
    points: ShadingPoints
    found: Array

    def tolerance(self) -> Tolerance:
        """What the reference, as it is now, expects."""
        return Surface(self.document.getNode(self.surface), deviations=NODES_AS_WRITTEN).tolerance(self.points)


class Stretch(NamedTuple):
    """Samples that show a node: its colour, and the properties that it reads."""

    label: str
    color: str
    properties: dict[str, Array]


class Sheet:
    """The document of a set of nodes, and the properties of the samples that show them."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self._nodes: dict[str, str] = {}
        self._properties: dict[str, str] = {}  # type by name
        self.stretches: list[Stretch] = []

    def add(self, definition: Any, given: Mapping[str, str], *, varying: bool) -> None:
        """A node with these literal inputs; its others vary from sample to sample, or are left at their defaults."""
        category = str(definition.getNodeString())
        inputs, drawn, ranks = "", {}, defaultdict(count)
        for declared in definition.getActiveInputs():
            name, kind = str(declared.getName()), str(declared.getType())
            if name in given:
                inputs += f'<input name="{name}" type="{kind}" value="{given[name]}"/>'
            elif varying and kind not in TEXTS and not declared.getIsUniform():
                domain = DOMAINS.get((category, name), DOMAINS.get(name, Domain()))
                source = self._varying(kind, domain, ranks, drawn)
                inputs += f'<input name="{name}" type="{kind}" nodename="{source}"/>'
        kind = str(definition.getActiveOutputs()[0].getType())
        node = self._node(category, kind, inputs, f' nodedef="{definition.getName()}"')
        label = " ".join([str(definition.getName()), *given.values()])
        self.stretches += [Stretch(label, color, drawn) for color in self._colors(node, kind)]

    def document(self) -> str:
        """Surfaces s0, s1, ... that show one colour each, and the material m that chooses by the property `shown`."""
        chosen = ""
        text = property_node("shown", "integer")
        for k, stretch in enumerate(self.stretches):
            before = f'<input name="in2" type="color3" nodename="{chosen}"/>' if chosen else ""
            chosen = f"chosen{k}"
            text += (
                f'<ifequal name="{chosen}" type="color3"><input name="value1" type="integer" nodename="shown"/>'
                f'<input name="value2" type="integer" value="{k}"/>'
                f'<input name="in1" type="color3" nodename="{stretch.color}"/>{before}</ifequal>'
                + unlit(f"s{k}", stretch.color)
            )
        text += unlit("s", chosen) + '<surfacematerial name="m" type="material">'
        text += '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
        properties = (property_node(name, kind) for name, kind in self._properties.items())
        return "".join([*properties, *self._nodes.values(), text])

    def properties(self) -> dict[str, Array]:
        """Properties of all samples, those of one stretch after the other; 0 where they are not used."""
        values = {"shown": np.repeat(np.arange(len(self.stretches), dtype=float), SAMPLES)}
        for name, kind in self._properties.items():
            shape = (SAMPLES,) if WIDTHS[kind] == 1 else (SAMPLES, WIDTHS[kind])
            values[name] = np.concatenate([stretch.properties.get(name, np.zeros(shape)) for stretch in self.stretches])
        return values

    def _varying(self, kind: str, domain: Domain, ranks: Mapping[str, Iterator[int]], drawn: dict[str, Array]) -> str:
        """The node that gives a varying value of this type."""
        if kind in MATRICES:
            size, row = MATRICES[kind]
            rows = [self._varying(row, domain, ranks, drawn) for _ in range(size)]
            inputs = "".join(
                f'<input name="in{n}" type="{row}" nodename="{source}"/>' for n, source in enumerate(rows, 1)
            )
            return self._node("creatematrix", kind, inputs)
        if kind == "boolean":
            source = self._varying("float", PROPER, ranks, drawn)
            half = '<input name="value2" type="float" value="0.55"/>'
            return self._node("ifgreater", kind, f'<input name="value1" type="float" nodename="{source}"/>{half}')
        name = f"{kind}_{next(ranks[kind])}"
        self._properties[name] = kind
        shape = (SAMPLES,) if WIDTHS[kind] == 1 else (SAMPLES, WIDTHS[kind])
        drawn[name] = replace(domain, whole=domain.whole or kind == "integer").draw(self.rng, shape)
        return name

    def _colors(self, source: str, kind: str) -> list[str]:
        """Nodes of type color3 that show a node's value; what is fourth is added to the third."""
        given = f'<input name="in" type="{kind}" nodename="{source}"/>'
        if kind == "color3":
            return [source]
        if kind in MATRICES:
            # Rows as products with unit vectors: `extract` indexes by a uniform, for which LLVM takes seconds.
            size, row = MATRICES[kind]
            ones = (", ".join(str(x) for x in unit) for unit in np.eye(size))
            inputs = (f'<input name="in" type="{row}" value="{one}"/>' + given.replace('"in"', '"mat"') for one in ones)
            return [c for product in inputs for c in self._colors(self._node("transformmatrix", row, product), row)]
        if kind in ("integer", "boolean"):
            source = self._node("convert", "float", given)
        channels = [f'nodename="{source}"']
        if WIDTHS.get(kind, 1) > 1:
            parts = self._node(f"separate{WIDTHS[kind]}", "multioutput", given)
            channels = [f'nodename="{parts}" output="out{c}"' for c in LETTERS[kind[:-1]][: WIDTHS[kind]]]
        if len(channels) == 4:
            part = self._node("multiply", "float", f'<input name="in1" type="float" {channels.pop()}/>{PART}')
            terms = (
                f'<input name="in1" type="float" {channels.pop()}/><input name="in2" type="float" nodename="{part}"/>'
            )
            channels.append(f'nodename="{self._node("add", "float", terms)}"')
        shown = "".join(f'<input name="in{n}" type="float" {channel}/>' for n, channel in enumerate(channels, 1))
        return [self._node("combine3", "color3", shown)]

    def _node(self, category: str, kind: str, inputs: str, attributes: str = "") -> str:
        name = f"n{len(self._nodes)}"
        self._nodes[name] = f'<{category} name="{name}" type="{kind}"{attributes}>{inputs}</{category}>'
        return name


def property_node(name: str, kind: str) -> str:
    """The node, of the same name, that reads a geometric property."""
    place = f'<input name="geomprop" type="string" value="{name}"/>'
    return f'<geompropvalue name="{name}" type="{kind}">{place}</geompropvalue>'


def unlit(name: str, color: str) -> str:
    """A surface that shows a colour."""
    shown = f'<input name="emission_color" type="color3" nodename="{color}"/>'
    return f'<surface_unlit name="{name}" type="surfaceshader">{shown}</surface_unlit>'


def random_points(rng: np.random.Generator, properties: Mapping[str, Array]) -> ShadingPoints:
    """Samples in random frames, seen from the origin."""
    count = len(properties["shown"])
    frames = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0].astype(np.float32).astype(float)
    view = frames[:, 2]
    return ShadingPoints(
        view=view,
        light=np.array([0.0, 0.0, 1.0]),
        normal=frames[:, 0],
        tangent=frames[:, 1],
        position=-view,
        texcoord=rng.uniform(0.0, 1.0, (count, 2)).astype(np.float32).astype(float),
        properties=properties,
    )


def draw(shader: Shader, points: ShadingPoints) -> Array:
    """What a shader shows at these samples, (samples, 3)."""
    with SurfaceProgram(shader) as program:
        geometry = (points.position, points.normal, points.tangent, points.texcoord)
        inputs = program.surface_inputs(*geometry, points.properties)
        return program.draw(inputs, Lighting())[:, :3]


@pytest.fixture(scope="module")
def shown(gl, library: DataLibrary, make_document) -> Callable[..., list[Shown]]:
    """Function from definitions to what is drawn of their nodes, with inputs that vary.

    Instead of its name, a definition may be given with literal inputs; the others are left at their defaults then.
    """

    def draw_all(nodes: Iterable[str | tuple[str, Mapping[str, str]]]) -> list[Shown]:
        listed = list(nodes)
        sheet = Sheet(np.random.default_rng([SEED, crc32(str(listed).encode())]))
        for node in listed:
            name, literals = (node, None) if isinstance(node, str) else node
            definition = library.document.getNodeDef(name)
            for given in variants(definition) if literals is None else [literals]:
                sheet.add(definition, given, varying=literals is None)
        document = make_document(sheet.document())
        points = random_points(sheet.rng, sheet.properties())
        found = draw(generate(document.getNode("m"), "glsl", library), points)
        parts = (slice(k * SAMPLES, (k + 1) * SAMPLES) for k in range(len(sheet.stretches)))
        return [
            Shown(stretch.label, document, f"s{k}", points.part(part), found[part])
            for k, (stretch, part) in enumerate(zip(sheet.stretches, parts, strict=True))
        ]

    return draw_all


@pytest.fixture(scope="module")
def evaluated(library: DataLibrary, make_document) -> Callable[..., Array]:
    """Function from a definition and literal inputs to what the reference shows of the node, a row per colour."""

    def shade(name: str, given: Mapping[str, str]) -> Array:
        sheet = Sheet(np.random.default_rng(SEED))
        sheet.add(library.document.getNodeDef(name), given, varying=False)
        document = make_document(sheet.document())
        points = random_points(sheet.rng, sheet.properties())
        return np.array([Surface(document.getNode(f"s{k}")).shade(points)[0] for k in range(len(sheet.stretches))])

    return shade


@pytest.fixture
def excess(compared: Callable[..., tuple[Tolerance, Array]]) -> Callable[..., Array]:
    """As the module's `compared`: error over allowance per sample."""

    def compare(*args: Any, **options: Any) -> Array:
        tolerance, found = compared(*args, **options)
        return tolerance.excess(found)

    return compare
