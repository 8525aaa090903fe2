"""`python -m tools.make_docs`: every generated page, figure and picture of the documentation, made anew.

With names, only these: `python -m tools.make_docs rules.md figures/lobes.svg`. With `--check` nothing is written: what
is quickly made is compared with what is there, and the exit status is 1 if something is out of date. What takes
minutes, or a runtime that is not everywhere, is named as not compared.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).parents[1]
DOCS = REPOSITORY / "docs"
MRM = ("-m", "mrm_mtlx.cli.main")


@dataclass(frozen=True)
class Product:
    """A generated file, and what makes it.

    Attributes
    ----------
    command : tuple of str
        Arguments of the interpreter, run in the repository; `{file}` and `{folder}` stand for where the file is to be
        written, and its folder. A command with neither prints the file.
    minutes : bool
        Whether it takes too long, or needs too much, to be compared at every check.
    """

    command: tuple[str, ...]
    minutes: bool = False

    @property
    def printed(self) -> bool:
        """Whether the command prints the file."""
        return not any("{" in part for part in self.command)


# Calls of `mrm plot` for the figures of docs/plots.md.
FIGURES = {
    "figures/lobes.svg": "--roughness 0.4 --light 20 --light 60 -o {file}",
    "figures/polar.svg": "--roughness 0.4 --light 20 --light 60 --scale polar -o {file}",
    "figures/tape.svg": "materials/retroreflective_tape_yellow.mtlx --light 15 --light 60 -o {file}",
    "figures/figure2.svg": "--figure 2 -o {file}",
    "figures/figure4.svg": "--figure 4 -o {file}",
}
_R_A = "photometry materials/conspicuity_tape_white.mtlx --class DOT-C2 --color white --plot {file}"
PICTURES = ("compare.png", "materials.png", "portable.png", "gltf.png", "osl.png", "storm.png")
FORMAT_PICTURES = ("gltf-nearest.png", "usd-preview.png")
_FORMAT_PICTURES = Product(("-m", "tools.format_pictures", "-o", "{folder}"), minutes=True)
BLENDER_PICTURES = ("blender-first.png", "blender-materials.png")
_BLENDER = Product(("-m", "tools.blender_extension.figures", "-o", "{folder}"), minutes=True)
_PICTURES = Product(("-m", "tools.pictures", "-o", "{folder}"), minutes=True)
PRODUCTS = {
    "rules.md": Product((*MRM, "rules", "--markdown")),
    "classes.md": Product(("-m", "tools.classes_page")),
    "osl-accuracy.md": Product(("-m", "tools.osl_accuracy"), minutes=True),
    "portable-accuracy.md": Product(("-m", "tools.portable_accuracy"), minutes=True),
    **{name: Product((*MRM, "plot", *call.split())) for name, call in FIGURES.items()},
    "figures/photometry.svg": Product((*MRM, *_R_A.split())),
    "figures/house.svg": Product(("-m", "tools.house", "{file}")),
    "images/classes.png": Product(("-m", "tools.classes_page", "--picture", "{file}"), minutes=True),
    "images/threejs.png": Product(("-m", "tools.threejs_picture", "{file}"), minutes=True),
    "images/hosts.png": Product(("-m", "tools.hosts_picture", "{file}"), minutes=True),
    **{f"images/{name}": _PICTURES for name in PICTURES},
    **{f"images/{name}": _FORMAT_PICTURES for name in FORMAT_PICTURES},
    **{f"images/{name}": _BLENDER for name in BLENDER_PICTURES},
}
_NUMBER = re.compile(r"-?\d+\.\d+|-?\d+")
# A fiftieth of a line's width, in points.
MOVED = 0.02


def main(arguments: list[str]) -> int:
    """Run the command; 1 if `--check` finds what is out of date, 2 if something cannot be made."""
    parser = argparse.ArgumentParser(prog="python -m tools.make_docs", description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; say what is out of date")
    parser.add_argument("names", nargs="*", metavar="NAME", help="files below docs/; default: all")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.names if name not in PRODUCTS]
    if unknown:
        parser.error(f"{unknown[0]} is not generated; what is: {', '.join(PRODUCTS)}")
    chosen = {name: PRODUCTS[name] for name in options.names or PRODUCTS}
    try:
        return check(chosen) if options.check else make_all(chosen, DOCS)
    except subprocess.CalledProcessError as error:
        print(f"{' '.join(error.cmd[1:])}: {error.stderr.strip()}", file=sys.stderr)
        return 2


def make_all(products: dict[str, Product], folder: Path) -> int:
    """Make files below a folder; a command that makes several runs once."""
    done: set[Product] = set()
    for name, product in products.items():
        print(name, file=sys.stderr, flush=True)
        if product not in done:
            make(product, folder / name)
        done.add(product)
    return 0


def make(product: Product, path: Path) -> None:
    """Make a file; where the command fails, it stays as it was."""
    path.parent.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, *(part.format(file=path, folder=path.parent) for part in product.command)]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, encoding="utf-8", check=True)
    if product.printed:
        path.write_text(done.stdout, encoding="utf-8")


def check(products: dict[str, Product]) -> int:
    """Print for each file whether it is up to date; 1 if one is not."""
    verdicts = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, product in products.items():
            verdicts[name] = "not compared" if product.minutes else verdict(product, DOCS / name, Path(folder, name))
            print(f"{verdicts[name]:13} {name}", flush=True)
    return int("out of date" in verdicts.values())


def verdict(product: Product, kept: Path, again: Path) -> str:
    """Says "up to date" or "out of date", by making a file again."""
    make(product, again)
    texts = [path.read_text(encoding="utf-8") if path.is_file() else "" for path in (kept, again)]
    same = same_picture(*texts) if kept.suffix == ".svg" else texts[0] == texts[1]
    return "up to date" if same else "out of date"


def same_picture(first: str, second: str) -> bool:
    """Whether two SVG files differ in roundings alone; names of parts are hashes of what is in them."""
    texts = [re.sub(r"\b[a-z][0-9a-f]{10}\b", "part", text) for text in (first, second)]
    if _NUMBER.sub("0", texts[0]) != _NUMBER.sub("0", texts[1]):
        return False
    pairs = zip(*(map(float, _NUMBER.findall(text)) for text in texts), strict=True)
    return all(abs(a - b) <= MOVED for a, b in pairs)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
