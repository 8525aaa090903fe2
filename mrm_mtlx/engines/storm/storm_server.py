"""Draws materials with OpenUSD's Storm: the operations of `blender_server` for the Storm engine.

Not part of the import package: the interpreter that has `bpy` runs it, and nothing imports it. Blender's module has
OpenUSD with its renderer, and MaterialX, by which Storm generates its shaders. There is no window: Storm draws into
buffers of its own and wants nothing but an OpenGL context that is current.
"""

import ctypes
import os
import resource
from pathlib import Path

import bpy
import numpy as np

# Numbers of EGL 1.5 and its extensions.
PLATFORM_SURFACELESS = 0x31DD
OPENGL_API = 0x30A2
SURFACE_TYPE, PBUFFER_BIT, RENDERABLE_TYPE, OPENGL_BIT = 0x3033, 0x0001, 0x3040, 0x0008
WIDTH, HEIGHT, NONE = 0x3057, 0x3056, 0x3038
MAJOR, MINOR, PROFILE, COMPATIBILITY = 0x3098, 0x30FB, 0x30FD, 2
GL_RENDERER = 0x1F01

# Angle of a distant light [degrees]: one of 0 is black. Storm shades by its direction alone, so that it blurs nothing.
SUN_DEGREES = 0.5


def make_current():
    """Make an OpenGL context current, without a display; the name of what draws.

    A compatibility profile and a surface: Storm uses calls that a core profile refuses, and the framebuffer of the
    context, which one without a surface does not have.
    """
    try:
        egl, gl = ctypes.CDLL("libEGL.so.1"), ctypes.CDLL("libGL.so.1")
    except OSError as error:
        raise RuntimeError(f"no EGL: {error}") from error
    pointer, integer = ctypes.c_void_p, ctypes.c_int

    def call(name, result, *arguments):
        function = getattr(egl, name)
        function.restype, function.argtypes = result, [kind for kind, _ in arguments]
        found = function(*(value for _, value in arguments))
        if not found:
            raise RuntimeError(f"{name} failed with {egl.eglGetError():#x}")
        return found

    def list_of(*numbers):
        return pointer, ctypes.cast((integer * (len(numbers) + 1))(*numbers, NONE), pointer)

    def no_display():
        address = call("eglGetProcAddress", pointer, (ctypes.c_char_p, b"eglGetPlatformDisplayEXT"))
        get = ctypes.CFUNCTYPE(pointer, ctypes.c_uint, pointer, pointer)(address)
        return get(PLATFORM_SURFACELESS, None, None)

    def any_display():
        return call("eglGetDisplay", pointer, (pointer, None))

    for display_of in (no_display, any_display):
        try:
            display = pointer, display_of()
            call("eglInitialize", integer, display, (pointer, None), (pointer, None))
            break
        except RuntimeError as error:
            refused = error
    else:
        raise refused
    call("eglBindAPI", integer, (ctypes.c_uint, OPENGL_API))
    config, count = pointer(), integer()
    wanted = list_of(SURFACE_TYPE, PBUFFER_BIT, RENDERABLE_TYPE, OPENGL_BIT)
    places = [(pointer, ctypes.addressof(config)), (integer, 1), (pointer, ctypes.addressof(count))]
    call("eglChooseConfig", integer, display, wanted, *places)
    if not count.value:
        raise RuntimeError("EGL has no configuration for OpenGL with a surface of its own")
    chosen = pointer, config.value
    version = list_of(MAJOR, 4, MINOR, 5, PROFILE, COMPATIBILITY)
    context = pointer, call("eglCreateContext", pointer, display, chosen, (pointer, None), version)
    surface = pointer, call("eglCreatePbufferSurface", pointer, display, chosen, list_of(WIDTH, 16, HEIGHT, 16))
    call("eglMakeCurrent", integer, display, surface, surface, context)
    gl.glGetString.restype = ctypes.c_char_p
    return gl.glGetString(GL_RENDERER).decode()


class Storm:
    """The one stage that is drawn, and what draws it: made once, for its compiled shaders are kept with it."""

    def __init__(self):
        from pxr import Usd, UsdAppUtils, UsdGeom

        self.stage = Usd.Stage.CreateInMemory()
        UsdGeom.SetStageUpAxis(self.stage, UsdGeom.Tokens.y)
        UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)
        self.recorder = UsdAppUtils.FrameRecorder("HdStormRendererPlugin")
        self.recorder.SetCameraLightEnabled(False)
        self.recorder.SetColorCorrectionMode("disabled")
        self.recorder.SetComplexity(1.0)
        self.material = None

    def draw(self, arrays, take):
        """Draw the mesh of `arrays`, see `render`."""
        from pxr import Usd, UsdShade

        for name in ("mesh", "camera", "lights"):
            self.stage.RemovePrim(f"/{name}")
        mesh = self._add_mesh(arrays)
        if not take.get("bare"):
            UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(UsdShade.Material.Get(self.stage, "/material"))
        for number, light in enumerate(take["lights"]):
            self._add_light(f"/lights/light_{number}", light)
        self.recorder.SetImageWidth(take["camera"]["resolution"][0])
        self.recorder.Record(self.stage, self._add_camera(take["camera"]), Usd.TimeCode.Default(), take["output"])

    def take(self, path, values):
        """Take the material of a layer, its default prim's only child, with [path below it, type, value] of inputs."""
        from pxr import Sdf

        if (path, values) == self.material:
            return
        self.material = path, values
        self.stage.RemovePrim("/material")
        layer = Sdf.Layer.FindOrOpen(path)
        (name,) = [each.name for each in layer.GetPrimAtPath(f"/{layer.defaultPrim}").nameChildren]
        self.stage.DefinePrim("/material").GetReferences().AddReference(path, f"/{layer.defaultPrim}/{name}")
        for place, kind, value in values:
            prim, _, name = f"/material/{place}".rpartition(".")
            attribute = self.stage.GetPrimAtPath(prim).CreateAttribute(name, Sdf.ValueTypeNames.Find(kind))
            attribute.Set(
                Sdf.AssetPath(value) if kind == "asset" else tuple(value) if isinstance(value, list) else value
            )

    def forget(self):
        """Drop the material: one that was refused is to be refused again, and not drawn as something else."""
        for name in ("mesh", "material"):
            self.stage.RemovePrim(f"/{name}")
        self.material = None

    def _add_mesh(self, arrays):
        """A mesh, see `render`."""
        from pxr import Sdf, UsdGeom, Vt

        faces = arrays["faces"]
        mesh = UsdGeom.Mesh.Define(self.stage, "/mesh")
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(arrays["points"], np.float32)))
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(faces), faces.shape[1], np.int32)))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(faces, np.int32).ravel()))
        primvars = UsdGeom.PrimvarsAPI(mesh)
        vectors = {1: Vt.FloatArray, 2: Vt.Vec2fArray, 3: Vt.Vec3fArray, 4: Vt.Vec4fArray}
        types = {1: "FloatArray", 2: "Float2Array", 3: "Float3Array", 4: "Float4Array"}
        for name, values in arrays.items():
            kind, _, own = name.partition(":")
            if kind == "normals":
                normals = np.ascontiguousarray(values.reshape(-1, 3), np.float32)
                mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals))
                mesh.SetNormalsInterpolation("faceVarying")
            elif kind == "st":
                st = primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
                st.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(values.reshape(-1, 2), np.float32)))
            elif kind == "property":
                size = 1 if values.ndim == 1 else values.shape[1]
                whole = values.dtype.kind == "i"
                sdf = "IntArray" if whole else types[size]
                array = Vt.IntArray if whole else vectors[size]
                data = np.ascontiguousarray(values, np.int32 if whole else np.float32)
                primvar = primvars.CreatePrimvar(own, getattr(Sdf.ValueTypeNames, sdf), "uniform")
                primvar.Set(array.FromNumpy(data))
        return mesh

    def _add_camera(self, camera):
        """A camera looking along -z of "matrix", given as rows: "window" is what it sees in the plane at z = -1."""
        from pxr import Gf, UsdGeom

        added = UsdGeom.Camera.Define(self.stage, "/camera")
        left, right, bottom, top = camera["window"]
        focal = 8.0  # its products with float32 are exact
        added.CreateFocalLengthAttr(focal)
        added.CreateHorizontalApertureAttr(focal * (right - left))
        added.CreateVerticalApertureAttr(focal * (top - bottom))
        added.CreateHorizontalApertureOffsetAttr(focal * (left + right) / 2.0)
        added.CreateVerticalApertureOffsetAttr(focal * (bottom + top) / 2.0)
        added.CreateClippingRangeAttr(Gf.Vec2f(*camera["clip"]))
        place(added, camera["matrix"])
        return added

    def _add_light(self, path, light):
        """A sun with an "irradiance", a point with an "intensity", or a dome of an "image"."""
        from pxr import Sdf, UsdLux

        if "image" in light:
            dome = UsdLux.DomeLight.Define(self.stage, path)
            dome.CreateTextureFileAttr(Sdf.AssetPath(light["image"]))
            dome.CreateTextureFormatAttr("latlong")
            place(dome, light["matrix"])
        elif "irradiance" in light:
            sun = UsdLux.DistantLight.Define(self.stage, path)
            sun.CreateAngleAttr(SUN_DEGREES)
            sun.CreateNormalizeAttr(True)
            sun.CreateIntensityAttr(light["irradiance"])
            sun.CreateColorAttr(tuple(light["colour"]))
            place(sun, light["matrix"])
        else:
            point = UsdLux.SphereLight.Define(self.stage, path)
            point.CreateTreatAsPointAttr(True)
            point.CreateNormalizeAttr(True)
            point.CreateIntensityAttr(light["intensity"])
            place(point, light["matrix"])


STATE, CONTEXT = [], []


def storm():
    """The renderer, made at the first use of USD: variables that it reads are set, and the node library lies there."""
    if not CONTEXT:
        raise RuntimeError("there is no OpenGL context")
    if not STATE:
        STATE.append(Storm())
    return STATE[0]


def place(schema, matrix):
    """Set an object's matrix, given as rows: USD multiplies by rows of vectors."""
    from pxr import Gf, UsdGeom

    UsdGeom.Xformable(schema).AddTransformOp().Set(Gf.Matrix4d(np.asarray(matrix, dtype=float).T.tolist()))


def versions():
    """Versions of what there is, where MaterialX's standard library lies, what is lacking, and this process's id."""
    from MaterialX import getVersionString
    from pxr import Usd

    found = {"blender": bpy.app.version_string, "usd": ".".join(f"{n:02}" for n in Usd.GetVersion()[1:])}
    libraries = str(Path(bpy.utils.resource_path("LOCAL")).parent / "lib" / "materialx" / "libraries")
    found |= {"materialx": getVersionString(), "libraries": libraries, "renderer": "", "lacking": ""}
    try:
        if not CONTEXT:
            CONTEXT.append(make_current())
        found["renderer"] = CONTEXT[0]
    except RuntimeError as error:
        found["lacking"] = str(error)
    return {**found, "pid": os.getpid()}


def render(arrays, material, values, takes):
    """Draw a material once for each take, which has its "camera", "lights", "output" and "mesh".

    The arrays of a mesh begin with its name and a slash: "points" (n, 3), "faces" (m, corners), "normals" (m, corners,
    3), "st" (m, corners, 2), and those named "property:NAME", (m,) or (m, components), which are constant on each face.
    A take that is "bare" is of the mesh without the material. The answer has the errors of USD, file and message, and
    the memory that was taken.
    """
    from pxr import Tf

    renderer, errors = storm(), []
    try:
        renderer.take(material, values)
    except Tf.ErrorException as error:
        errors += error.args
    for take in takes:
        start = f"{take['mesh']}/"
        own = {name.removeprefix(start): array for name, array in arrays.items() if name.startswith(start)}
        try:
            renderer.draw(own, take)
        except Tf.ErrorException as error:  # it may have drawn none the less
            errors += error.args
    if errors:
        renderer.forget()
    return {"errors": [[each.sourceFileName, each.commentary] for each in errors], "memory": memory()}


def memory():
    """The most memory that this process has taken [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


OPERATIONS = {"versions": versions, "render": render}
