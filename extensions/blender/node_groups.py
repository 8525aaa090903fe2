"""The nodes of a material: a group with the material's own inputs, around a Script node for Cycles."""

import json

from .catalogue import ProblemError, find, script

# Custom properties of a group: the material that it is, the way in which its OSL retroreflects, and for each of its
# sockets the attribute of the USD network that it sets.
MATERIAL, MODE, SOCKETS = "mrm_material", "mrm_mode", "mrm_sockets"

# How OSL makes a retroreflective lobe: identifier, label, explanation, and number in the source.
MODES = (
    ("aligned", "Aligned", "A standard lobe turned toward the viewer: close, and for every device that runs OSL", 1),
    ("cycles", "Exact", "The surface is met again through a ray portal: exact, on the CPU alone; experimental", 2),
)
_KINDS = {
    "float": "NodeSocketFloat",
    "color": "NodeSocketColor",
    "vector": "NodeSocketVector",
    "boolean": "NodeSocketBool",
    "integer": "NodeSocketInt",
}
_BY_DAY = "By Day"
_ROUGHNESS_BY_DAY = 0.5


def make_material(data, name, mode="aligned"):
    """A new material in the data of a file (`bpy.data`, or temporary data)."""
    described = find(name)
    tree = ensure_group(data, name, mode)
    material = data.materials.new(described["label"])
    if material.node_tree is None:  # before Blender 5
        material.use_nodes = True
    material.diffuse_color = (*described["by_day"], 1.0)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    node = add_node(material.node_tree, tree)
    for target, output, height in (("CYCLES", "BSDF", 120), ("EEVEE", _BY_DAY, -80)):
        end = nodes.new("ShaderNodeOutputMaterial")
        end.target, end.location, end.label = target, (300, height), target.title() if target == "CYCLES" else target
        links.new(node.outputs[output], end.inputs["Surface"])
    return material


def add_node(owner, tree):
    """A node of a group in another tree."""
    node = owner.nodes.new("ShaderNodeGroup")
    node.node_tree, node.width, node.label = tree, 260, tree.name
    return node


def ensure_group(data, name, mode):
    """The group of a material: the one that the file has, or a new one."""
    described = find(name)
    for tree in data.node_groups:
        if tree.library is None and tree.get(MATERIAL) == name and tree.get(MODE) == mode:
            return tree
    tree = data.node_groups.new(described["label"], "ShaderNodeTree")
    try:
        _fill(data, tree, described, mode)
    except ProblemError:
        data.node_groups.remove(tree)
        raise
    return tree


def _fill(data, tree, described, mode):
    """Make the inside of a new group."""
    tree[MATERIAL], tree[MODE] = described["name"], mode
    tree.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    tree.interface.new_socket(_BY_DAY, in_out="OUTPUT", socket_type="NodeSocketShader")
    panels = {}
    made = [(socket, _interface_socket(tree, panels, socket)) for socket in described["sockets"]]
    tree[SOCKETS] = json.dumps(
        {
            item.identifier: {"attribute": socket["attribute"], "components": socket["components"]}
            for socket, item in made
        }
    )
    inputs, outputs = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    shader = _script_node(data, tree, described, mode)
    inputs.location, outputs.location = (-600, 0), (300, 0)
    given = {output.identifier: output for output in inputs.outputs}
    for socket, item in made:
        tree.links.new(given[item.identifier], _input(shader, socket["name"]))
    _link_geometry(tree, shader, described)
    tree.links.new(shader.outputs[0], outputs.inputs["BSDF"])
    by_day = tree.nodes.new("ShaderNodeBsdfPrincipled")
    by_day.inputs["Base Color"].default_value = (*described["by_day"], 1.0)
    by_day.inputs["Roughness"].default_value = _ROUGHNESS_BY_DAY
    by_day.location, by_day.label = (0, -500), "Colour by day, for EEVEE"
    tree.links.new(by_day.outputs["BSDF"], outputs.inputs[_BY_DAY])


def _interface_socket(tree, panels, socket):
    """A socket of a group, in the panel of its name."""
    panel = panels.get(socket["group"])
    if panel is None:
        panel = panels[socket["group"]] = tree.interface.new_panel(socket["group"])
    item = tree.interface.new_socket(
        socket["label"], description=socket["doc"], socket_type=_KINDS[socket["type"]], parent=panel
    )
    default = socket["default"]
    item.default_value = (*default, 1.0) if socket["type"] == "color" else default
    for bound, attribute in (("soft_minimum", "min_value"), ("soft_maximum", "max_value")):
        if socket[bound] is not None:
            setattr(item, attribute, type(item.min_value)(socket[bound]))
    return item


def _link_geometry(tree, shader, described):
    """Give a Script node what OSL in Cycles does not know by itself: texture coordinates, and the tangent along u."""
    if described["uv"]:
        tree.links.new(tree.nodes.new("ShaderNodeUVMap").outputs["UV"], _input(shader, described["uv"]))
    if described["tangent"]:
        tangent = tree.nodes.new("ShaderNodeTangent")
        tangent.direction_type = "UV_MAP"
        tree.links.new(tangent.outputs["Tangent"], _input(shader, described["tangent"]))


def _input(node, identifier):
    """The input of a Script node for a parameter of its shader, whose name may be another."""
    return next(socket for socket in node.inputs if socket.identifier == identifier)


def _script_node(data, tree, described, mode):
    """The Script node of a material, compiled."""
    try:  # of Blender itself; compiles also where Cycles is not the scene's engine
        from cycles.osl import update_script_node
    except ImportError:
        raise ProblemError("Cycles is not enabled: turn on 'Cycles Render Engine' in the add-on preferences") from None
    title = f"{described['name']}.{mode}.osl"
    text = data.texts.get(title)
    if text is None:
        number = next(number for identifier, *_, number in MODES if identifier == mode)
        text = data.texts.new(title)
        text.write(f"#define MRM_OSL_MODE {number}\n{script(described['name'])}")
    node = tree.nodes.new("ShaderNodeScript")
    node.mode, node.script, node.width, node.location = "INTERNAL", text, 260, (-100, 0)
    said = []
    update_script_node(node, lambda level, message: said.append((level, message)))
    problems = [message for level, message in said if "ERROR" in level]
    if problems or not node.outputs:
        raise ProblemError(f"Cycles did not compile the material's OSL: {'; '.join(problems) or 'it has no OSL'}")
    return node


def group_node(material):
    """The node of one of our groups that a material shows, or None."""
    tree = material.node_tree if material is not None else None
    if tree is None:
        return None
    shown = [link.from_node for link in tree.links if link.to_node.bl_idname == "ShaderNodeOutputMaterial"]
    groups = (node for node in shown if node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None)
    return next((node for node in groups if MATERIAL in node.node_tree), None)


def set_mode(data, node, mode):
    """Have the node of a group retroreflect in another way in OSL; its values stay."""
    values = [_plain(socket.default_value) for socket in node.inputs]
    node.node_tree = ensure_group(data, node.node_tree[MATERIAL], mode)
    for socket, value in zip(node.inputs, values, strict=True):
        socket.default_value = value


def changed_inputs(node):
    """What the sockets of a group's node say: (attribute of the network, its components, value)."""
    known = json.loads(node.node_tree[SOCKETS])
    for socket in node.inputs:
        if socket.identifier in known:
            place = known[socket.identifier]
            yield place["attribute"], place["components"], _plain(socket.default_value)


def _plain(value):
    return value if isinstance(value, bool | int | float) else tuple(value)
