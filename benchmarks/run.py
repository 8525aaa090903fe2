"""Benchmarks, which print tables; no test depends on them.

`python benchmarks/run.py [oracle|mitsuba|surface|tolerance|gl|validate|usd]...`
"""

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


def best_time(function, repeats: int = REPEATS, clock=time.perf_counter) -> float:
    """Shortest of several times in seconds, by the wall's clock or another."""
    times = []
    for _ in range(repeats):
        start = clock()
        function()
        times.append(clock() - start)
    return min(times)


GOLD = {"ior": (0.183, 0.421, 1.373), "extinction": (3.424, 2.346, 1.770)}
COUNT = 1 << 20
COLUMNS = ("eval", "pdf", "sample")


def directions() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Directions v and l over the upper hemisphere, and random numbers."""
    rng = np.random.default_rng(0)
    v, l = (np.abs(rng.normal(size=(COUNT, 3))) for _ in range(2))
    v, l = (a / np.linalg.norm(a, axis=1, keepdims=True) for a in (v, l))
    return v, l, rng.uniform(size=(COUNT, 3))


def rates(functions) -> str:
    """Millions per second of each function, in columns."""
    return "  ".join(f"{COUNT / best_time(function) / 1e6:7.2f}" for function in functions)


def lobe_functions(lobe, v, l, u) -> tuple:
    """What is timed of a lobe."""
    return lambda: lobe.eval(v, l), lambda: lobe.pdf(v, l), lambda: lobe.sample(v, u)


def heading(title: str) -> str:
    return f"{title:44}{'  '.join(f'{name:>7}' for name in COLUMNS)}   [M/s]"


def oracle() -> None:
    """Values, densities and samples per second of the lobes, float64."""
    from mrm_mtlx import bsdf
    from mrm_mtlx.bsdf import blocks
    from mrm_mtlx.reference import versions

    v, l, u = directions()
    gold = {**GOLD, "alpha": (0.1, 0.2), "retroreflective": True}
    interface = {"alpha": (0.1, 0.2), "retroreflective": True}
    conductor = bsdf.Conductor(**gold)
    lobes = {
        "conductor": conductor,
        "conductor, energy compensation": bsdf.Conductor(
            **gold, energy_compensation=versions.installed().microfacet_albedo.white
        ),
        "conductor, thin film": bsdf.Conductor(**gold, thinfilm_thickness=400.0),
        "conductor, V-cavities": bsdf.Conductor(**gold, masking="v_cavity"),
        "conductor, Beckmann": bsdf.Conductor(**gold, distribution="beckmann"),
        "conductor, Phong": bsdf.Conductor(**gold, distribution="phong"),
        "dielectric": bsdf.Dielectric(1.5, **interface),
        "dielectric, transmission": bsdf.Dielectric(1.5, **interface, scatter_mode="T"),
        "dielectric, both": bsdf.Dielectric(1.5, **interface, scatter_mode="RT"),
        "generalised Schlick": bsdf.GeneralizedSchlick(0.2, **interface),
        "conductor, half retroreflective": bsdf.partially_retroreflective(conductor, 0.5),
    }
    print(f"oracle: {COUNT} samples in float64, {blocks.processors()} processors, best of {REPEATS}")
    print(heading(""))
    for name, lobe in lobes.items():
        print(f"  {name:42}{rates(lobe_functions(lobe, v, l, u))}", flush=True)
    chosen = blocks.BLOCK
    sizes = []
    for exponent in range(10, 19, 2):
        blocks.BLOCK = 1 << exponent
        sizes.append(f"2^{exponent}: {rates([lambda: conductor.eval(v, l)]).strip()}")
    blocks.BLOCK = chosen
    print(f"  conductor, eval by block size [M/s]       {', '.join(sizes)}")


# Mitsuba's descriptions beside the lobes of the same facets.
FACETS = {"alpha": (0.1, 0.2), "masking": "smith_separable"}
IN_MITSUBA = {
    "conductor": {
        "type": "roughconductor",
        "eta": {"type": "rgb", "value": GOLD["ior"]},
        "k": {"type": "rgb", "value": GOLD["extinction"]},
    },
    "dielectric": {"type": "roughdielectric", "int_ior": 1.5, "ext_ior": 1.0},
}


def directions_for(kind: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `directions`; for an interface, half of l below."""
    v, l, u = directions()
    if kind == "dielectric":
        l[::2, 2] *= -1.0
    return v, l, u


def mitsuba() -> None:
    """The same lobes here and in Mitsuba 3, whose kernels LLVM compiles."""
    from mrm_mtlx import bsdf
    from mrm_mtlx.bsdf import blocks

    print(f"mitsuba: {COUNT} samples, separable Smith masking, {blocks.processors()} processors, best of {REPEATS}")
    print(heading(""))
    for distribution in ("ggx", "beckmann"):
        facets = {**FACETS, "distribution": distribution}
        lobes = {
            "conductor": bsdf.Conductor(**GOLD, **facets),
            "dielectric": bsdf.Dielectric(1.5, **facets, scatter_mode="RT"),
        }
        for kind, lobe in lobes.items():
            here = rates(lobe_functions(lobe, *directions_for(kind)))
            print(f"  {f'{kind}, {distribution}: here, float64':42}{here}", flush=True)
            print(mitsuba_in_a_process(kind, distribution), flush=True)


def mitsuba_in_a_process(kind: str, distribution: str) -> str:
    """Mitsuba's lines of the table, or why there are none. An LLVM that is too old for it ends the process."""
    code = f"import sys; sys.path[:0] = ['benchmarks']; import run; run.time_mitsuba({kind!r}, {distribution!r})"
    home = tempfile.mkdtemp()  # where compiled kernels are kept
    environment = {**os.environ, "HOME": home}
    try:
        run = subprocess.run(
            [sys.executable, "-c", code], cwd=REPOSITORY, env=environment, capture_output=True, text=True, check=False
        )
    finally:
        shutil.rmtree(home)
    if run.returncode:
        lines = [line for line in run.stderr.splitlines() if "error" in line.lower()] or [f"status {run.returncode}"]
        return f"  Mitsuba's LLVM variant does not run here: {lines[0]} (DRJIT_LIBLLVM_PATH names another LLVM)"
    return run.stdout.rstrip()


def time_mitsuba(kind: str, distribution: str) -> None:
    """Print the figures of this process: Mitsuba's, directions and random numbers being in its arrays."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    v, l, u = (mi.Vector3f(a.T.astype(np.float32)) for a in directions_for(kind))
    bsdf = mi.load_dict(
        {**IN_MITSUBA[kind], "distribution": distribution, "alpha_u": FACETS["alpha"][0], "alpha_v": FACETS["alpha"][1]}
    )
    context, at = mi.BSDFContext(), dr.zeros(mi.SurfaceInteraction3f, COUNT)
    at.wi = v
    dr.eval(at, l, u)
    dr.sync_thread()

    def timed(function):
        def run() -> None:  # Mitsuba records operations; they run when their result is asked for
            dr.eval(function())
            dr.sync_thread()

        return run

    functions = (
        timed(lambda: bsdf.eval(context, at, l)),
        timed(lambda: bsdf.pdf(context, at, l)),
        timed(lambda: bsdf.sample(context, at, u.z, mi.Point2f(u.x, u.y))[0].wo),
    )
    first = "  ".join(f"{best_time(function, 1):7.2f}" for function in functions)
    print(f"  {'  Mitsuba, float32':42}{rates(functions)}")
    print(f"  {'  its first call, with compilation [s]':42}{first}")


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


# As many lobes of the other large model, and a metal alone.
STANDARD = """<?xml version="1.0"?>
<materialx version="1.39">
  <standard_surface name="s" type="surfaceshader">
    <input name="diffuse_roughness" type="float" value="0.4"/>
    <input name="metalness" type="float" value="0.3"/>
    <input name="specular_anisotropy" type="float" value="0.5"/>
    <input name="transmission" type="float" value="0.2"/>
    <input name="subsurface" type="float" value="0.3"/>
    <input name="sheen" type="float" value="0.4"/>
    <input name="coat" type="float" value="0.7"/>
    <input name="thin_film_thickness" type="float" value="500"/>
    <input name="emission" type="float" value="1"/>
  </standard_surface>
</materialx>
"""
METAL = """<?xml version="1.0"?>
<materialx version="1.39">
  <conductor_bsdf name="c" type="BSDF"><input name="roughness" type="vector2" value="0.1, 0.1"/></conductor_bsdf>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="c"/></surface>
</materialx>
"""


def tolerance() -> None:
    """Processor seconds for the tolerances of surfaces, as a validation asks for them."""
    import MaterialX as mx

    from mrm_mtlx.library import load_library
    from mrm_mtlx.reference import Environment, Illumination, Surface
    from mrm_mtlx.validation import sampling

    lit, few = 16384, 1024
    rng = np.random.default_rng(0)
    points = sampling.shading_points(rng, *sampling.sample_local(rng, lit))
    around = Illumination(light=False, environment=Environment.constant((1.0, 0.75, 0.5), samples=16))
    print(f"tolerances: {lit} samples under a light, {few} in surroundings by 16 directions, best of {REPEATS}")
    for name, text in {"open_pbr_surface": OPEN_PBR, "standard_surface": STANDARD, "conductor_bsdf": METAL}.items():
        document = mx.createDocument()
        mx.readFromXmlString(document, text)
        document.setDataLibrary(load_library().document)
        model = Surface(document.getNode("s"))
        part = points.part(slice(0, few))
        times = (
            best_time(lambda m=model: m.shade(points), clock=time.process_time),
            best_time(lambda m=model: m.tolerance(points), clock=time.process_time),
            best_time(lambda m=model, p=part: m.tolerance(p, around), clock=time.process_time),
        )
        print("  {:20} evaluated {:.3f} s, tolerance {:.3f} s, in surroundings {:.3f} s".format(name, *times))


def gl() -> None:
    """Samples per second through the OpenGL engine."""
    from mrm_mtlx.conformance import cases
    from mrm_mtlx.engines import gl as engine
    from mrm_mtlx.library import load_library
    from mrm_mtlx.shadergen import generate, renderable_elements
    from mrm_mtlx.validation import sampling
    from mrm_mtlx.validation.comparison import draw

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


PRIMS = 10_000
MATERIALS = 20
_MATERIAL = """def Material "M{0}" {{
    token outputs:mtlx:surface.connect = </W/M{0}/s.outputs:out>
    def Shader "s" {{
        uniform token info:id = "ND_surface"
        token inputs:bsdf.connect = </W/M{0}/c.outputs:out>
    }}
    def Shader "c" {{
        uniform token info:id = "ND_conductor_bsdf"
        float2 inputs:roughness = (0.1, 0.{0:02})
    }}
}}
"""
_MESH = """def Mesh "m{0}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    rel material:binding = </W/M{1}>
}}
"""


def usd() -> None:
    """Reading the materials of a stage of many prims: safe opening, translation, USD's own validators."""
    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.formats.reading import read_document
    from mrm_mtlx.library import load_library

    materials = "".join(_MATERIAL.format(k) for k in range(MATERIALS))
    meshes = "".join(_MESH.format(k, k % MATERIALS) for k in range(PRIMS))
    head = '#usda 1.0\n(\n defaultPrim = "W"\n metersPerUnit = 1\n upAxis = "Y"\n)\n'
    library = load_library()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "stage.usda")
        path.write_text(f'{head}def Xform "W" {{\n{materials}{meshes}}}\n', encoding="utf-8")
        remarks = read_document(path, Reach.beside(path), library, path.parent).findings
        taken = best_time(lambda: read_document(path, Reach.beside(path), library, path.parent), 3)
    print(f"reading {MATERIALS} materials of a stage of {PRIMS} prims: {taken:.2f} s, {len(remarks)} remarks")


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


BENCHMARKS = {
    "oracle": oracle,
    "mitsuba": mitsuba,
    "surface": surface,
    "tolerance": tolerance,
    "gl": gl,
    "validate": validate,
    "usd": usd,
}

if __name__ == "__main__":
    if sys.argv[1:] == ["floor"]:
        floor()
    else:
        for name in sys.argv[1:] or BENCHMARKS:
            BENCHMARKS[name]()
