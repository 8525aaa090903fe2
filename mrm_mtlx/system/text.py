"""Untrusted text as it is shown: on a terminal, in a report, in a message."""

from __future__ import annotations


def printable(text: str) -> str:
    """Text on one line in which every character is one that is seen.

    Controls, which could drive a terminal, marks of direction, which could make a line read as another, the separators
    of lines and paragraphs of Unicode, and what is no character are a space each.
    """
    return "".join(c if c.isprintable() else " " for c in text)


def shown(text: str, quote: str = "'", most: int = 80) -> str:
    """A text of a file in quotes, as a message has it: printable, and of at most so many characters."""
    text = printable(text)
    return f"{quote}{text if len(text) <= most else text[:most] + '...'}{quote}"


def plural(count: int, noun: str) -> str:
    """A count with its noun."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def text_lines(text: str) -> list[str]:
    """The lines of a text, ended by a line feed alone: `str.splitlines` knows eleven ends of a line."""
    return text.replace("\r\n", "\n").removesuffix("\n").split("\n")
