"""The same document with nothing in it retroreflective, for comparisons."""

from __future__ import annotations

from typing import Any

import MaterialX as mx

from mrm_mtlx.library.surface_models import FLAG, amount_input


def ordinary_copy(document: Any) -> Any:
    """A copy of a document where every retroreflective input of a node is off, also a connected one.

    Raises
    ------
    ValueError
        If there is none that could be on.
    """
    copy = document.copy()
    switched = [_switch_off(node) for node in copy.traverseTree() if node.isA(mx.Node)]
    if not any(switched):
        msg = "nothing to compare: no lobe of the material is retroreflective"
        raise ValueError(msg)
    return copy


def _switch_off(node: Any) -> bool:
    """Switch a node's flag off; true if it has, or gets by default, a retroreflective input that was not off."""
    definition, amount = node.getNodeDef(), amount_input(node)
    name, off = (amount, "0") if amount else (FLAG, "false")
    declared = definition.getActiveInput(name) if definition is not None else None
    if declared is None:
        return False
    given = node.getInput(name)
    connected = given is not None and not given.hasValueString()
    value = (declared if given is None else given).getValue()
    if not connected and not value:
        return False
    node.removeInput(name)
    node.addInput(name, declared.getType()).setValueString(off)
    return True
