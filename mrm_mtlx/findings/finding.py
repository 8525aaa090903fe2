"""A finding: something in the user's data that is wrong, with a stable code, a place, and what to do."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

# Findings of one rule that are told of one document, one by one: nobody reads more, and a report has to be opened.
MAXIMUM_OF_A_RULE = 100
# Characters of a finding's place and message: names and values in a document can have millions.
LONGEST_TEXT = 4000


class Severity(StrEnum):
    """How bad: an error fails the run, a warning fails it under --strict."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True)
class Rule:
    """What a code means; the source of `mrm rules`, of docs/rules.md and of every finding's severity.

    Attributes
    ----------
    code
        Stable; the part before the first underscore is the group (READ, DOC, USD, INTERCHANGE,
        RETRO, ENERGY, LOBE, SHADER, CHECK).
    severity
        Error or warning.
    title
        One line.
    meaning
        Why it matters; with formula, tolerance and source where there are any.
    remedy
        What to do.
    """

    code: str
    severity: Severity
    title: str
    meaning: str
    remedy: str


@dataclass(frozen=True)
class Finding:
    """One case of a rule.

    Attributes
    ----------
    code, severity
        Of the rule.
    location
        Path of the element in the document, "/material/node/input", or "line N" before there are elements, or "".
    message
        What was found and what was expected, on one line but for quoted source.
    hint
        What to do.
    """

    code: str
    severity: Severity
    location: str
    message: str
    hint: str


def blocks(found: Finding) -> bool:
    """Whether a finding means that nothing can be made of the document: an error, but not of what is around it."""
    return found.severity is Severity.ERROR and not found.code.startswith("USD_")


def finding(code: str, location: str, message: str, hint: str = "") -> Finding:
    """A finding under a rule of the catalogue; its general remedy is the hint if none is given.

    Raises
    ------
    KeyError
        If there is no such rule.
    """
    from mrm_mtlx.findings.catalogue import RULES

    rule = RULES[code]
    return Finding(code, rule.severity, *(_shortened(text) for text in (location, message, hint or rule.remedy)))


def _shortened(text: str) -> str:
    """A text of at most `LONGEST_TEXT` characters; of a longer one, the middle is left out."""
    half = LONGEST_TEXT // 2
    return text if len(text) <= LONGEST_TEXT else f"{text[:half]} [...] {text[-half:]}"


def capped(findings: Iterable[Finding]) -> list[Finding]:
    """The first `MAXIMUM_OF_A_RULE` findings of each rule, and at the end how many more there are."""
    kept: list[Finding] = []
    number: Counter[str] = Counter()
    for found in findings:
        number[found.code] += 1
        if number[found.code] <= MAXIMUM_OF_A_RULE:
            kept.append(found)
    for code, count in number.items():
        if count > MAXIMUM_OF_A_RULE:
            more = f"{count - MAXIMUM_OF_A_RULE} more findings of {code}; the first {MAXIMUM_OF_A_RULE} are listed"
            kept.append(finding(code, "", more))
    return kept
