"""`mrm library`: where the node library is, and how other hosts get it."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.system.arguments import refuse


class LibraryForm(StrEnum):
    """Form of the node library."""

    SOURCES = "sources"
    PORTABLE = "portable"


def register(app: typer.Typer) -> None:
    """Add the command and its sub-command."""
    group = typer.Typer(help="Print where the node library is; `mrm library install DIR` writes it for other hosts.")
    group.callback(invoke_without_command=True)(errors.reporting(show))
    errors.register(group, install)
    app.add_typer(group, name="library")


def show(
    context: typer.Context,
    materials: Annotated[bool, typer.Option("--materials", help="Print the folder of the ready materials.")] = False,
    classes: Annotated[
        bool, typer.Option("--classes", help="Print the folder of the materials that meet classes of standards.")
    ] = False,
) -> None:
    """Print the folder of the node library: a search path for MaterialX hosts."""
    if context.invoked_subcommand is None:
        import mrm_mtlx as mrm

        if materials:
            refuse({"classes": classes}, "not with `materials`")
        chosen = mrm.materials_folder if materials else mrm.class_materials_folder if classes else None
        typer.echo((chosen or mrm.node_library_folder)())


def install(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to install into; created if missing.")],
    host: Annotated[
        str, typer.Option("--host", metavar="NAME", help="For whom, such as blender-5.0; see docs/hosts.md.")
    ] = "plain",
    materialx: Annotated[
        str | None,
        typer.Option("--for", metavar="VERSION", help="Version of the host's MaterialX, if not that of docs/hosts.md."),
    ] = None,
    stdlib: Annotated[
        Path | None,
        typer.Option("--stdlib", metavar="DIR", help="Folder of the host, or of its standard library of MaterialX."),
    ] = None,
    form: Annotated[
        LibraryForm | None, typer.Option("--form", help="Form of the library; default: the one that the host takes.")
    ] = None,
) -> None:
    """Write the node library and the surface models for a host to DIR/mrm, and say what to set."""
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import terminal

    with terminal("installing"):  # a wheel that is fetched takes seconds
        installed = mrm.install_library(folder, host=host, materialx=materialx, stdlib=stdlib, form=form)
    typer.echo(installed)
    for note in installed.notes():
        typer.echo(note, err=True)
