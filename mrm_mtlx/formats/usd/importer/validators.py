"""Findings of USD's own validators about a stage."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import repeat
from typing import TYPE_CHECKING, Any

from pxr import Sdf, Tf, UsdShade, UsdValidation

from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.importer.versions import earlier_definition
from mrm_mtlx.formats.usd.messages import said
from mrm_mtlx.system.console import silenced

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mrm_mtlx.findings.finding import Finding, Rule
    from mrm_mtlx.findings.source_location import SourceLocation
    from mrm_mtlx.formats.usd.opening.stage import Stage
    from mrm_mtlx.library import DataLibrary

# A USD without UsdMtlx has no registry of MaterialX's nodes, and says so of every shader; see docs/usd.md.
NOISE = "usdShadeValidators:ShaderSdrCompliance.MissingShaderIdInRegistry"
# Validators that gather all that a stage depends on, and open it.
_OPENING = "usdUtilsValidators:"
# Findings of one kind that are listed one by one; a stage of thousands of prims has thousands of the same.
MAXIMUM_OF_A_KIND = 10


def validator_findings(opened: Stage, library: DataLibrary, images: set[Path]) -> list[Finding]:
    """Errors and warnings of the validators, by kind and place.

    Left out are `NOISE` about ids that the library has a definition of (what is checked with it says more), and what
    is found elsewhere: circles of references, materials that are not there for want of a file, and missing `images`.
    """
    with silenced():
        try:
            errors = UsdValidation.ValidationContext(_validators()).Validate(opened.stage)
        except Tf.ErrorException as stopped:
            return [rules.USD_VALIDATOR.at("", f"USD's validators stopped: {said(stopped)}")]
    found: dict[tuple[Rule, str], dict[tuple[str, str], SourceLocation | None]] = {}
    for error in errors:
        rule = _RULES.get(error.GetType())
        if rule is not None and not _is_known(error, library, opened):
            message = _ABSOLUTE.sub(r"'\1'", said(error.GetMessage()))
            found.setdefault((rule, error.GetIdentifier()), {})[_place(error), message] = None
    for kind, source, text in opened.problems(images):
        found.setdefault((rules.USD_VALIDATOR, kind), {})[source.prim or "", text] = source
    kinds = sorted(found, key=lambda kind: (kind[0].code, kind[1]))
    return [each for kind in kinds for each in _listed(*kind, found[kind])]


_RULES = {
    UsdValidation.ValidationErrorType.Error: rules.USD_VALIDATOR,
    UsdValidation.ValidationErrorType.Warn: rules.USD_VALIDATOR_WARNING,
}
_ABSOLUTE = re.compile(r"'/[^']*/([^'/]*)'")


def _validators() -> list[Any]:
    """All validators but those that open the files of a stage anew; `opening` and `packages` say what they would."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [v for v in validators if not v.GetMetadata().name.startswith(_OPENING)]


def _is_known(error: Any, library: DataLibrary, opened: Stage) -> bool:
    if error.GetIdentifier() != NOISE:
        return error.GetMessage().startswith("Cycle detected") or any(map(_lacks, error.GetSites(), repeat(opened)))
    ids = [UsdShade.Shader(site.GetProperty().GetPrim()).GetIdAttr().Get() for site in error.GetSites()]
    return bool(ids) and all(_is_defined(identifier or "", library) for identifier in ids)


def _lacks(site: Any, opened: Stage) -> bool:
    """True if a site is a relationship, as to a material, with a target that is not there for want of a file."""
    relationship = site.IsProperty() and site.GetProperty().GetPrim().GetRelationship(site.GetProperty().GetName())
    return bool(relationship) and any(map(opened.lacking_at, relationship.GetTargets()))


def _is_defined(identifier: str, library: DataLibrary) -> bool:
    return library.document.getNodeDef(identifier) is not None or earlier_definition(identifier) is not None


def _place(error: Any) -> str:
    """Path of the first prim or property that an error is about; "" for the stage itself."""
    for site in error.GetSites():
        if site.IsPrim():
            path = site.GetPrim().GetPath()
            return "" if path == Sdf.Path.absoluteRootPath else str(path)
        if site.IsProperty():
            return str(site.GetProperty().GetPath())
    return ""


def _listed(rule: Rule, kind: str, found: dict[tuple[str, str], SourceLocation | None]) -> Iterator[Finding]:
    for place, message in sorted(found)[:MAXIMUM_OF_A_KIND]:
        yield replace(rule.at(place, f"{kind}: {message}"), source=found[place, message])
    if len(found) > MAXIMUM_OF_A_KIND:
        yield rule.at("", f"{kind}: {len(found) - MAXIMUM_OF_A_KIND} more of the same")
