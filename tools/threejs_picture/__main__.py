"""`python -m tools.threejs_picture threejs.png`: assets in three.js, as they are loaded and with our class.

Wants npm, which fetches three.js into a scratch folder, and Chromium. The page is served on loopback, for as long as it
takes.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import mrm_mtlx as mrm
from mrm_mtlx.library import materials_folder

REPOSITORY = Path(__file__).parents[2]
CLASS = REPOSITORY / "docs" / "hosts" / "khr_materials_retroreflection.js"
THREE = "three@0.187.0"
NAMES = ("traffic_cone_collar", "conspicuity_tape_red", "embossed_foil")
# Of the page: six panels of 180 with gaps of 4, and a line of labels over them.
SIZE = "1100,384"
# Rendered in software, as no other is there everywhere.
CHROMIUM = (
    "chromium", "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--virtual-time-budget=20000", "--hide-scrollbars", f"--window-size={SIZE}",
)  # fmt: skip
LONGEST_S = 120.0


class Quiet(SimpleHTTPRequestHandler):
    """A server of files that does not print what is asked of it."""

    def log_message(self, *_: object) -> None:
        """Print nothing."""


def prepare(folder: Path) -> None:
    """Put the page, the class, three.js and the assets into a folder."""
    subprocess.run(["npm", "install", "--no-audit", "--no-fund", THREE], cwd=folder, check=True, capture_output=True)
    (folder / "node_modules" / "three").rename(folder / "three")
    shutil.copy(Path(__file__).with_name("page.html"), folder)
    shutil.copy(CLASS, folder)
    for name in NAMES:
        mrm.convert(materials_folder() / f"{name}.mtlx", folder / f"{name}.glb")


def photograph(folder: Path, target: Path) -> str:
    """Show the page of a folder, write it as a picture, and return what it says of its pixels."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        assets = ",".join(f"{name}.glb" for name in NAMES)
        address = f"http://127.0.0.1:{server.server_address[1]}/page.html?assets={assets}"
        run = partial(subprocess.run, check=True, capture_output=True, text=True, timeout=LONGEST_S)
        run([*CHROMIUM, f"--screenshot={target.absolute()}", address])
        said: str = run([*CHROMIUM, "--dump-dom", address]).stdout
    finally:
        server.shutdown()
    return said.partition("<pre>")[2].partition("</pre>")[0]


def main(arguments: list[str]) -> None:
    """Draw the picture, and print a pixel of each panel."""
    parser = argparse.ArgumentParser(prog="python -m tools.threejs_picture", description=__doc__.partition("\n")[0])
    parser.add_argument("target", type=Path, metavar="FILE", help="what to write, a PNG")
    target = parser.parse_args(arguments).target
    with tempfile.TemporaryDirectory() as folder:
        prepare(Path(folder))
        print(photograph(Path(folder), target))


if __name__ == "__main__":
    main(sys.argv[1:])
