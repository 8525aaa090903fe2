"""The node library itself against the oracle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeAlias

from mrm_mtlx.api.errors import UnavailableError
from mrm_mtlx.api.generate import check_targets
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.api.validate import FEWEST_SAMPLES, MOST_SAMPLES
from mrm_mtlx.system.arguments import ArgumentError, check_choice, check_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.api.opening import LibraryName
    from mrm_mtlx.conformance.report import ConformanceReport

# The names of conformance.Form.
FormName: TypeAlias = Literal["library", "portable"]


def conformance(
    *,
    target: str | Sequence[str] = (),
    samples: int = 1 << 18,
    seed: int = 0,
    library: LibraryName = "mrm",
    form: FormName = "library",
    listener: Listener = SILENT,
) -> ConformanceReport:
    """Compare every node, flag and shape of lobe with the oracle, over random parameters.

    Parameters
    ----------
    target
        glsl and essl in the OpenGL driver, osl in Cycles, storm in OpenUSD's. Default: all but storm.
    samples
        Per comparison.
    seed
        Of all random numbers.
    library
        Whose implementation of the flag: this project's or MaterialX's ("upstream").
    form
        Of the node library: its sources ("library"), or nodes of MaterialX's standard library alone, as `convert` and
        `library install` write them ("portable", on glsl and essl).
    listener
        Told of progress.

    Raises
    ------
    ArgumentError
        If the call is wrong.
    UnavailableError
        If an engine dies, or refuses a shader.
    """
    from mrm_mtlx.conformance import Form, all_targets, run, run_portable, targets
    from mrm_mtlx.conformance.report import ConformanceReport
    from mrm_mtlx.engines.base import CompileError, EngineFailure
    from mrm_mtlx.library import Origin
    from mrm_mtlx.library.dialects import versions
    from mrm_mtlx.validation.runner import engines

    check_whole("samples", samples, FEWEST_SAMPLES, MOST_SAMPLES)
    check_whole("seed", seed, 0)
    check_choice("library", library, tuple(Origin))
    check_choice("form", form, tuple(Form))
    is_portable = Form(form) is Form.PORTABLE
    if is_portable and Origin(library) is not Origin.MRM:
        msg = "MaterialX's own library has no portable form"
        raise ArgumentError(msg, "form")
    chosen = check_targets(target, library, all_targets(Form(form)), targets(Form(form)))
    try:
        if is_portable:
            results = tuple(run_portable(chosen, samples, seed, listener.progress))
        else:
            results = tuple(run(chosen, samples, seed, Origin(library), listener.progress))
    except (CompileError, EngineFailure) as error:
        raise UnavailableError(str(error)) from error
    return ConformanceReport(versions(), engines(chosen), str(library), results)
