"""The MaterialX document of a fitted material."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from mrm_mtlx.fitting.model import COAT_IOR, DIGITS, Kind, LayerStack, Part, falloff
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from mrm_mtlx.bsdf.arrays import Array

    # Name, type and value of a node's input; the value of a BSDF is the node that it comes from.
    Input = tuple[str, str, Array | str]

# What each layer is.
_DOCS = {
    Part.COAT: "Clear surface, ordinary reflection: index 1.5; the weight is what dirt and texture leave of it.",
    Part.HAZE: "The same surface, where it is less smooth.",
    Part.LOBE: "What comes back to where the light came from.",
    Part.LOBE2: "The wider part of what comes back.",
    Part.DIFFUSE: "What is seen where nothing comes back, mostly by day.",
}
_INDENT = "  "
_COMMENT_WIDTH = 112


def material_name(text: str) -> str:
    """A name that a document can have, from any text: letters, digits and underscores; "sheet" if none is left."""
    name = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower()
    return name if name and not name[0].isdigit() else f"sheet_{name}".rstrip("_")


def write(
    stack: LayerStack,
    values: Mapping[str, Array],
    name: str,
    notes: Sequence[str],
    docs: Mapping[Part, str] | None = None,
    *,
    doc: str = "",
) -> str:
    """A document with one material, `M_<name>`.

    Parameters
    ----------
    stack, values
        The material; values as a document has them (`LayerStack.rounded`).
    name
        See `material_name`.
    notes
        Where the numbers come from: paragraphs of the comment at its top.
    docs
        What a layer is, by part, in the place of the usual words.
    doc
        Of the material: what it is, or how it was made.

    Returns
    -------
    str
        XML, which depends on the arguments alone.
    """
    told = {**_DOCS, **(docs or {})}
    nodes = [line for part in stack.parts for line in _layer(stack, values, part, told[part])]
    joints, top = _joints(stack, values)
    graph = [
        f'<nodegraph name="NG_{name}">',
        *(_INDENT + line for line in [*nodes, *joints, f'<output name="out" type="BSDF" nodename="{top}" />']),
        "</nodegraph>",
    ]
    surface = [
        f'<surface name="SR_{name}" type="surfaceshader">',
        f'  <input name="bsdf" type="BSDF" nodegraph="NG_{name}" output="out" />',
        "</surface>",
    ]
    material = [
        f'<surfacematerial name="M_{name}" type="material"{f" doc={quoteattr(doc)}" if doc else ""}>',
        f'  <input name="surfaceshader" type="surfaceshader" nodename="SR_{name}" />',
        "</surfacematerial>",
    ]
    blocks = [_comment(notes), graph, surface, material]
    body = "\n\n".join("\n".join(_INDENT + line if line else "" for line in block) for block in blocks)
    head = '<?xml version="1.0"?>\n<materialx version="1.39" colorspace="lin_rec709">\n\n'
    return f"{head}{body}\n\n</materialx>\n"


def _layer(stack: LayerStack, values: Mapping[str, Array], part: Part, doc: str) -> list[str]:
    own = {name: values[f"{part}.{name}"] for name in stack.inputs(part)}
    inputs: list[Input]
    if part.kind is Kind.DIFFUSE:
        inputs = [("color", "color3", _three(own["color"])), ("roughness", "float", own.get("roughness", np.zeros(1)))]
        return _node("oren_nayar_diffuse_bsdf", part, "BSDF", inputs, doc)
    width = ("roughness", "vector2", np.repeat(own["alpha"][:1], 2))
    if part.kind is Kind.CLEAR:
        inputs = [("weight", "float", values["coat.weight"][:1]), ("ior", "float", np.array([COAT_IOR])), width]
        return _node("dielectric_bsdf", part, "BSDF", [*inputs, _REFLECTS], doc)
    color0 = stack.color0(values, part)
    color90, exponent = falloff(stack, color0, own)
    inputs = [("color0", "color3", color0), ("color90", "color3", color90), ("exponent", "float", np.array([exponent]))]
    if "color82" in own:
        inputs.insert(1, ("color82", "color3", _three(own["color82"])))
    return _node("generalized_schlick_bsdf", part, "BSDF", [*inputs, width, _RETROREFLECTS, _REFLECTS], doc)


_REFLECTS = ("scatter_mode", "string", "R")
_RETROREFLECTS = ("retroreflective", "boolean", "true")


def _joints(stack: LayerStack, values: Mapping[str, Array]) -> tuple[list[str], str]:
    """The nodes that put the layers together, and the name of the last."""
    parts: list[str] = list(stack.parts)
    lines = []
    inputs: list[Input]
    if stack.coats == 2:
        inputs = [("fg", "BSDF", Part.HAZE), ("bg", "BSDF", Part.COAT), ("mix", "float", values["haze.share"][:1])]
        lines += _node("mix", "surface_layer", "BSDF", inputs, "Gloss and haze of one surface.")
        parts[:2] = ["surface_layer"]
    below = parts[-1]
    for part in reversed(parts[:-1]):
        name = f"{part}_over_{below.partition('_over_')[0]}"
        inputs = [("top", "BSDF", part), ("base", "BSDF", below)]
        lines += _node("layer", name, "BSDF", inputs, "What is above takes its share first.")
        below = name
    return lines, below


def _node(category: str, name: str, kind: str, inputs: Sequence[Input], doc: str) -> list[str]:
    lines = [f'<{category} name="{name}" type="{kind}" doc={quoteattr(doc)}>']
    for input_name, input_kind, value in inputs:
        if input_kind == "BSDF":
            given = f'nodename="{value}"'
        else:
            given = f'value="{value if isinstance(value, str) else _numbers(value)}"'
        lines.append(f'  <input name="{input_name}" type="{input_kind}" {given} />')
    return [*lines, f"</{category}>"]


def _three(value: Array) -> Array:
    return np.broadcast_to(value, (3,))


def _numbers(value: Array) -> str:
    return ", ".join(f"{x:.{DIGITS}g}" for x in value)


def _comment(notes: Sequence[str]) -> list[str]:
    """Paragraphs as an XML comment; two hyphens, which would end it, become one."""
    import textwrap

    lines = []
    for note in notes:
        plain = re.sub(r"-{2,}", "-", printable(note))
        lines += textwrap.wrap(plain, _COMMENT_WIDTH, initial_indent=_INDENT, subsequent_indent=_INDENT)
    return ["<!--", *lines, "-->"]
