"""`mrm rules`: what each finding means."""

from __future__ import annotations

from typing import Annotated

import typer

from mrm_mtlx.cli import errors


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, rules)


def rules(
    code: Annotated[str | None, typer.Argument(metavar="CODE", help="A rule's code, or its beginning.")] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print docs/rules.md.")] = False,
) -> None:
    """List the rules, or explain those whose code starts with CODE."""
    import mrm_mtlx as mrm
    from mrm_mtlx.system.arguments import refuse

    if markdown:
        refuse({"code": code}, "not with `markdown`, which has all rules")
    typer.echo(mrm.rules_page() if markdown else mrm.rules(code))
