"""Findings: what is wrong in the user's data, where, and what to do; and the rules that they are cases of."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from mrm_mtlx.findings.source_location import SourceLocation

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

# Findings of one rule that are told of one document, one by one: nobody reads more, and a report has to be opened.
MAXIMUM_OF_A_RULE = 100
# Characters of a finding's place and message: names and values in a document can have millions.
LONGEST_TEXT = 4000


class Severity(StrEnum):
    """Severity of a rule: an error fails the run, a warning fails it under --strict."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, eq=False)
class Rule:
    """The source of `mrm rules`, of docs/rules.md and of every finding.

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
    beside_materials
        Whether it is about what lies around the materials, as the rest of a stage does: nothing keeps the document
        from being used then.
    of_host
        Whether it is another program's opinion of the whole file, which `mrm validate` alone reports.
    check
        Function from a document of MaterialX to the rule's cases in it, of a rule that another package brings; it is
        called where the document's connections have no circle. The checks of this package (`validation.checks`) find
        cases of several rules on one way through a document.
    """

    code: str
    severity: Severity
    title: str = field(repr=False)
    meaning: str = field(repr=False)
    remedy: str = field(repr=False)
    beside_materials: bool = False
    of_host: bool = False
    check: Callable[[Any], Iterable[Finding]] | None = field(default=None, repr=False)

    def is_among(self, beginnings: tuple[str, ...]) -> bool:
        """True if the code starts with one of these, as users name rules and groups of them."""
        return self.code.startswith(beginnings)

    def at(self, location: str, message: str, hint: str = "") -> Finding:
        """A case of this rule; its remedy is the hint if none is given."""
        return Finding(self, shortened(location), shortened(message), shortened(hint or self.remedy))


@dataclass(frozen=True)
class Finding:
    """A case of a rule, made by `Rule.at`.

    Attributes
    ----------
    rule
        What it is a case of.
    location
        Path of the element in the document, "/material/node/input", or "line N" before there are elements, or "".
    message
        What was found and what was expected, on one line but for quoted source.
    hint
        What to do.
    source
        Where in which file that is; None where it was not asked for, as for `location` alone.
    """

    rule: Rule
    location: str
    message: str
    hint: str
    source: SourceLocation | None = None

    @property
    def code(self) -> str:
        """The code of the rule."""
        return self.rule.code

    @property
    def severity(self) -> Severity:
        """The severity of the rule."""
        return self.rule.severity

    @property
    def blocks(self) -> bool:
        """True if nothing can be made of the document: an error, but not of what is around it."""
        return self.severity is Severity.ERROR and not self.rule.beside_materials

    def in_file(self, file: str) -> Finding:
        """The same with a file as its source, if that is not known better."""
        return self if self.source else replace(self, source=SourceLocation(file))

    def __str__(self) -> str:
        """On one line, as compilers write it: "file:line:column: severity CODE location: message"."""
        place = f" {self.location}" if self.location else ""
        is_known = self.source and (self.source.line or self.source.layer)
        where = f"{self.source}: " if is_known else ""
        return f"{where}{self.severity} {self.code}{place}: {self.message}"

    def to_json(self) -> dict[str, str | int | None]:
        """The finding as reports have it (docs/report.schema.json), if its source is known."""
        where = {"location": self.location, **(self.source.to_json() if self.source else {})}
        what = {"message": self.message, "hint": self.hint}
        return {"code": self.code, "severity": self.severity.value, **where, **what}


def shortened(text: str) -> str:
    """A text of at most `LONGEST_TEXT` characters; of a longer one, the middle is left out."""
    half = LONGEST_TEXT // 2
    return text if len(text) <= LONGEST_TEXT else f"{text[:half]} [...] {text[-half:]}"


def capped(findings: Iterable[Finding]) -> list[Finding]:
    """The first `MAXIMUM_OF_A_RULE` findings of each rule, and at the end how many more there are."""
    kept: list[Finding] = []
    number: Counter[Rule] = Counter()
    for found in findings:
        number[found.rule] += 1
        if number[found.rule] <= MAXIMUM_OF_A_RULE:
            kept.append(found)
    for rule, count in number.items():
        if count > MAXIMUM_OF_A_RULE:
            more = f"{count - MAXIMUM_OF_A_RULE} more findings of {rule.code}; the first {MAXIMUM_OF_A_RULE} are listed"
            kept.append(rule.at("", more))
    return kept
