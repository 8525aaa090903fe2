"""Results that show themselves: on a terminal, as plain text, and as HTML in a notebook."""

from __future__ import annotations

import io
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mrm_mtlx.findings.finding import Severity
from mrm_mtlx.system.shown import Shown, escaped, html_table
from mrm_mtlx.system.text import plural, printable
from mrm_mtlx.validation import reports
from mrm_mtlx.validation.results import Stage, Status, ValidationResult

if TYPE_CHECKING:
    from typing import TextIO

    from rich.console import Console

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.validation.results import DocumentResult, RenderableResult, TargetResult

# Width of tables where the output is not a terminal: wide enough that little wraps.
_WIDE = 200
_COLORS = {Severity.ERROR: "red", Severity.WARNING: "yellow"}
_SHORT = {
    Stage.COMPILE: "compiled",
    Stage.COMPARE: "compared",
    Stage.GENERATE: "generated",
    Stage.READ: "not run",
}
# Between the columns of a table.
_GAP = 3
_NOTE = "Figures are median relative errors; every sample is held to its own tolerance."


@dataclass(frozen=True, repr=False)
class ValidationReport(Shown, ValidationResult):
    """A run that shows itself; `strict` is whether warnings and skips count as failures."""

    strict: bool = False

    @property
    def exit_status(self) -> int:
        """As the command has it: 0 clean, 1 not, 3 if nothing was checked."""
        return reports.exit_status(self, strict=self.strict)

    @property
    def passed(self) -> bool:
        """True if something was checked, and nothing is wrong with it."""
        return self.exit_status == 0

    def verdict(self) -> str:
        """The last line of the report."""
        return reports.verdict(self, strict=self.strict)

    def report(self) -> str:
        """Findings and a table of each document, and the verdict."""
        return text(self)

    def to_json(self) -> str:
        """The report by docs/report.schema.json."""
        return reports.to_json(self)

    def _repr_html_(self) -> str:
        return to_html(self)


@dataclass(frozen=True, repr=False)
class CheckReport(Shown):
    """Findings of reading documents and of checking their structure; `strict` is whether warnings count as failures."""

    documents: list[DocumentResult]
    strict: bool = False

    @property
    def findings(self) -> list[tuple[str, Finding]]:
        """All findings as (path of the document, finding)."""
        return [(document.path, found) for document in self.documents for found in document.findings]

    @property
    def passed(self) -> bool:
        """True if there are documents, and no errors in them."""
        wrong = [found for _, found in self.findings if self.strict or found.severity is Severity.ERROR]
        return bool(self.documents) and not wrong

    def verdict(self) -> str:
        """The last line of the report."""
        severities = [found.severity for _, found in self.findings]
        counts = {str(severity): severities.count(severity) for severity in Severity} | {
            "document": len(self.documents)
        }
        word = "PASSED" if self.passed else "FAILED" if self.documents else "NOTHING CHECKED"
        listed = ", ".join(plural(count, name) for name, count in counts.items())
        return f"{word}  {listed}{'; --strict' if self.strict else ''}"

    def report(self) -> str:
        """Findings of each document, and the verdict."""
        return text(self)

    def _repr_html_(self) -> str:
        return to_html(self)


def console(stream: TextIO | None = None) -> Console:
    """A console on stdout or a stream; colours and the width of a terminal only on one, NO_COLOR honoured."""
    from rich.console import Console

    target = stream or sys.stdout
    return Console(file=target, highlight=False, soft_wrap=True, width=None if target.isatty() else _WIDE)


def text(result: ValidationReport | CheckReport) -> str:
    """The report of a result, without colours."""
    stream = io.StringIO()
    print_result(console(stream), result)
    return stream.getvalue().rstrip()


def print_result(screen: Console, result: ValidationReport | CheckReport) -> None:
    """Print findings and a table of each document, and the verdict."""
    for document in result.documents:
        _print_document(screen, document)
    if isinstance(result, ValidationReport) and any(r.median_error is not None for _, r in result.results()):
        screen.print(_NOTE, style="dim")
    screen.print(result.verdict(), markup=False, style="bold")


def _print_document(screen: Console, document: DocumentResult) -> None:
    from rich.text import Text

    screen.print(printable(document.path), style="bold", markup=False)
    for found in document.findings:
        line = found.source.within(document.path) if found.source else ""
        place = f" {found.code} {printable(found.location)}".rstrip()
        severity = (found.severity.value, _COLORS[found.severity])
        screen.print(Text.assemble("  ", printable(f"{line} ").lstrip(), severity, place))
        screen.print(f"      {printable(found.message)}", markup=False)
        screen.print(f"      {printable(found.hint)}", markup=False, style="dim")
    if document.renderables:
        _print_targets(screen, document.renderables)
    screen.print()


def _print_targets(screen: Console, renderables: list[RenderableResult]) -> None:
    """A row per surface, a column per target; where that is too wide, the targets of each surface in lines."""
    from rich.table import Table
    from rich.text import Text

    targets = list(renderables[0].targets)
    rows = [
        [
            Text(f"  {printable(renderable.name)}"),
            *(Text.from_markup(_cell(renderable.targets[t])) if t in renderable.targets else Text() for t in targets),
        ]
        for renderable in renderables
    ]
    header = [Text(name) for name in ("  surface", *targets)]
    if sum(max(cell.cell_len for cell in column) + _GAP for column in zip(header, *rows, strict=True)) <= screen.width:
        table = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0), header_style="dim")
        for name in header:
            table.add_column(name, no_wrap=True)
        for row in rows:
            table.add_row(*row)
        screen.print(table)
        return
    for renderable in renderables:
        screen.print(Text(f"  {printable(renderable.name)}"))
        _print_cells(screen, renderable)


def _print_cells(screen: Console, renderable: RenderableResult) -> None:
    """Targets and their results, as many on a line as it holds."""
    from rich.text import Text

    line = Text()
    for target, result in renderable.targets.items():
        cell = Text.from_markup(f"[dim]{target}[/dim] {_cell(result)}")
        if line and len(line) + _GAP + len(cell) > screen.width:
            screen.print(line)
            line = Text()
        line.append(" " * (_GAP if line else 4)).append_text(cell)
    screen.print(line)


def _cell(result: TargetResult) -> str:
    if result.status is Status.FAIL:
        return f"[red]FAIL {result.stage}[/red]"
    if result.status is Status.SKIP:
        return "[dim]-[/dim]" if result.stage is Stage.GENERATE else f"[dim]- {_SHORT[result.stage]}[/dim]"
    if result.median_error is not None:
        return f"[green]ok[/green] {result.median_error:.1e}"
    return f"[green]ok[/green] {_SHORT[result.stage]}"


def to_html(result: ValidationReport | CheckReport) -> str:
    """Tables of the surfaces and of the findings, and the verdict; what comes from documents is escaped."""
    surfaces = [(document.path, renderable) for document in result.documents for renderable in document.renderables]
    targets = list(dict.fromkeys(target for _, renderable in surfaces for target in renderable.targets))
    rows = [
        [path, renderable.name, *(_plain(renderable.targets.get(target)) for target in targets)]
        for path, renderable in surfaces
    ]
    found = [
        [_file(path, finding), finding.severity.value, finding.code, finding.location, finding.message, finding.hint]
        for path, finding in result.findings
    ]
    parts = [html_table(["document", "surface", *targets], rows)] if rows else []
    if found:
        parts.append(html_table(["document", "severity", "rule", "place", "found", "what to do"], found))
    return "".join([*parts, f"<p><b>{escaped(result.verdict())}</b></p>"])


def _file(path: str, found: Finding) -> str:
    """The file of a finding, and the line in it if that is known."""
    return f"{path} {found.source.within(path)}".rstrip() if found.source else path


def _plain(result: TargetResult | None) -> str:
    """A cell without colours, and the reason of what was not checked."""
    if result is None:
        return ""
    from rich.text import Text

    reason: Any = f" ({result.reason})" if result.reason else ""
    return f"{Text.from_markup(_cell(result)).plain}{reason}"
