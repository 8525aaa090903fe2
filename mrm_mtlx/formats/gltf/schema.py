"""Checks objects of glTF against the JSON schemas that lie beside this module, written from the public descriptions."""

from __future__ import annotations

import json
from difflib import get_close_matches
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from mrm_mtlx.findings import rules
from mrm_mtlx.formats import json_text
from mrm_mtlx.formats.json_text import kind
from mrm_mtlx.system.text import printable, shown

if TYPE_CHECKING:
    from collections.abc import Iterable

    from mrm_mtlx.findings.finding import Finding

RETROREFLECTION = "KHR_materials_retroreflection"
_FILES = ("gltf.schema.json", f"{RETROREFLECTION}.schema.json")
# Problems of one object that are reported.
_MOST = 20


def problems(definition: str, element: Any, place: str) -> list[Finding]:
    """Findings about what of an object breaks the schema, and what of it the schema does not know, with JSON pointers.

    Parameters
    ----------
    definition
        Of gltf.schema.json, such as "material".
    element
        What is checked.
    place
        Pointer to it.
    """
    found = []
    for error in _validator(definition).iter_errors(element):
        found += list(_remarks(error, place))
        if len(found) >= _MOST:
            break
    return sorted(found, key=lambda found: (found.location, found.message))


def known_extensions() -> list[str]:
    """Names of the material extensions that the schema describes."""
    return sorted(_schemas()[_FILES[0]]["definitions"]["material"]["properties"]["extensions"]["properties"])


@cache
def _schemas() -> dict[str, Any]:
    folder = resources.files(__package__)
    return {name: json.loads(folder.joinpath(name).read_text(encoding="utf-8")) for name in _FILES}


@cache
def _validator(definition: str) -> Any:
    from jsonschema import Draft4Validator
    from jsonschema.validators import extend
    from referencing import Registry
    from referencing.jsonschema import DRAFT4

    def is_integer(_checker: Any, value: Any) -> bool:
        # glTF lets a whole number be written with a fraction of zero.
        return not isinstance(value, bool) and (isinstance(value, int) or (isinstance(value, float) and value % 1 == 0))

    checker = Draft4Validator.TYPE_CHECKER.redefine("integer", is_integer)
    resources_ = [(name, DRAFT4.create_resource(schema)) for name, schema in _schemas().items()]
    # Made with the schema's own address, so that references within it are found too.
    reference = {"$ref": f"{_FILES[0]}#/definitions/{definition}"}
    made = extend(Draft4Validator, type_checker=checker)
    return made(reference, registry=Registry().with_resources(resources_))


def _remarks(error: Any, place: str) -> Iterable[Finding]:
    where = place + json_text.pointer(*error.absolute_path)
    if error.validator == "additionalProperties" and error.validator_value is False:
        known = sorted(error.schema["properties"])
        for name in sorted(set(error.instance) - set(known)):
            near = get_close_matches(name, known, 1)
            meant = f"; {near[0]} is probably meant" if near else ""
            message = f"the property {shown(name)} is not known and not read{meant}"
            hint = "Correct the name; what is no property of glTF belongs into extras."
            yield rules.INTERCHANGE_LOST.at(where, printable(message), hint)
        return
    yield rules.INTERCHANGE_INVALID.at(where, printable(_described(error)))


def _described(error: Any) -> str:
    rule, found = error.validator_value, error.instance
    value = shown(str(found)) if isinstance(found, str) else shown(str(found), "")
    match error.validator:
        case "type":
            article = "an" if rule[0] in "aio" else "a"
            return f"expected {article} {rule}, got {kind(found)}"
        case "minimum":
            least = "more than" if error.schema.get("exclusiveMinimum") else "at least"
            return f"expected {least} {rule:g}, got {value}"
        case "maximum":
            return f"expected at most {rule:g}, got {value}"
        case "enum":
            return f"expected one of {', '.join(map(str, rule))}, got {value}"
        case "required":
            missing = [name for name in rule if name not in found]
            return f"{', '.join(missing)} is missing"
        case "minItems" | "maxItems":
            return f"expected {rule} numbers, got {len(found)}"
        case "oneOf":  # of an image
            return "expected either uri, or bufferView with mimeType"
        case "anyOf":  # of an index of refraction
            return f"expected 0, or at least 1, got {value}"
    return f"it breaks the rule {error.validator}"
