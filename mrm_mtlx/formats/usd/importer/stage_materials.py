"""The materials of a stage as one document: those of the selected variants, and those that other variants make."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import MaterialX as mx
from pxr import Sdf, Tf, Usd, UsdShade

from mrm_mtlx.documents.document import Document, ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.importer.assets import Assets
from mrm_mtlx.formats.usd.importer.locations import StageLocations
from mrm_mtlx.formats.usd.importer.network import translate
from mrm_mtlx.formats.usd.importer.translation import Translation
from mrm_mtlx.formats.usd.importer.validators import validator_findings
from mrm_mtlx.formats.usd.messages import said
from mrm_mtlx.formats.usd.opening.stage import open_stage
from mrm_mtlx.formats.usd.prims import terminals
from mrm_mtlx.shadergen.usd.values import color_space
from mrm_mtlx.system.console import silenced

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.usd.opening.stage import Stage
    from mrm_mtlx.library import DataLibrary

# What USD says of a value that only its own files have within.
_NO_VALUE = "No to_python"
# Variants that are selected one after the other to see what they change.
MAXIMUM_VARIANTS = 64


def read(path: Path, reach: Reach, library: DataLibrary, scratch: Path) -> Document:
    """Read the materials of a stage that have a MaterialX network; see `formats.format`."""
    try:
        return _read(path, reach, library, scratch)
    except UnicodeDecodeError as error:
        message = f"a text in {path.name} is not UTF-8: byte 0x{error.object[error.start]:02x}"
        raise ReadError(rules.READ_ENCODING.at("", message)) from error
    except Tf.ErrorException as error:
        raise ReadError(rules.READ_FORMAT.at("", f"{path.name}: {said(error)}")) from error
    except TypeError as error:
        if _NO_VALUE not in str(error):
            raise
        message = f"{path.name} is damaged: it has a value of a type that none can have"
        raise ReadError(rules.READ_FORMAT.at("", message)) from error


def _read(path: Path, reach: Reach, library: DataLibrary, scratch: Path) -> Document:
    opened = open_stage(path, reach, scratch, library)
    stage, findings = opened.stage, opened.findings
    assets = Assets(opened)
    translation = Translation(_document(stage, library), library, assets.name, source_of=opened.source)
    known = _translate_all(opened, translation)
    findings += _circles(stage)
    with silenced():  # USD prints what it cannot compose, which is said here
        _translate_variants(opened, translation, known)
    findings += translation.findings
    findings += validator_findings(opened, library, assets.seen)
    findings = [found if found.source else replace(found, source=opened.said_at(found.location)) for found in findings]
    return Document(
        materialx=translation.document,
        path=path,
        reach=assets.reach,
        packed=assets.packed,
        source_locations=translation.source_locations,
        locations=StageLocations(opened.shown, translation.sources),
        findings=list(dict.fromkeys(findings)),
    )


def _document(stage: Usd.Stage, library: DataLibrary) -> mx.Document:
    document = mx.createDocument()
    document.setDataLibrary(library.document)
    space = stage.GetRootLayer().customLayerData.get("colorSpace")  # as UsdMtlx writes it
    if isinstance(space, str) and space:
        document.setColorSpace(color_space(space))
    return document


def _materials(stage: Usd.Stage, below: Usd.Prim | None = None) -> Iterator[UsdShade.Material]:
    """Materials with a MaterialX network; what instances share comes once, where the first instance has it."""
    prototypes = set()
    prims = iter(Usd.PrimRange(below or stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))
    for prim in prims:
        if prim.IsInstance():
            if prim.GetPrototype().GetPath() in prototypes:
                prims.PruneChildren()
            prototypes.add(prim.GetPrototype().GetPath())
        if prim.IsA(UsdShade.Material):
            prims.PruneChildren()
            material = UsdShade.Material(prim)
            if terminals(material):
                yield material


def _translate_all(opened: Stage, translation: Translation) -> dict[Sdf.Path, str]:
    """Translate the materials as they are; return what each is made of, by path, where a variant may change it."""
    changing = _prims_with_variants(opened.stage)
    known = {}
    for material in _materials(opened.stage):
        path = material.GetPath()
        if not _lacks(opened, material, translation, str(path)):
            translate(translation, material)
        if any(path.HasPrefix(prim) for prim in changing):
            known[path] = _made_of(material, translation)
    return known


def _lacks(opened: Stage, material: UsdShade.Material, translation: Translation, place: str) -> bool:
    """True if a material depends on a layer that is missing; it is said, and what is there of it is not checked."""
    name = opened.lacking(material.GetPrim())
    if name:
        message = f"the material depends on '{name}', which is not there or is wrong; it is not checked"
        translation.report(rules.USD_MISSING, material.GetPath(), place, message)
    return bool(name)


def _translate_variants(opened: Stage, translation: Translation, known: dict[Sdf.Path, str]) -> None:
    """Translate what each variant makes that is not there without it, one variant at a time."""
    stage = opened.stage
    stage.SetEditTarget(stage.GetSessionLayer())
    before = {str(error.rootSite.path) for error in stage.GetCompositionErrors()}
    for count, (path, variants, variant) in enumerate(_other_variants(stage)):
        if count == MAXIMUM_VARIANTS:
            message = f"of its variants, {MAXIMUM_VARIANTS} are looked at; the others are not checked"
            translation.report(rules.INTERCHANGE_LOST, path, str(path), message)
            return
        selection = f"{{{variants.GetName()}={variant}}}"
        variants.SetVariantSelection(variant)
        _translate_changed(opened, path, selection, translation, known)
        translation.findings += _only_there(stage, f"{path}{selection}", before)
        variants.ClearVariantSelection()


def _other_variants(stage: Usd.Stage) -> Iterator[tuple[Sdf.Path, Usd.VariantSet, str]]:
    """Prims, their sets, and the variants that are not selected; whoever selects one clears it before the next."""
    for path in _prims_with_variants(stage):
        sets = stage.GetPrimAtPath(path).GetVariantSets()
        for name in sorted(sets.GetNames()):
            variants = sets.GetVariantSet(name)
            selected = variants.GetVariantSelection()
            for variant in sorted(variants.GetVariantNames()):
                if variant != selected:
                    yield path, variants, variant


def _translate_changed(
    opened: Stage, path: Sdf.Path, selection: str, translation: Translation, known: dict[Sdf.Path, str]
) -> None:
    prefix = str(path)

    def place(of: Sdf.Path) -> str:
        text = str(of)
        return f"{prefix}{selection}{text[len(prefix) :].removeprefix('/')}" if of.HasPrefix(path) else text

    for material in _materials(opened.stage, opened.stage.GetPrimAtPath(path)):
        if _made_of(material, translation) == known.get(material.GetPath()):
            continue
        if not _lacks(opened, material, translation, place(material.GetPath())):
            translate(translation, material, place)


def _prims_with_variants(stage: Usd.Stage) -> list[Sdf.Path]:
    """Prims that can be given another variant; of all that have their variants from the same place, the first.

    What is inside of an instance has no selection of its own.
    """
    found: dict[frozenset[tuple[str, Sdf.Path]], Sdf.Path] = {}
    for prim in stage.Traverse():
        if prim.HasVariantSets():
            specs = (spec for spec in prim.GetPrimStack() if spec.variantSets)
            found.setdefault(frozenset((spec.layer.identifier, spec.path) for spec in specs), prim.GetPath())
    return list(found.values())


def _made_of(material: UsdShade.Material, translation: Translation) -> str:
    """A material's network as text, to be compared."""
    document = mx.createDocument()
    document.setDataLibrary(translation.library.document)
    alone = Translation(document, translation.library, translation.file_name)
    translate(alone, material)
    return str(mx.writeToXmlString(document)) + repr(alone.findings)


def _only_there(stage: Usd.Stage, variant: str, before: set[str]) -> list[Finding]:
    """Findings about what USD cannot compose of a selected variant; `before` are prims of which that is so without it.

    Its validators, which say the like of the stage as it is, do not see other variants.
    """
    errors: list[Any] = [error for error in stage.GetCompositionErrors() if str(error.rootSite.path) not in before]
    of = [rules.READ_INCLUDE if _is_circle(error) else rules.USD_VALIDATOR for error in errors]
    found = zip(of, errors, strict=True)
    return [rule.at(variant, f"{error.rootSite.path}: {said(error)}") for rule, error in found]


def _circles(stage: Usd.Stage) -> list[Finding]:
    """Prims that refer to themselves, which USD leaves out."""
    errors: list[Any] = [error for error in stage.GetCompositionErrors() if _is_circle(error)]
    return [rules.READ_INCLUDE.at(str(error.rootSite.path), said(error)) for error in errors]


def _is_circle(error: object) -> bool:
    return type(error).__name__ == "ErrorArcCycle"
