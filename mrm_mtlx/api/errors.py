"""The exceptions of the public functions. A wrong call is a `system.arguments.ArgumentError`, a ValueError."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.findings.finding import Finding


class MrmError(Exception):
    """Base of what goes wrong though the call is right."""


class DocumentError(MrmError):
    """A document cannot be used: it cannot be read, or it is broken.

    Attributes
    ----------
    findings
        What was found in the document, in order.
    """

    def __init__(self, message: str, findings: Sequence[Finding] = ()) -> None:
        super().__init__(message)
        self.findings = tuple(findings)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.findings)


class NothingToRenderError(DocumentError):
    """A document has no surface."""


class NoReferenceError(DocumentError):
    """The reference does not evaluate what a surface is made of."""


class NoValueError(DocumentError):
    """A surface has no finite value for one of the directions that are asked for."""


class ShaderError(DocumentError):
    """A generator or a compiler refuses a surface."""


class NothingToConvertError(DocumentError):
    """A document has nothing that a format can say."""


class DataError(MrmError):
    """Measured data cannot be read, or cannot be fitted."""


class UnavailableError(MrmError):
    """A call needs what this machine lacks; the message has the command that adds it."""
