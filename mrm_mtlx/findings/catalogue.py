"""Every rule, in one list: `mrm rules` prints it, docs/rules.md is made of it, tests go through it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.findings import rules

if TYPE_CHECKING:
    from mrm_mtlx.findings.finding import Rule

RULES: dict[str, Rule] = {
    rule.code: rule
    for rule in (
        rules.READ_MISSING,
        rules.READ_FAILED,
        rules.READ_TOO_LARGE,
        rules.READ_ENCODING,
        rules.READ_XML,
        rules.READ_XML_LENIENT,
        rules.READ_FORMAT,
        rules.READ_TOO_DEEP,
        rules.READ_INCLUDE,
        rules.READ_OUTSIDE,
        rules.DOC_INVALID,
        rules.DOC_VERSION,
        rules.DOC_DUPLICATE_NAME,
        rules.DOC_UNKNOWN_NODE,
        rules.DOC_DEFINITION,
        rules.DOC_UNKNOWN_INPUT,
        rules.DOC_INPUT_TYPE,
        rules.DOC_INPUT_VALUE,
        rules.DOC_VALUE_FORM,
        rules.DOC_VALUE_RANGE,
        rules.DOC_CONNECTION,
        rules.DOC_OUTPUT_IGNORED,
        rules.DOC_UNIFORM_CONNECTED,
        rules.DOC_VALUE_IGNORED,
        rules.DOC_COLOR_SPACE,
        rules.DOC_CYCLE,
        rules.DOC_TOO_LARGE,
        rules.DOC_FILE,
        rules.DOC_NO_RENDERABLE,
        rules.DOC_NOT_COMPARED,
        rules.INTERCHANGE_LOST,
        rules.INTERCHANGE_INVALID,
        rules.INTERCHANGE_LEFT_OUT,
        rules.USD_VALIDATOR,
        rules.USD_MISSING,
        rules.USD_VALIDATOR_WARNING,
        rules.RETRO_UNDEFINED,
        rules.RETRO_TRANSMISSION,
        rules.RETRO_INVISIBLE,
        rules.ENERGY_GAIN,
        rules.ENERGY_ANISOTROPIC,
        rules.LOBE_TOO_NARROW,
        rules.SHADER_GENERATE,
        rules.SHADER_COMPILE,
        rules.SHADER_DIFFERS,
        rules.UPSTREAM_DEVIATION,
        rules.SHADER_NOT_FINITE,
        rules.SHADER_IGNORES_RETRO,
        rules.CHECK_CRASHED,
        rules.CHECK_TIMEOUT,
    )
}
