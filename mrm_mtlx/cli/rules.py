"""`mrm rules`: what each finding means."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from mrm_mtlx.findings.finding import Rule


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(rules)


def rules(
    code: Annotated[str | None, typer.Argument(metavar="CODE", help="A rule's code, or its beginning.")] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print docs/rules.md.")] = False,
) -> None:
    """List the rules, or explain those whose code starts with CODE."""
    from mrm_mtlx.findings.catalogue import RULES

    if markdown:
        typer.echo(markdown_page(list(RULES.values())))
        return
    if code is None:
        width = max(len(c) for c in RULES)
        for rule in RULES.values():
            typer.echo(f"{rule.code.ljust(width)}  {rule.severity.value.ljust(7)}  {rule.title}")
        return
    found = [rule for rule in RULES.values() if rule.code.startswith(code.upper())]
    if not found:
        raise typer.BadParameter(f"no rule starts with '{code}'; `mrm rules` lists them", param_hint="CODE")
    typer.echo("\n\n".join(page(rule) for rule in found))


def page(rule: Rule) -> str:
    """One rule for the terminal."""
    body = [
        textwrap.fill(text, 96, initial_indent="  ", subsequent_indent="  ") for text in (rule.meaning, rule.remedy)
    ]
    return "\n\n".join([f"{rule.code} ({rule.severity}): {rule.title}", *body])


def markdown_page(catalogue: list[Rule]) -> str:
    """All rules as docs/rules.md."""
    parts = ["<!-- Made by `mrm rules --markdown`; do not edit. -->", "# Rules", ""]
    parts.append(
        "Every finding of `mrm validate` has one of these codes. Errors fail a run; warnings do with `--strict`."
    )
    for rule in catalogue:
        parts += ["", f"## {rule.code}", "", f"*{rule.severity.value}*: {rule.title}", ""]
        parts += [textwrap.fill(rule.meaning, 110), "", f"**What to do.** {textwrap.fill(rule.remedy, 110)}"]
    return "\n".join(parts)
