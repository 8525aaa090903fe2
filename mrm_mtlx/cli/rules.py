"""`mrm rules`: what each finding means."""

from __future__ import annotations

from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(rules)


def rules(
    code: Annotated[str | None, typer.Argument(metavar="CODE", help="A rule's code, or its beginning.")] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print docs/rules.md.")] = False,
) -> None:
    """List the rules, or explain those whose code starts with CODE."""
    from mrm_mtlx.findings import pages
    from mrm_mtlx.findings.catalogue import RULES, all_rules, rules_from

    if markdown:
        typer.echo(pages.markdown_page(RULES.values()))
        return
    if code is None:
        typer.echo(pages.table(all_rules().values()))
        return
    found = rules_from(code.upper())
    if not found:
        raise typer.BadParameter(f"no rule starts with '{code}'; `mrm rules` lists them", param_hint="CODE")
    typer.echo("\n\n".join(pages.page(rule) for rule in found))
