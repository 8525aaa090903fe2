"""The rules: each finding's meaning, and the remedy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.shown import Shown, html_table

if TYPE_CHECKING:
    from mrm_mtlx.findings.finding import Rule


@dataclass(frozen=True, repr=False)
class RuleTable(Shown):
    """Rules; `explained` is whether they are shown with their meaning and remedy, or a line each."""

    rules: tuple[Rule, ...]
    explained: bool

    def report(self) -> str:
        """The rules as text."""
        from mrm_mtlx.findings import pages

        return "\n\n".join(map(pages.page, self.rules)) if self.explained else pages.table(self.rules)

    def _repr_html_(self) -> str:
        header = ["rule", "severity", "title"] + (["meaning", "what to do"] if self.explained else [])
        rows = [
            [rule.code, rule.severity.value, rule.title, *([rule.meaning, rule.remedy] if self.explained else [])]
            for rule in self.rules
        ]
        return html_table(header, rows)


def rules(code: str | None = None) -> RuleTable:
    """All rules, those of other packages included, or those whose code starts with `code`, explained.

    Raises
    ------
    ArgumentError
        If there is none.
    """
    from mrm_mtlx.findings.catalogue import all_rules, rules_from

    if code is None:
        return RuleTable(tuple(all_rules().values()), explained=False)
    found = tuple(rules_from(code.upper()))
    if not found:
        msg = f"no rule starts with '{code}'; `mrm rules` lists them"
        raise ArgumentError(msg, "code")
    return RuleTable(found, explained=True)


def rules_page() -> str:
    """The page docs/rules.md: the rules of this package."""
    from mrm_mtlx.findings import pages
    from mrm_mtlx.findings.catalogue import RULES

    return pages.markdown_page(RULES.values())
