"""Nodes and their inputs, against the node definitions."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING, Any

from mrm_mtlx.library.surface_models import FLAG, amounts_of
from mrm_mtlx.validation.checks.connections import check_uniform
from mrm_mtlx.validation.checks.elements import library_of, location
from mrm_mtlx.validation.checks.values import check_value
from mrm_mtlx.validation.findings import Finding, finding

if TYPE_CHECKING:
    from collections.abc import Iterator


def check_node(node: Any) -> Iterator[Finding]:
    """Whether the node is defined, and its inputs with it."""
    definition = node.getNodeDef()
    if definition is None:
        yield from _undefined(node)
        return
    for given in node.getInputs():
        declared = definition.getActiveInput(given.getName())
        if declared is None:  # of the definition that the node names
            yield _unknown_input(given, node, [definition])
        else:
            yield from check_value(given, declared)
            yield from check_uniform(given, declared)


def _undefined(node: Any) -> Iterator[Finding]:
    """Why a node has no definition: no such category, an unknown input, a wrong type."""
    category = node.getCategory()
    definitions = node.getDocument().getMatchingNodeDefs(category)
    if not definitions:
        known = {d.getNodeString() for d in node.getDocument().getNodeDefs()}
        known |= {d.getNodeString() for d in library_of(node).getNodeDefs()}
        if category.startswith("ND_"):  # the name of a definition, as USD's shaders have
            known = {d.getName() for d in library_of(node).getNodeDefs()}
        near = difflib.get_close_matches(category, sorted(known), 1)
        message = f"there is no node '{category}'" + (f"; did you mean '{near[0]}'?" if near else "")
        yield finding("DOC_UNKNOWN_NODE", location(node), message)
        return
    fitting = [d for d in definitions if d.getType() == node.getType()]
    if not fitting:
        types = ", ".join(sorted({d.getType() for d in definitions}))
        message = f"'{category}' of type {node.getType()} is not defined; it exists for {types}"
        yield finding("DOC_UNKNOWN_NODE", location(node), message)
        return
    version = node.getVersionString()
    if version and not any(d.isVersionCompatible(version) for d in fitting):
        versions = ", ".join(dict.fromkeys(d.getVersionString() or "none" for d in fitting))
        message = f"version {version} of '{category}' is not defined; it exists in {versions}"
        hint = "Remove the node's version, or name one that exists."
        yield finding("DOC_UNKNOWN_NODE", location(node), message, hint)
        return
    explained = False
    for given in node.getInputs():
        name = given.getName()
        declared = [d.getActiveInput(name) for d in fitting if d.getActiveInput(name) is not None]
        if not declared:
            explained = True
            yield _unknown_input(given, node, fitting)
        elif given.getType() not in {d.getType() for d in declared}:
            explained = True
            types = " or ".join(sorted({d.getType() for d in declared}))
            message = f"input '{name}' has type {given.getType()}, expected {types}"
            yield finding("DOC_INPUT_TYPE", location(given), message)
    if not explained:
        message = f"no definition of '{category}' takes this combination of input types"
        yield finding("DOC_UNKNOWN_NODE", location(node), message)


def _unknown_input(given: Any, node: Any, definitions: list[Any]) -> Finding:
    name, category = given.getName(), node.getCategory()
    if name in (FLAG, *amounts_of(category)):
        message = f"'{category}' has no input '{name}'"
        return finding("RETRO_UNDEFINED", location(given), message)
    inputs = list(dict.fromkeys(i.getName() for d in definitions for i in d.getActiveInputs()))
    near = difflib.get_close_matches(name, inputs, 1)
    message = f"'{category}' has no input '{name}'" + (f"; did you mean '{near[0]}'?" if near else "")
    return finding("DOC_UNKNOWN_INPUT", location(given), message, f"Its inputs are {', '.join(inputs)}.")
