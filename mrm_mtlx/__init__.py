"""Retroreflective materials in MaterialX: node library, reference evaluator and validator.

    import mrm_mtlx as mrm

What every command does is a function here, with the options of the command as keywords; `docs/api.md` shows each.
Nothing heavy is imported before it is used. `mrm.bsdf` is the optics in plain NumPy, the place to start reading.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mrm_mtlx import bsdf
    from mrm_mtlx.api.conformance import conformance as conformance
    from mrm_mtlx.api.convert import Converted as Converted
    from mrm_mtlx.api.convert import compare as compare
    from mrm_mtlx.api.convert import convert as convert
    from mrm_mtlx.api.doctor import CoverageReport as CoverageReport
    from mrm_mtlx.api.doctor import DoctorReport as DoctorReport
    from mrm_mtlx.api.doctor import HostReport as HostReport
    from mrm_mtlx.api.doctor import check_host as check_host
    from mrm_mtlx.api.doctor import coverage as coverage
    from mrm_mtlx.api.doctor import doctor as doctor
    from mrm_mtlx.api.errors import DataError as DataError
    from mrm_mtlx.api.errors import DocumentError as DocumentError
    from mrm_mtlx.api.errors import MrmError as MrmError
    from mrm_mtlx.api.errors import NoReferenceError as NoReferenceError
    from mrm_mtlx.api.errors import NothingToConvertError as NothingToConvertError
    from mrm_mtlx.api.errors import NothingToRenderError as NothingToRenderError
    from mrm_mtlx.api.errors import NoValueError as NoValueError
    from mrm_mtlx.api.errors import ShaderError as ShaderError
    from mrm_mtlx.api.errors import UnavailableError as UnavailableError
    from mrm_mtlx.api.fit import FittedMaterial as FittedMaterial
    from mrm_mtlx.api.fit import fit as fit
    from mrm_mtlx.api.fit import fit_class as fit_class
    from mrm_mtlx.api.fit import fit_classes as fit_classes
    from mrm_mtlx.api.generate import GeneratedSource as GeneratedSource
    from mrm_mtlx.api.generate import generate as generate
    from mrm_mtlx.api.library import InstalledLibrary as InstalledLibrary
    from mrm_mtlx.api.library import install_library as install_library
    from mrm_mtlx.api.listener import Listener as Listener
    from mrm_mtlx.api.opening import OpenDocument as OpenDocument
    from mrm_mtlx.api.opening import open_document as open_document
    from mrm_mtlx.api.photometry import list_standards as list_standards
    from mrm_mtlx.api.photometry import photometry as photometry
    from mrm_mtlx.api.plot import Plot as Plot
    from mrm_mtlx.api.plot import plot as plot
    from mrm_mtlx.api.plot import plot_figures as plot_figures
    from mrm_mtlx.api.render import Picture as Picture
    from mrm_mtlx.api.render import render as render
    from mrm_mtlx.api.rules import RuleTable as RuleTable
    from mrm_mtlx.api.rules import rules as rules
    from mrm_mtlx.api.rules import rules_page as rules_page
    from mrm_mtlx.api.validate import check as check
    from mrm_mtlx.api.validate import validate as validate
    from mrm_mtlx.api.vectors import TestVectors as TestVectors
    from mrm_mtlx.api.vectors import vectors as vectors
    from mrm_mtlx.conformance.report import ConformanceReport as ConformanceReport
    from mrm_mtlx.findings.finding import Finding as Finding
    from mrm_mtlx.findings.finding import Rule as Rule
    from mrm_mtlx.fitting.class_report import ClassFit as ClassFit
    from mrm_mtlx.formats.format import Comparison as Comparison
    from mrm_mtlx.library.paths import class_materials_folder as class_materials_folder
    from mrm_mtlx.library.paths import materials_folder as materials_folder
    from mrm_mtlx.library.paths import node_library_folder as node_library_folder
    from mrm_mtlx.photometry.result import PhotometryReport as PhotometryReport
    from mrm_mtlx.photometry.result import StandardsReport as StandardsReport
    from mrm_mtlx.reference import ShadingPoints as ShadingPoints
    from mrm_mtlx.reference import Surface as Surface
    from mrm_mtlx.system.arguments import ArgumentError as ArgumentError
    from mrm_mtlx.system.versions import __version__ as __version__
    from mrm_mtlx.validation.screen import CheckReport as CheckReport
    from mrm_mtlx.validation.screen import ValidationReport as ValidationReport

# The public names, by the module that has them.
_MODULES = {
    "mrm_mtlx.api.conformance": ("conformance",),
    "mrm_mtlx.api.convert": ("Converted", "compare", "convert"),
    "mrm_mtlx.api.doctor": ("CoverageReport", "DoctorReport", "HostReport", "check_host", "coverage", "doctor"),
    "mrm_mtlx.api.errors": (
        "DataError", "DocumentError", "MrmError", "NoReferenceError", "NoValueError", "NothingToConvertError",
        "NothingToRenderError", "ShaderError", "UnavailableError",
    ),
    "mrm_mtlx.api.fit": ("FittedMaterial", "fit", "fit_class", "fit_classes"),
    "mrm_mtlx.api.generate": ("GeneratedSource", "generate"),
    "mrm_mtlx.api.library": ("InstalledLibrary", "install_library"),
    "mrm_mtlx.api.listener": ("Listener",),
    "mrm_mtlx.api.opening": ("OpenDocument", "open_document"),
    "mrm_mtlx.api.photometry": ("list_standards", "photometry"),
    "mrm_mtlx.api.plot": ("Plot", "plot", "plot_figures"),
    "mrm_mtlx.api.render": ("Picture", "render"),
    "mrm_mtlx.api.rules": ("RuleTable", "rules", "rules_page"),
    "mrm_mtlx.api.validate": ("check", "validate"),
    "mrm_mtlx.api.vectors": ("TestVectors", "vectors"),
    "mrm_mtlx.conformance.report": ("ConformanceReport",),
    "mrm_mtlx.findings.finding": ("Finding", "Rule"),
    "mrm_mtlx.fitting.class_report": ("ClassFit",),
    "mrm_mtlx.formats.format": ("Comparison",),
    "mrm_mtlx.library.paths": ("class_materials_folder", "materials_folder", "node_library_folder"),
    "mrm_mtlx.photometry.result": ("PhotometryReport", "StandardsReport"),
    "mrm_mtlx.reference": ("ShadingPoints", "Surface"),
    "mrm_mtlx.system.arguments": ("ArgumentError",),
    "mrm_mtlx.system.versions": ("__version__",),
    "mrm_mtlx.validation.screen": ("CheckReport", "ValidationReport"),
}  # fmt: skip
_HOMES = {name: module for module, names in _MODULES.items() for name in names}

__all__ = ["bsdf", *sorted(_HOMES)]


def __getattr__(name: str) -> Any:
    if name == "bsdf":
        return import_module("mrm_mtlx.bsdf")
    if name not in _HOMES:
        msg = f"module 'mrm_mtlx' has no attribute '{name}'"
        raise AttributeError(msg)
    value = globals()[name] = getattr(import_module(_HOMES[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _Face(ModuleType):
    """The package as a module in which functions stay what they are.

    Some rooms are called like a public function (photometry, render, conformance), and the import of a room sets it as
    an attribute of its package. The function keeps its place, as in any package that imports a function of the name of
    its module.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Face
