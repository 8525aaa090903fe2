"""Every rule, in one list: `mrm rules` prints it, docs/rules.md is made of it, tests go through it.

Another package adds a rule by an entry point of the group `mrm_mtlx.rules` whose value is a `Rule` with a `check`:

    [project.entry-points."mrm_mtlx.rules"]
    square = "my_package.square:SQUARE"
"""

from __future__ import annotations

import copyreg
import re
from functools import cache
from typing import TYPE_CHECKING

from mrm_mtlx.findings import rules
from mrm_mtlx.findings.finding import Rule
from mrm_mtlx.system.plugins import PluginError, registered

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from mrm_mtlx.findings.finding import Finding

GROUP = "mrm_mtlx.rules"
CODE = re.compile(r"[A-Z][A-Z0-9]*(_[A-Z0-9]+)+")

# Those of this package, in the order of the list.
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
        rules.INTERCHANGE_APPROXIMATED,
        rules.INTERCHANGE_PREVIEW,
        rules.USD_VALIDATOR,
        rules.USD_MISSING,
        rules.USD_VALIDATOR_WARNING,
        rules.RETRO_UNDEFINED,
        rules.RETRO_VERSION,
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


@cache
def all_rules() -> Mapping[str, Rule]:
    """The rules of this package, and after them those that other packages register, by code.

    Raises
    ------
    PluginError
        If one of these does not load, is no rule, or has no code of its own.
    """
    found = dict(RULES)
    for rule in registered(GROUP, Rule):
        if not CODE.fullmatch(rule.code):
            msg = f"'{rule.code}' in {GROUP} is no code of a rule, expected capitals such as SIGN_TOO_DARK"
            raise PluginError(msg)
        if rule.code in found:
            msg = f"two rules are called {rule.code}; remove one of the packages that register in {GROUP}"
            raise PluginError(msg)
        found[rule.code] = rule
    return found


def rules_from(beginning: str) -> list[Rule]:
    """The rules whose code starts so.

    Raises
    ------
    PluginError
        As `all_rules`.
    """
    return [rule for code, rule in all_rules().items() if code.startswith(beginning)]


def brought_findings(document: Any) -> list[Finding]:
    """Cases of the rules that other packages register, in a document, in the order of `all_rules`.

    Raises
    ------
    PluginError
        As `all_rules`, or if the check of one fails.
    """
    found: list[Finding] = []
    for rule in all_rules().values():
        try:
            found += rule.check(document) if rule.check is not None else ()
        except MemoryError:
            raise
        except Exception as error:  # whatever the modules of other packages raise
            reason = f"{type(error).__name__}: {error}"
            msg = f"the check of {rule.code}, which another package registers, failed ({reason}); upgrade or remove it"
            raise PluginError(msg) from error
    return found


def rule_of(code: str) -> Rule:
    """The rule of a code.

    Raises
    ------
    KeyError
        If there is none.
    """
    return RULES.get(code) or all_rules()[code]


# A rule is one object in each process: what crosses processes is its code.
copyreg.pickle(Rule, lambda rule: (rule_of, (rule.code,)))
