"""`python -m tools.trace_files`: no command opens a file that is not its own, seen by the operating system.

All commands are run on hostile documents under strace, which sees what every library and every process opens. Allowed
are: the folder of the documents; the node libraries and the interpreter with its packages; the operating system's own
libraries, programs and devices (`SYSTEM`); and the scratch folder, where also the results go. Anything else that was
opened, or tried and only was not there, is printed, and the exit status is 1. A named pipe in the folder is not to be
opened either.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import os
import pkgutil
import re
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from tools import hostile_documents

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

REPOSITORY = Path(__file__).resolve().parents[1]
# Of the operating system: libraries, drivers, fonts, locales and devices, and files of /etc that libraries look for.
SYSTEM = (
    "/usr/", "/lib/", "/lib64/", "/bin/", "/sbin/", "/opt/", "/proc/", "/sys/", "/dev/", "/etc/ld.so",
    "/etc/localtime", "/etc/fonts", "/etc/drirc", "/etc/glvnd", "/etc/egl", "/etc/OpenCL", "/etc/vulkan",
    "/etc/nsswitch.conf", "/etc/passwd", "/etc/group", "/etc/ssl", "/etc/mime.types", "/etc/httpd", "/etc/apache",
    "/etc/os-release", "/etc/lsb-release", "/etc/debian_version", "/etc/gai.conf", "/etc/alternatives",
    "/etc/machine-id", "/var/cache/fontconfig", "/etc/matplotlibrc", "/etc/locale.alias", "/etc/host.conf",
    "/etc/resolv.conf",
)  # fmt: skip
# Calls of the traced program that say which command is next, by trying to open a file of this folder.
_MARK = "/mrm-next-command/"
# Seconds for one command on one document, and for `validate` over all of them.
_COMMAND_LIMIT_S, _VALIDATE_LIMIT_S = 60, 1200
_OPENING = re.compile(
    r"(?:open|creat|openat|openat2)\((?:(?:AT_FDCWD|\d+)<(?P<folder>[^>]*)>, )?"
    r'"(?P<name>(?:[^"\\]|\\.)*)"(?P<result>.*)$'
)
# What the system says was opened; of a call that another process's line interrupts, only the name is known.
_OPENED = re.compile(r" = \d+<(?P<path>.*?)>(?:\(deleted\))?$")


@dataclass
class Openings:
    """What a trace shows: openings by command and by what they belong to, and those that belong to nothing allowed."""

    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    outside: list[tuple[str, str, str]] = field(default_factory=list)

    def table(self) -> str:
        """A row per command, in Markdown."""
        commands = list(dict.fromkeys(command for command, _ in self.counts))
        sorts = ("documents", "scratch", "packages", "system", "outside")
        lines = [f"| command | {' | '.join(sorts)} |", "|---" * (1 + len(sorts)) + "|"]
        lines += [
            f"| {command} | {' | '.join(f'{self.counts[command, sort]:,}' for sort in sorts)} |" for command in commands
        ]
        return "\n".join(lines)


@dataclass(frozen=True)
class Allowed:
    """The folders that may be opened, by what they are."""

    documents: Path
    scratch: Path

    def sort(self, path: str) -> str:
        """What a path belongs to; "outside" for nothing allowed."""
        if not path or path.startswith(("pipe:", "socket:", "anon_inode:", "/memfd:", "memfd:")):
            return "system"
        if _inside(path, self.documents):
            return "outside" if _is_pipe(Path(path)) else "documents"
        if _inside(path, self.scratch):
            return "scratch"
        if any(_inside(path, folder) for folder in _packages()):
            return "packages"
        if path == str(REPOSITORY):  # listed by the interpreter, which looks for modules there
            return "packages"
        return "system" if path == "/" or f"{path}/".startswith(SYSTEM) else "outside"


def _inside(path: str, folder: Path) -> bool:
    return path == str(folder) or path.startswith(f"{folder}{os.sep}")


def _is_pipe(path: Path) -> bool:
    try:
        return stat.S_ISFIFO(path.lstat().st_mode)
    except OSError:
        return False


def _packages() -> list[Path]:
    """Folders of the package, its node libraries and materials, the interpreter and what is installed."""
    own = [REPOSITORY / name for name in ("mrm_mtlx", "libraries", "materials", "tools")]
    interpreter = [Path(p) for p in {sys.prefix, sys.base_prefix, *sys.path} if p and Path(p) != REPOSITORY]
    return [folder for path in (*own, *interpreter) for folder in {path, path.resolve()}]


def openings(lines: Iterable[str], allowed: Allowed) -> Openings:
    """What the lines of a trace show."""
    found = Openings()
    command = document = ""
    for line in lines:
        match = _OPENING.search(line)
        if match is None:
            continue
        name = _plain(match["name"])
        if name.startswith(_MARK):
            command, _, document = name.removeprefix(_MARK).partition("/")
            continue
        opened = _OPENED.search(match["result"].rstrip())
        tried = Path(_plain(match["folder"] or "/"), name)
        path = _plain(opened["path"]) if opened else os.path.normpath(tried)
        sort = allowed.sort(path)
        found.counts[command, sort] += 1
        if sort == "outside":
            found.outside.append((command, document, path))
    return found


def _plain(text: str) -> str:
    """A string of strace without its escapes."""
    return (
        text.encode("latin-1", "backslashreplace")
        .decode("unicode_escape")
        .encode("latin-1", "replace")
        .decode("utf-8", "replace")
    )


def unavailable() -> str:
    """Why nothing can be traced here, with the command that helps; "" if it can."""
    if shutil.which("strace") is None:
        return "strace is not installed: apt-get install strace"
    tried = subprocess.run(["strace", "-qq", "-o", os.devnull, "true"], capture_output=True, text=True, check=False)
    return f"strace cannot trace here: {tried.stderr.strip()}" if tried.returncode else ""


def traced(command: list[str], log: Path, scratch: Path) -> Iterator[str]:
    """Run a command under strace; the lines of its trace. Homes and caches are in the scratch folder.

    Raises
    ------
    subprocess.CalledProcessError
        If it fails, or there is no strace.
    """
    home = scratch / "home"
    home.mkdir(exist_ok=True)
    places = dict.fromkeys(("HOME", "TMPDIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR"), str(home))
    strace = ["strace", "-f", "-qq", "-y", "-s", "4096", "-o", str(log), "-e", "trace=open,openat,openat2,creat"]
    subprocess.run(
        [*strace, *command], check=True, env={**os.environ, **places, "TMPDIR": str(scratch)}, cwd=REPOSITORY
    )
    with log.open(encoding="utf-8", errors="replace") as stream:
        yield from stream


def inner(documents: Path, scratch: Path, chosen: list[str], targets: list[str]) -> None:
    """Run the commands; this is what is traced. Each document has a process of its own, made by a fork."""
    from mrm_mtlx.library import load_library

    load_library()
    _import_all()
    os.chdir(scratch)
    for name in chosen:
        _forked(list(_commands(documents / name, scratch)))
    whole = [documents / name for name in chosen] if len(chosen) < len(list(documents.iterdir())) // 2 else [documents]
    options = ["--samples", "64", "-j", "1", "--output", str(scratch / "report.txt")]
    options += [word for target in targets for word in ("--target", target)]
    _run("validate", [*map(str, whole), *options], _VALIDATE_LIMIT_S)


def _commands(path: Path, scratch: Path) -> Iterator[tuple[str, list[str]]]:
    """What is run on a document."""
    if path.suffix in (".csv", ".alta", ".binary"):
        yield "fit", [str(path), "-o", str(scratch / "fitted.mtlx")]
    elif path.suffix == ".json":
        yield "convert", [str(scratch / "plain.mtlx"), "-o", str(scratch / "m.json"), "--into", str(path)]
    else:
        yield "generate", [str(path), "-o", str(scratch / "generated")]
        yield "generate", [str(path), "--target", "osl", "-o", str(scratch / "generated")]
        for suffix in (".usdz", ".glb") if path.suffix == ".mtlx" else (".mtlx",):
            yield "convert", [str(path), str(scratch / f"converted{suffix}")]
        yield "render", [str(path), "--size", "16", "-o", str(scratch / "picture.png")]
        yield "plot", [str(path), "-o", str(scratch / "plot.svg")]
        yield "photometry", [str(path), "--output", str(scratch / "photometry.txt")]


def _import_all() -> None:
    """Import the package, and what commands import when they run: once, not in each fork."""
    import mrm_mtlx

    for module in pkgutil.walk_packages(mrm_mtlx.__path__, "mrm_mtlx."):
        if not module.name.endswith("_server"):  # programs for another interpreter
            importlib.import_module(module.name)
    importlib.import_module("matplotlib.pyplot")


def _forked(commands: list[tuple[str, list[str]]]) -> None:
    """Run commands in a process of their own, which may die."""
    child = os.fork()
    if child == 0:
        try:
            for command, words in commands:
                _run(command, words)
        finally:
            os._exit(0)
    os.waitpid(child, 0)


def _run(command: str, words: list[str], limit_s: int = _COMMAND_LIMIT_S) -> None:
    """Run a command of `mrm` in this process, whatever comes of it, and for some time at most."""
    from typer.testing import CliRunner

    from mrm_mtlx.cli.main import app

    def late(*_: object) -> None:
        raise TimeoutError

    subject = Path(words[0]).name
    with contextlib.suppress(OSError):
        os.close(os.open(f"{_MARK}{command}/{subject}", os.O_RDONLY))
    signal.signal(signal.SIGALRM, late)
    signal.alarm(limit_s)
    done = CliRunner().invoke(app, [command, *words], prog_name="mrm")
    signal.alarm(0)
    if isinstance(done.exception, Exception):
        print(f"{command} {subject}: {type(done.exception).__name__}: {done.exception}", file=sys.stderr)


def run(share: int, targets: list[str]) -> tuple[int, Openings]:
    """Trace every `share`-th document; how many there were, and what was opened."""
    with tempfile.TemporaryDirectory(prefix="mrm-trace-") as name:
        folder = Path(name).resolve()
        place = hostile_documents.lay_out(folder)
        scratch = folder / "scratch"
        scratch.mkdir()
        shutil.copy(REPOSITORY / "materials" / "segmented_trim.mtlx", scratch / "plain.mtlx")
        written = [p.relative_to(place.documents) for p in hostile_documents.write_all(place)]
        chosen = [p for p in written if p.parent == Path() and p.suffix != ".glsl"][::share]
        command = [sys.executable, "-m", "tools.trace_files", "--inner", str(place.documents), str(scratch)]
        command += [word for target in targets for word in ("--target", target)] + list(map(str, chosen))
        found = openings(traced(command, folder / "trace", scratch), Allowed(place.documents, scratch))
        return len(chosen), found


def main(arguments: list[str]) -> int:
    """Run the command; 1 if anything was opened that is not allowed."""
    parser = argparse.ArgumentParser(prog="python -m tools.trace_files", description=__doc__.partition("\n")[0])
    parser.add_argument("--share", type=int, default=1, help="every so many-th document; default: all")
    parser.add_argument("--target", action="append", help="of validate; repeatable; default: glsl")
    parser.add_argument("--inner", nargs=2, type=Path, help=argparse.SUPPRESS)
    parser.add_argument("chosen", nargs="*", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    targets = options.target or ["glsl"]
    if options.inner:
        documents, scratch = options.inner
        inner(documents, scratch, options.chosen, targets)
        return 0
    missing = unavailable()
    if missing:
        print(missing, file=sys.stderr)
        return 2
    number, found = run(options.share, targets)
    print(f"{number} documents\n\n{found.table()}\n")
    for (command, document, path), times in Counter(found.outside).most_common():
        print(f"outside: {path}  by {command} {document} ({times} times)")
    print("FAILED" if found.outside else "PASSED", f" {len(found.outside)} openings outside")
    return 1 if found.outside else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
