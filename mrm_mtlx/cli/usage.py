"""Wrong values of options, told in the words of this project: the command-line library has others in every version."""

from __future__ import annotations

import re
from enum import Enum
from typing import Any, get_args, get_type_hints

from typer.core import TyperGroup
from typer.models import ArgumentInfo, OptionInfo, ParameterInfo

from mrm_mtlx.system.arguments import ArgumentError


class Group(TyperGroup):
    """The commands; what is wrong with a call of one is said in our words."""

    def invoke(self, ctx: Any) -> Any:
        """Invoke the command that is named."""
        try:
            return super().invoke(ctx)
        except Exception as error:
            if hasattr(error, "format_message"):
                reword(error)
            raise


def called(hint: Any) -> str:
    """The name of an option, or the place of an argument in the usage line; "" of what is neither."""
    info = _info(hint)
    if isinstance(info, OptionInfo):
        declared = [info.default, *(info.param_decls or ())]  # in an annotation, the first is taken for a default
        return next((name for name in declared if isinstance(name, str) and name.startswith("--")), "")
    return str(info.metavar) if isinstance(info, ArgumentInfo) else ""


def is_help(error: Any) -> bool:
    """True if the message is the help, of a command of which nothing was asked."""
    context = getattr(error, "ctx", None)
    return context is not None and error.message == context.get_help()


def reword(error: Any) -> None:
    """Say of a value that is of the wrong type what was expected, and name the option as all other messages do."""
    parameter, context = getattr(error, "param", None), getattr(error, "ctx", None)
    if parameter is None or context is None or error.param_hint is not None or not error.message:
        return  # of what is missing there is no message, but its name
    hint = get_type_hints(context.command.callback, include_extras=True).get(parameter.name)
    error.param_hint = called(hint) or None
    value, expected = _value(error), _expected(hint)
    if value is not None and expected:
        error.message = f"{value}: expected {expected}"


def _value(error: Any) -> str | None:
    """The value that could not be taken for one of the option's type; None if that is not what is wrong."""
    cause = error.__cause__
    if isinstance(cause, ArgumentError):
        return None
    if hasattr(cause, "errors"):  # the library's own library
        return f"'{cause.errors()[0]['input']}'"
    found = re.match(r"(.+?) is not (?:a valid|one of|in the range)\b", str(error.message))
    return f"'{found[1].strip(chr(39))}'" if found else None


def _expected(hint: Any) -> str:
    """The values of an option, in words; "" if any text is one."""
    kind, info = _type(hint), _info(hint)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return f"one of {', '.join(str(member.value) for member in kind)}"
    number = {int: "a whole number", float: "a number"}.get(kind, "")
    if not number or info is None or info.min is None:
        return number
    return f"{number}, {info.min:.10g} {'or more' if info.max is None else f'to {info.max:.10g}'}"


def _info(hint: Any) -> ParameterInfo | None:
    return next((info for info in getattr(hint, "__metadata__", ()) if isinstance(info, ParameterInfo)), None)


def _type(hint: Any) -> Any:
    """The type of an option's single value: of `list[float] | None`, float."""
    while get_args(hint):
        hint = next(part for part in get_args(hint) if part is not type(None))
    return hint
