"""A program for an interpreter that has Blender as a module: draws a stage with Storm, as the stage's camera sees it.

python draw_in_host.py storm_server.py stage.usda picture.png
"""

import sys
from importlib import import_module
from pathlib import Path

import bpy

WIDTH = 640


def main(server: str, stage: str, picture: str) -> None:
    """Draw the stage."""
    bpy.utils.expose_bundled_modules()
    sys.path.insert(0, str(Path(server).parent))
    import_module(Path(server).stem).make_current()
    from pxr import Tf, Usd, UsdAppUtils, UsdGeom

    opened = Usd.Stage.Open(stage)
    recorder = UsdAppUtils.FrameRecorder("HdStormRendererPlugin")
    recorder.SetCameraLightEnabled(False)
    recorder.SetColorCorrectionMode("sRGB")
    recorder.SetComplexity(1.3)
    recorder.SetImageWidth(WIDTH)
    try:
        recorder.Record(opened, UsdGeom.Camera.Get(opened, "/camera"), Usd.TimeCode.Default(), picture)
    except Tf.ErrorException as error:  # Storm of OpenUSD 25.02 complains of a type of value, and draws
        print(error, file=sys.stderr)


if __name__ == "__main__":
    main(*sys.argv[1:])
