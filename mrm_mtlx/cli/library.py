"""`mrm library`: where the node library is, and how other hosts get it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the command and its sub-command."""
    group = typer.Typer(help="Print where the node library is; `mrm library install DIR` copies it for other hosts.")
    group.callback(invoke_without_command=True)(show)
    group.command()(install)
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
        from mrm_mtlx.library import paths

        if materials and classes:
            raise typer.BadParameter("not with --materials", param_hint="--classes")
        chosen = paths.materials_folder if materials else paths.class_materials_folder if classes else None
        typer.echo((chosen or paths.node_library_folder)())


def install(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to install into; created if missing.")],
) -> None:
    """Copy the node library to DIR/mrm, and the extended surface models to DIR/mrm_surface_models."""
    from mrm_mtlx.library import install_library, load_library
    from mrm_mtlx.library.install import MODELS_FOLDER, NODES_FOLDER

    try:
        files = install_library(folder)
    except OSError as error:
        raise typer.BadParameter(f"{folder} cannot be written: {error.strerror or error}", param_hint="DIR") from error
    for file in files:
        typer.echo(file)
    for extension in load_library().surface_models:
        if extension.reason:
            typer.echo(f"{extension.model.node} is left out: {extension.reason}", err=True)
    typer.echo(
        f"Search path '{folder}'. Load the folder '{NODES_FOLDER}' before the standard library, '{MODELS_FOLDER}' "
        f"after it; for example generateshader --path {folder} --library {NODES_FOLDER} ...",
        err=True,
    )
