"""A program for the interpreter of a host: prints what its USD knows of definitions, as JSON on a line of its own.

    python host_question.py ND_conductor_bsdf ...
    python host_question.py bpy ND_conductor_bsdf ...
    blender --background --factory-startup --python host_question.py -- bpy ND_conductor_bsdf ...

With `bpy` it asks the OpenUSD that is part of Blender, else that of the interpreter.

It imports nothing of this package, which the host does not have.
"""

import json
import sys

MARK = "mrm-host-answer "


def main(in_blender: bool, names: list[str]) -> None:
    """Print the answer, or what went wrong."""
    try:
        if in_blender:
            import bpy

            bpy.utils.expose_bundled_modules()
        from pxr import Sdr, Usd
    except ImportError as error:
        print(MARK + json.dumps({"error": str(error)}), flush=True)
        return
    registry = Sdr.Registry()
    # Names before and after OpenUSD 25.05.
    find = getattr(registry, "GetShaderNodeByIdentifier", None) or registry.GetNodeByIdentifier
    definitions = {}
    for name in names:
        node = find(name)
        if node:
            inputs = getattr(node, "GetShaderInputNames", None) or node.GetInputNames
            definitions[name] = {"file": node.GetResolvedDefinitionURI(), "inputs": list(inputs())}
    year, month = Usd.GetVersion()[1:]
    answer = {"usd": f"{year}.{month:02d}", "definitions": definitions}
    print("\n" + MARK + json.dumps(answer), flush=True)


if __name__ == "__main__":
    main("bpy" in sys.argv[1:], [argument for argument in sys.argv[1:] if argument.startswith("ND_")])
