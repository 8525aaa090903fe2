"""Nodes and their inputs, against the node definitions."""

from __future__ import annotations

import difflib
from functools import cached_property
from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.elements import is_connected, location
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.finding import MAXIMUM_OF_A_RULE, Finding
from mrm_mtlx.library.load import definitions_for
from mrm_mtlx.library.surface_models import FLAG, amounts_of
from mrm_mtlx.validation.checks.connections import check_uniform
from mrm_mtlx.validation.checks.values import check_value

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence


class Spelling:
    """Names that a wrong one in a document may have meant, for as many as are told of it.

    To look for one takes a thousandth of a second; documents can have a hundred thousand.
    """

    def __init__(self, document: Any) -> None:
        self._document = document
        self._asked = 0

    def of_node(self, category: str) -> str:
        """As `of` for the category of a node, or the name of a definition, as USD's shaders have."""
        return self.of(category, self._definitions if category.startswith("ND_") else self._nodes)

    def of(self, name: str, known: Sequence[str]) -> str:
        """Words after a wrong name: "; did you mean 'x'?", or "" if none is near, or enough was said."""
        self._asked += 1
        near = difflib.get_close_matches(name[:_LONGEST], known, 1) if self._asked <= MAXIMUM_OF_A_RULE else []
        return f"; did you mean '{near[0]}'?" if near else ""

    @cached_property
    def _nodes(self) -> list[str]:
        documents = (self._document, definitions_for(self._document))
        return sorted({d.getNodeString() for document in documents for d in document.getNodeDefs()})

    @cached_property
    def _definitions(self) -> list[str]:
        return sorted(d.getName() for d in definitions_for(self._document).getNodeDefs())


# Nodes that read a geometric property, and the input that names it.
_PROPERTIES = {"geompropvalue": "geomprop", "geompropvalueuniform": "geomprop", "UsdPrimvarReader": "varname"}

# Longer than any name that is near to one of MaterialX's.
_LONGEST = 64


def check_node(node: Any, spelling: Spelling) -> Iterator[Finding]:
    """Findings on a node that is not defined, and on inputs that its definition lacks or refuses."""
    definition = node.getNodeDef()
    if definition is None:
        yield from _undefined(node, spelling)
        return
    for given in node.getInputs():
        declared = definition.getActiveInput(given.getName())
        if declared is None:  # of the definition that the node names
            yield _unknown_input(given, node, [definition], spelling)
        else:
            yield from check_value(given, declared)
            yield from check_uniform(given, declared)


def check_property_name(node: Any) -> Iterator[Finding]:
    """A node that reads a geometric property and does not say which: generators refuse it."""
    name = _PROPERTIES.get(node.getCategory(), "")
    # MaterialX upgrades a geomattrvalue of version 1.36 to a node with an attribute in the place of the input.
    if not name or node.getNodeDef() is None or node.hasAttribute(name):
        return
    given = node.getInput(name)
    holder = given.getInterfaceInput() or given if given is not None else None
    if holder is None or not (holder.getValueString() or holder.getInterfaceName() or is_connected(holder)):
        message = f"'{node.getCategory()}' reads a geometric property, and does not say which"
        yield rules.DOC_INPUT_VALUE.at(location(node), message, f"Give the input '{name}' the name of the property.")


def _undefined(node: Any, spelling: Spelling) -> Iterator[Finding]:
    """Findings that say why a node has no definition: no such category, an unknown input, a wrong type."""
    category = node.getCategory()
    definitions = node.getDocument().getMatchingNodeDefs(category)
    if not definitions:
        message = f"there is no node '{category}'{spelling.of_node(category)}"
        yield rules.DOC_UNKNOWN_NODE.at(location(node), message)
        return
    fitting = [d for d in definitions if d.getType() == node.getType()]
    if not fitting and not any(d.getActiveOutputs() for d in definitions):
        names = ", ".join(d.getName() for d in definitions)
        yield rules.DOC_UNKNOWN_NODE.at(location(node), f"'{category}' has no output in its definition {names}")
        return
    if not fitting:
        types = ", ".join(sorted({d.getType() for d in definitions}))
        message = f"'{category}' of type {node.getType()} is not defined; it exists for {types}"
        yield rules.DOC_UNKNOWN_NODE.at(location(node), message)
        return
    version = node.getVersionString()
    if version and not any(d.isVersionCompatible(version) for d in fitting):
        versions = ", ".join(dict.fromkeys(d.getVersionString() or "none" for d in fitting))
        message = f"version {version} of '{category}' is not defined; it exists in {versions}"
        hint = "Remove the node's version, or name one that exists."
        yield rules.DOC_UNKNOWN_NODE.at(location(node), message, hint)
        return
    explained = False
    for given in node.getInputs():
        name = given.getName()
        declared = [d.getActiveInput(name) for d in fitting if d.getActiveInput(name) is not None]
        if not declared:
            explained = True
            yield _unknown_input(given, node, fitting, spelling)
        elif given.getType() not in {d.getType() for d in declared}:
            explained = True
            types = " or ".join(sorted({d.getType() for d in declared}))
            message = f"input '{name}' has type {given.getType()}, expected {types}"
            yield rules.DOC_INPUT_TYPE.at(location(given), message)
    if not explained:
        message = f"no definition of '{category}' takes this combination of input types"
        yield rules.DOC_UNKNOWN_NODE.at(location(node), message)


def _unknown_input(given: Any, node: Any, definitions: list[Any], spelling: Spelling) -> Finding:
    name, category = given.getName(), node.getCategory()
    if name in (FLAG, *amounts_of(category)):
        message = f"'{category}' has no input '{name}'"
        return rules.RETRO_UNDEFINED.at(location(given), message)
    inputs = list(dict.fromkeys(i.getName() for d in definitions for i in d.getActiveInputs()))
    message = f"'{category}' has no input '{name}'{spelling.of(name, inputs)}"
    return rules.DOC_UNKNOWN_INPUT.at(location(given), message, f"Its inputs are {', '.join(inputs)}.")
