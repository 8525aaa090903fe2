"""`python -m tools.blender_extension -o DIR`: writes the Blender extension as mrm-blender-<version>.zip."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from mrm_mtlx.system.versions import __version__
from mrm_mtlx.system.writing import replacing
from tools.blender_extension.archive import archive
from tools.blender_extension.contents import contents
from tools.blender_extension.previews import draw_previews


def main(arguments: list[str]) -> int:
    """Run the command; 2 if the zip cannot be written."""
    parser = argparse.ArgumentParser(prog="python -m tools.blender_extension", description=__doc__)
    wanted = parser.add_mutually_exclusive_group(required=True)
    wanted.add_argument("-o", "--output", type=Path, metavar="DIR", help="write the zip into this folder")
    wanted.add_argument(
        "--previews", action="store_true", help="draw the asset browser's pictures into the sources anew"
    )
    options = parser.parse_args(arguments)
    if options.previews:
        draw_previews()
        return 0
    try:
        options.output.mkdir(parents=True, exist_ok=True)
        path = options.output / f"mrm-blender-{__version__}.zip"
        with replacing(path) as unfinished:
            unfinished.write_bytes(archive(contents()))
    except OSError as error:
        print(f"{options.output}: {error.strerror}", file=sys.stderr)
        return 2
    print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
