"""Benchmarks: `python benchmarks/run.py [oracle|surface|gl|validate]...`. Prints tables; no test depends on them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).parents[1]
# Documents of MaterialX's own suites, where a checkout has them beside it; the ready materials otherwise.
CORPUS = next(p for p in (REPOSITORY.parent / "shared" / "corpus", REPOSITORY / "materials") if p.is_dir())
REPEATS = 5


def best_time(function, repeats: int = REPEATS) -> float:
    """Shortest of several wall-clock times in seconds."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def oracle() -> None:
    """Evaluations per second of the oracle, float64."""
    from mrm_mtlx import bsdf
    from mrm_mtlx.bsdf import blocks

    rng = np.random.default_rng(0)
    count = 1 << 20
    v, l = (np.abs(rng.normal(size=(count, 3))) for _ in range(2))
    v, l = (a / np.linalg.norm(a, axis=1, keepdims=True) for a in (v, l))
    gold = {"ior": (0.183, 0.421, 1.373), "extinction": (3.424, 2.346, 1.770), "alpha": (0.1, 0.2)}
    lobes = {
        "conductor": bsdf.Conductor(**gold, retroreflective=True),
        "conductor, energy compensation": bsdf.Conductor(**gold, retroreflective=True, energy_compensation=True),
        "conductor, thin film": bsdf.Conductor(**gold, retroreflective=True, thinfilm_thickness=400.0),
        "dielectric": bsdf.Dielectric(1.5, alpha=(0.1, 0.2), retroreflective=True),
        "generalised Schlick": bsdf.GeneralizedSchlick(0.2, alpha=(0.1, 0.2), retroreflective=True),
    }
    print(f"oracle: {count} evaluations in float64, {blocks.processors()} processors, best of {REPEATS}")
    for name, lobe in lobes.items():
        print(f"  {name:32} {count / best_time(lambda lobe=lobe: lobe.eval(v, l)) / 1e6:6.2f} M/s")
    chosen = blocks.BLOCK
    sizes = []
    for exponent in range(10, 19, 2):
        blocks.BLOCK = 1 << exponent
        rate = count / best_time(lambda: lobes["conductor"].eval(v, l)) / 1e6
        sizes.append(f"2^{exponent}: {rate:.1f}")
    blocks.BLOCK = chosen
    print(f"  conductor by block size [M/s]    {', '.join(sizes)}")


# Every lobe of the surface model in use.
OPEN_PBR = """<?xml version="1.0"?>
<materialx version="1.39">
  <open_pbr_surface name="s" type="surfaceshader">
    <input name="base_diffuse_roughness" type="float" value="0.4"/>
    <input name="base_metalness" type="float" value="0.3"/>
    <input name="specular_roughness_anisotropy" type="float" value="0.5"/>
    <input name="transmission_weight" type="float" value="0.2"/>
    <input name="subsurface_weight" type="float" value="0.3"/>
    <input name="coat_weight" type="float" value="0.7"/>
    <input name="fuzz_weight" type="float" value="0.4"/>
    <input name="thin_film_weight" type="float" value="0.5"/>
    <input name="emission_luminance" type="float" value="1"/>
  </open_pbr_surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
</materialx>
"""


def surface() -> None:
    """Seconds and memory that the reference takes for 100,000 samples of a whole surface model, on one processor."""
    for every in (False, True):
        code = f"import sys; sys.path[:0] = ['benchmarks']; import run; run.evaluate_surface({every})"
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        subprocess.run([sys.executable, "-c", code], check=True, cwd=REPOSITORY, env=environment)


def evaluate_surface(every_lobe: bool) -> None:
    """Print the figures of this process, which evaluates nothing else."""
    import resource

    import MaterialX as mx

    from mrm_mtlx.bsdf import blocks
    from mrm_mtlx.library import load_library
    from mrm_mtlx.reference import Surface
    from mrm_mtlx.validation import sampling

    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    count = 100_000
    text = OPEN_PBR if every_lobe else "".join(l for l in OPEN_PBR.splitlines() if "value=" not in l)
    document = mx.createDocument()
    mx.readFromXmlString(document, text)
    document.setDataLibrary(load_library().document)
    rng = np.random.default_rng(0)
    points = sampling.shading_points(rng, *sampling.sample_local(rng, count))
    model = Surface(document.getNode("m"))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    best = best_time(lambda: model.shade(points), 3)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    lobes = "every lobe on" if every_lobe else "as it is by default"
    print(
        f"surface: open_pbr_surface, {lobes}, {count} samples, {blocks.processors()} processor: {best:.2f} s, "
        f"{peak:.0f} MB in all ({before:.0f} MB before)"
    )


def gl() -> None:
    """Samples per second through the OpenGL engine."""
    from mrm_mtlx.engines import gl as engine
    from mrm_mtlx.library import load_library
    from mrm_mtlx.shadergen import generate, renderable_elements
    from mrm_mtlx.validation import sampling
    from mrm_mtlx.validation.comparison import draw
    from mrm_mtlx.validation.conformance import cases

    print(f"OpenGL engine: {engine.availability().detail}, best of {REPEATS}")
    library = load_library()
    for node in cases.NODES:
        case = cases.Case(node, True, True, False)
        document = cases.case_document(case, library.document)
        shader = generate(renderable_elements(document)[0], "glsl", library)
        rates = []
        with engine.SurfaceProgram(shader) as program:
            for count in (1 << 14, 1 << 18):
                points = cases.case_points(case, count, sampling.generator(0, case.name))
                draw(program, points)
                rates.append(f"{count}: {count / best_time(lambda p=points: draw(program, p)) / 1e6:.2f}")
        print(f"  {node:32} M samples/s at {', '.join(rates)}")


def validate() -> None:
    """A validation run over many documents, as a multiple of what generator and driver alone take."""
    print(
        f"validation of {CORPUS.name} ({len(list(CORPUS.rglob('*.mtlx')))} documents), driver cache empty in each run"
    )
    floor = _timed([sys.executable, __file__, "floor"])
    print(f"  generate, link, first draw      {floor:7.1f} s")
    for jobs in (1, 2):
        command = [sys.executable, "-m", "mrm_mtlx.cli.main", "validate", str(CORPUS), "-j", str(jobs)]
        taken = _timed([*command, "--format", "json", "--output", os.devnull])
        print(f"  mrm validate -j {jobs}               {taken:7.1f} s   {taken / floor:.2f} times")


def floor() -> None:
    """Generate, link and first draw the GLSL and ESSL of every renderable element, and nothing else."""
    import MaterialX as mx

    from mrm_mtlx.engines.gl import SurfaceProgram
    from mrm_mtlx.library import load_library
    from mrm_mtlx.shadergen import generate, renderable_elements
    from mrm_mtlx.validation import sampling
    from mrm_mtlx.validation.comparison import draw

    library = load_library()
    rng = np.random.default_rng(0)
    points = sampling.shading_points(rng, *sampling.sample_local(rng, 16384))
    for path in sorted(CORPUS.rglob("*.mtlx")):
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(path))
        document.setDataLibrary(library.document)
        for element in renderable_elements(document):
            for target in ("glsl", "essl"):
                with SurfaceProgram(generate(element, target, library)) as program:
                    draw(program, points)


def _timed(command: list[str]) -> float:
    """Wall-clock seconds of a command with a fresh, empty shader cache."""
    cache = tempfile.mkdtemp()
    try:
        environment = {**os.environ, "MESA_SHADER_CACHE_DIR": cache}
        start = time.perf_counter()
        subprocess.run(command, env=environment, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return time.perf_counter() - start
    finally:
        shutil.rmtree(cache)


BENCHMARKS = {"oracle": oracle, "surface": surface, "gl": gl, "validate": validate}

if __name__ == "__main__":
    if sys.argv[1:] == ["floor"]:
        floor()
    else:
        for name in sys.argv[1:] or BENCHMARKS:
            BENCHMARKS[name]()
