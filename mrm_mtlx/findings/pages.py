"""Rules as text: for the terminal, and as docs/rules.md."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from mrm_mtlx.findings.finding import Rule


def table(catalogue: Iterable[Rule]) -> str:
    """A line per rule: code, severity and title."""
    listed = list(catalogue)
    width = max(len(rule.code) for rule in listed)
    return "\n".join(f"{rule.code.ljust(width)}  {rule.severity.value.ljust(7)}  {rule.title}" for rule in listed)


def page(rule: Rule) -> str:
    """One rule for the terminal."""
    body = [
        textwrap.fill(text, 96, initial_indent="  ", subsequent_indent="  ") for text in (rule.meaning, rule.remedy)
    ]
    return "\n\n".join([f"{rule.code} ({rule.severity}): {rule.title}", *body])


def markdown_page(catalogue: Iterable[Rule]) -> str:
    """All rules as docs/rules.md."""
    parts = ["<!-- Made by `mrm rules --markdown`; do not edit. -->", "# Rules", ""]
    parts.append(
        "Every finding of `mrm validate` has one of these codes. Errors fail a run; warnings do with `--strict`."
    )
    for rule in catalogue:
        parts += ["", f"## {rule.code}", "", f"*{rule.severity.value}*: {rule.title}", ""]
        parts += [textwrap.fill(rule.meaning, 110), "", f"**What to do.** {textwrap.fill(rule.remedy, 110)}"]
    return "\n".join(parts)
