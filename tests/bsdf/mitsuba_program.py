"""Evaluates and samples BSDFs with Mitsuba 3: `python mitsuba_program.py REQUEST.npz ANSWER.npz`.

A program of its own: Mitsuba starts threads, which the worker processes of other tests must not inherit. It ends with
status 3 and a line that says why where Mitsuba cannot be loaded.

The request has `bsdfs`, a JSON list of Mitsuba's plugin dictionaries, and for the k-th of them `v<k>`, `l<k>` and
random numbers `u<k>`, float32 (n, 3). The answer has `eval<k>` (n, 3), `pdf<k>` (n,), and of samples for v and u
`sample<k>` (n, 3), `weight<k>` (n, 3) and `sampled_pdf<k>` (n,); all three are zero where there is no sample.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

NO_RUNTIME = 3


def answer_one(mi: Any, bsdf: Any, v: np.ndarray, l: np.ndarray, u: np.ndarray) -> dict[str, np.ndarray]:
    """Values (with the cosine of l), densities and samples. Mitsuba's `wi` is our v, its `wo` our l."""
    context, at = mi.BSDFContext(mi.TransportMode.Radiance), mi.SurfaceInteraction3f()
    shapes = {"eval": (3,), "pdf": (), "sample": (3,), "weight": (3,), "sampled_pdf": ()}
    found = {name: np.zeros((len(v), *shape)) for name, shape in shapes.items()}
    for k, (to_viewer, to_light, number) in enumerate(zip(v, l, u, strict=True)):
        at.wi = mi.Vector3f(to_viewer)
        wo = mi.Vector3f(to_light)
        found["eval"][k], found["pdf"][k] = bsdf.eval(context, at, wo), bsdf.pdf(context, at, wo)
        sample, weight = bsdf.sample(context, at, number[2], mi.Point2f(number[:2]))
        if np.any(np.asarray(weight) > 0.0):
            found["sample"][k], found["weight"][k], found["sampled_pdf"][k] = sample.wo, weight, sample.pdf
    return found


def main(request: str, answer: str) -> int:
    """Answer a request; returns the exit status."""
    try:
        import mitsuba as mi

        mi.set_variant("scalar_rgb")  # the one that needs nothing but the wheel
    except ImportError as error:
        print(f"Mitsuba cannot be loaded: {error}", file=sys.stderr)
        return NO_RUNTIME
    found: dict[str, np.ndarray] = {}
    with np.load(request) as asked:
        for k, description in enumerate(json.loads(str(asked["bsdfs"]))):
            arrays = (asked[f"{name}{k}"] for name in "vlu")
            one = answer_one(mi, mi.load_dict(description), *arrays)
            found |= {f"{name}{k}": value for name, value in one.items()}
    np.savez(answer, **found)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
