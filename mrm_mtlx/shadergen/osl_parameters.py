"""The parameters of a generated OSL shader, as its source declares them."""

from __future__ import annotations

import re
from dataclasses import dataclass

# The shader's parameters are the last list that opens with a parenthesis on a line of its own.
_OPENING, _CLOSING = "\n(\n", "\n)\n{\n"
_DECLARATION = re.compile(r"    (?P<output>output )?(?P<type>\w+) (?P<name>\w+) = (?P<value>.*?),?")


@dataclass(frozen=True)
class Parameter:
    """A parameter with its type, its value as source text, and whether it is the shader's output."""

    name: str
    type: str
    value: str
    output: bool = False
    metadata: str = ""

    @property
    def declaration(self) -> str:
        """The declaration in a list of parameters, without a comma; metadata in double brackets."""
        known = f" [[ {self.metadata} ]]" if self.metadata else ""
        return f"    {'output ' if self.output else ''}{self.type} {self.name} = {self.value}{known}"

    @property
    def local(self) -> str:
        """The declaration of a variable of the body with this value."""
        return f"    {self.type} {self.name} = {self.value};\n"


def split(source: str) -> tuple[str, list[Parameter], str]:
    """What precedes the shader's list of parameters, the parameters without metadata, and the body that follows.

    `joined` puts them together again.

    Raises
    ------
    ValueError
        If the source has no list of parameters as MaterialX writes one.
    """
    head, opening, rest = source.rpartition(_OPENING)
    listed, closing, body = rest.partition(_CLOSING)
    if not (opening and closing):
        msg = "the source has no list of parameters as MaterialX writes one"
        raise ValueError(msg)
    parameters = []
    for line in listed.split("\n"):
        found = _DECLARATION.fullmatch(line)
        if found:  # the other lines are metadata
            parameters.append(Parameter(found["name"], found["type"], found["value"], bool(found["output"])))
    return head, parameters, body


def joined(head: str, parameters: list[Parameter], body: str) -> str:
    """The source of a shader with these parameters."""
    return head + _OPENING + ",\n".join(parameter.declaration for parameter in parameters) + _CLOSING + body
