"""The command `mrm`: registers the commands and turns what escapes them into exit statuses."""

from __future__ import annotations

import errno
import os
import sys
from typing import Annotated, Any

import typer

from mrm_mtlx.cli import (
    conformance,
    convert,
    doctor,
    fit,
    generate,
    library,
    photometry,
    plot,
    render,
    rules,
    supervision,
    usage,
    validate,
    vectors,
)
from mrm_mtlx.system import child, process_limits
from mrm_mtlx.system.plugins import PluginError
from mrm_mtlx.system.text import printable, text_lines
from mrm_mtlx.system.versions import __version__

# What a user can mend: no room where the output goes, or a name that no file can have.
_USERS_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.ENAMETOOLONG)

# The variable by which a shell asks for completions.
_COMPLETION = "_MRM_COMPLETE"

app = typer.Typer(
    name="mrm",
    cls=usage.Group,
    help="Retroreflective materials in MaterialX: check them, run them, look at them.",
    no_args_is_help=True,
    rich_markup_mode=None,  # plain help starts in half the time
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

for module in (
    validate,
    conformance,
    generate,
    render,
    plot,
    photometry,
    fit,
    convert,
    vectors,
    rules,
    doctor,
    library,
):
    module.register(app)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"mrm {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Retroreflective materials in MaterialX: check them, run them, look at them."""


def run() -> None:
    """Entry point. Exit status: 0 clean, 1 findings, 2 usage or internal error, 3 nothing checked, 130 interrupted."""
    if _COMPLETION in os.environ:  # a key was pressed: names of options, and no process to wait for
        app(prog_name="mrm")
    sys.exit(supervision.supervised(command, _tell))


def command() -> int:
    """Run the command in this process, as `run` does in a child; its exit status."""
    try:
        status = app(prog_name="mrm", standalone_mode=False)
    except (typer.Abort, KeyboardInterrupt):
        status = 130  # of an interrupt, the command-line library makes the one, the other, or the status itself
    except (BrokenPipeError, SystemExit):
        # The reader of our output went away (`mrm ... | head`), which the libraries below turn into SystemExit: nothing
        # is wrong, and nothing more can be written, not even at the interpreter's end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 0
    except Exception as error:
        status = _report(error)
    if status == 130:
        print("mrm: interrupted", file=sys.stderr)
    return status if isinstance(status, int) else 0


def _tell(death: supervision.Death) -> int:
    """Say what the process of the command died of; the exit status."""
    from mrm_mtlx.cli.console import Terminal
    from mrm_mtlx.findings import rules

    cause = process_limits.cause_of_death(death.status)
    if not death.document:
        print(f"mrm: internal error: the process died ({cause})", file=sys.stderr)
        return 2
    rule, reason = rules.CHECK_CRASHED, f"the process that worked on it died ({cause})"
    if process_limits.is_time_up(death.status):
        rule, reason = rules.CHECK_TIMEOUT, "not finished within the time limit"
    Terminal().findings([rule.at("", f"{death.document}: {reason}")])
    return 1


def _report(error: Any) -> int:
    """Show a usage error as such, anything else as an internal error in one line."""
    if hasattr(error, "show") and hasattr(error, "exit_code"):
        if not usage.is_help(error):
            error.message = printable(str(error.message))  # it may name what a document says
        error.show()
        return int(error.exit_code)
    from mrm_mtlx.cli.console import Terminal
    from mrm_mtlx.findings import rules

    opened = child.opened()
    if isinstance(error, MemoryError) and opened is not None:
        Terminal().findings([rules.CHECK_CRASHED.at("", f"{opened}: {process_limits.memory_reason()}")])
        return 1
    if isinstance(error, OSError) and error.errno in _USERS_ERRORS:
        print(printable(f"mrm: {error.strerror}{f': {error.filename}' if error.filename else ''}"), file=sys.stderr)
        return 2
    message = text_lines(str(error).strip())[0] or "no message"
    if isinstance(error, PluginError):
        print(printable(f"mrm: {message}"), file=sys.stderr)
        return 2
    print(printable(f"mrm: internal error: {type(error).__name__}: {message}"), file=sys.stderr)
    return 2


if __name__ == "__main__":
    run()
