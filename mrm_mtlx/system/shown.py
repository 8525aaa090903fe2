"""Results that show themselves: as text in a terminal and a Python shell, as HTML in a notebook."""

from __future__ import annotations

import html
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from mrm_mtlx.system.text import printable, text_lines

if TYPE_CHECKING:
    from collections.abc import Sequence


class Shown(ABC):
    """A result that is shown as its report. What comes from a document is untrusted: nothing of it is markup."""

    @abstractmethod
    def report(self) -> str:
        """The result as a report of lines, the verdict last."""

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        return preformatted(self.report())


def preformatted(text: str) -> str:
    """Text as HTML, line by line as it is."""
    shown = "\n".join(printable(line) for line in text_lines(text))
    return f'<pre style="line-height: 1.2; overflow-x: auto">{html.escape(shown)}</pre>'


# Columns of a terminal that everybody has.
COLUMNS = 80


def in_lines(items: Sequence[str], indent: int = 0) -> list[str]:
    """Items with commas between, as many on a line as `COLUMNS` holds behind an indent; no item is broken."""
    lines: list[str] = []
    for i, item in enumerate(items):
        text = item if i == len(items) - 1 else f"{item},"
        if lines and indent + len(lines[-1]) + 1 + len(text) <= COLUMNS:
            lines[-1] += f" {text}"
        else:
            lines.append(text)
    return lines


def html_table(header: Sequence[str], rows: Sequence[Sequence[str]], caption: str = "") -> str:
    """A table as HTML, of texts that are escaped."""

    def line(tag: str, cells: Sequence[str]) -> str:
        style = "text-align: left; vertical-align: top"
        return "<tr>" + "".join(f'<{tag} style="{style}">{escaped(cell)}</{tag}>' for cell in cells) + "</tr>"

    body = "".join(line("td", row) for row in rows)
    head = f"<thead>{line('th', header)}</thead>" if header else ""
    title = f'<caption style="text-align: left">{escaped(caption)}</caption>' if caption else ""
    return f"<table>{title}{head}<tbody>{body}</tbody></table>"


def escaped(text: str) -> str:
    """Untrusted text as HTML."""
    return html.escape(printable(text))
