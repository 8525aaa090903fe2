"""What the render engines need of a scene before they show the materials."""

import bpy


def prepare(scene):
    """Set up a scene for Cycles and Hydra Storm; sentences that say what has been changed."""
    changed = []
    cycles = getattr(scene, "cycles", None)
    if cycles is not None and not cycles.shading_system:
        cycles.shading_system = True
        changed.append("Open Shading Language is now on in Cycles")
    hydra = getattr(scene, "hydra", None)
    if hydra is not None and hydra.export_method != "USD":
        hydra.export_method = "USD"
        changed.append("Hydra now exports by USD")
    return changed


def lacks(scene, mode):
    """Sentences that say why the scene's engine does not show a material as it is."""
    engine = scene.render.engine
    if engine == "CYCLES":
        if not scene.cycles.shading_system:
            return ["Turn on Open Shading Language"]
        if scene.cycles.device == "GPU":
            return ["Exact mode runs on the CPU alone" if mode == "cycles" else "On GPUs, OSL runs with OptiX alone"]
        return []
    if engine == "HYDRA_STORM":
        if not hasattr(bpy.types, "USDHook"):
            return ["This Blender has no USD"]
        return [] if scene.hydra.export_method == "USD" else ["Set Hydra's export method to USD"]
    return ["This engine shows the colour by day alone;", "Cycles and Hydra Storm retroreflect"]
