"""The parameters of a generated OSL shader, as its source declares them."""

from __future__ import annotations

import re
from dataclasses import dataclass

from mrm_mtlx.shadergen.generate import GenerationError

# The shader comes last; what opens and closes its list of parameters has lines of its own.
_SHADER, _OPENING, _CLOSING = "\nshader ", "\n(\n", "\n)\n{\n"
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
    GenerationError
        If the source has no list of parameters as MaterialX writes one.
    """
    before, shader, rest = source.rpartition(_SHADER)
    name, opening, rest = rest.partition(_OPENING)
    listed, closing, body = rest.partition(_CLOSING)
    if not (shader and opening and closing):
        msg = "the source has no shader with a list of parameters as MaterialX writes one"
        raise GenerationError(msg)
    parameters = []
    for line in listed.split("\n"):
        found = _DECLARATION.fullmatch(line)
        if found:  # the other lines are metadata
            parameters.append(Parameter(found["name"], found["type"], found["value"], bool(found["output"])))
    return before + shader + name, parameters, body


def joined(head: str, parameters: list[Parameter], body: str) -> str:
    """The source of a shader with these parameters."""
    return head + _OPENING + ",\n".join(parameter.declaration for parameter in parameters) + _CLOSING + body
