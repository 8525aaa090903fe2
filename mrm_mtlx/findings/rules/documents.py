"""Documents: their structure, names, values and connections."""

from __future__ import annotations

from mrm_mtlx.findings.finding import Rule, Severity
from mrm_mtlx.system.limits import MAXIMUM_NODES

DOC_INVALID = Rule(
    "DOC_INVALID",
    Severity.ERROR,
    "not a valid MaterialX document",
    "MaterialX's own validation, or its reader, rejects the document.",
    "Correct what the message names; it is MaterialX's own.",
)

DOC_VERSION = Rule(
    "DOC_VERSION",
    Severity.WARNING,
    "document without a version",
    "The attribute `version` of the materialx element is required (MaterialX specification, section 'MTLX File "
    "Format Definition'). MaterialX takes a document without one for its newest version, and upgrades nothing "
    "of an earlier one.",
    "State the version of MaterialX that the document was written for, such as 1.39.",
)

DOC_DUPLICATE_NAME = Rule(
    "DOC_DUPLICATE_NAME",
    Severity.WARNING,
    "two elements share a name",
    "Names are unique among siblings. MaterialX keeps the first element of a name and drops the others without "
    "a message.",
    "Rename one of the two.",
)

DOC_UNKNOWN_NODE = Rule(
    "DOC_UNKNOWN_NODE",
    Severity.ERROR,
    "unknown node",
    "No node definition in the libraries or in the document has this node category with these types. "
    "MaterialX's own validation accepts such a document; generators then fail or leave the node out.",
    "Check the spelling of the category and the node's type; custom nodes need a nodedef in the document.",
)

DOC_DEFINITION = Rule(
    "DOC_DEFINITION",
    Severity.ERROR,
    "definition and implementation do not fit",
    "A node definition of the document has an output without a type; or the graph that implements a "
    "definition does not exist, or has other outputs. Their types have to agree, and of several outputs also "
    "the names (MaterialX specification, section 'Custom Node Definition Using Node Graphs'). A unit has a "
    "scale other than 0.",
    "Give definition and implementation the same outputs.",
)

DOC_UNKNOWN_INPUT = Rule(
    "DOC_UNKNOWN_INPUT",
    Severity.ERROR,
    "unknown input",
    "The node's definition has no input of this name, so that the whole node loses its definition.",
    "Use one of the definition's inputs.",
)

DOC_INPUT_TYPE = Rule(
    "DOC_INPUT_TYPE",
    Severity.ERROR,
    "wrong type",
    "The input's type is not that of the node's definition, so that the whole node loses its definition.",
    "Give the input the definition's type, and its value that form.",
)

DOC_INPUT_VALUE = Rule(
    "DOC_INPUT_VALUE",
    Severity.ERROR,
    "value cannot be parsed",
    "The value of an input, an interface, a default or a token is not of its type, or not one of the values "
    "that the definition enumerates. A boolean is exactly true or false; a vector has its number of "
    "components, separated by commas; a struct has its members in braces, separated by semicolons. MaterialX "
    "takes what it understands of a number and passes over the rest, so that 0,5 is 0 and the integer 1.5 is "
    "1. Closures, shaders and materials have no value: they are connected.",
    "Write the value in the form of its type.",
)

DOC_VALUE_FORM = Rule(
    "DOC_VALUE_FORM",
    Severity.WARNING,
    "value in no form of the specification",
    "The numbers of a colour, vector or matrix are separated by spaces. MaterialX takes them so; by its "
    "specification (section 'MaterialX Data Types') they are separated by commas, and other readers may refuse "
    "what is not.",
    "Put commas between the numbers.",
)

DOC_VALUE_RANGE = Rule(
    "DOC_VALUE_RANGE",
    Severity.WARNING,
    "value outside the definition's range",
    "The node's definition states a range (uimin, uimax) that the value leaves. Shaders clamp some of these "
    "values and not others, so that targets differ.",
    "Bring the value into the range.",
)

DOC_CONNECTION = Rule(
    "DOC_CONNECTION",
    Severity.ERROR,
    "connection leads nowhere or to another type",
    "The input or output names a node, an output or a graph that does not exist, or whose type is another; or "
    "it does not say which of several outputs it takes (MaterialX specification, section 'Inputs'). A look "
    "names a material, a group a look or a collection that does not exist.",
    "Correct the name, or convert the type with a node.",
)

DOC_OUTPUT_IGNORED = Rule(
    "DOC_OUTPUT_IGNORED",
    Severity.WARNING,
    "output is named of a node that has one",
    "A connection to a node with one output has the attribute `output`. The specification has it ignored, "
    "whatever it names (section 'Inputs'), and so do generators; MaterialX's own validation refuses the "
    "document, and so may programs that ask it first.",
    "Leave out the attribute `output`.",
)

DOC_UNIFORM_CONNECTED = Rule(
    "DOC_UNIFORM_CONNECTED",
    Severity.WARNING,
    "uniform input is connected to what may vary",
    "The definition declares the input uniform, so that renderers can compile for its value. It may be "
    "connected to a `constant` or to an output that is declared uniform, also through `dot` nodes, and to "
    "nothing else (MaterialX specification, section 'Inputs'). MaterialX's validation does not enforce it; "
    "GLSL happens to accept any connection, MDL and others do not.",
    "Give the input a value. For `retroreflective`, make two copies of the BSDF, one with true and one with "
    "false, and connect the texture to the `mix` input of a mix node over the two: that works on every target.",
)

DOC_VALUE_IGNORED = Rule(
    "DOC_VALUE_IGNORED",
    Severity.WARNING,
    "value has no effect",
    "The input falls back to geometry (its definition has a defaultgeomprop, such as the normal), and "
    "MaterialX's generators ignore a literal there: the shading normal is used all the same.",
    "Remove the value, or connect a node that gives it.",
)

DOC_COLOR_SPACE = Rule(
    "DOC_COLOR_SPACE",
    Severity.WARNING,
    "unknown colour space",
    "MaterialX has no transform from this colour space, so that its generators use the numbers as they are. It "
    "is told once for each space. Many names of OpenColorIO's built-in configurations, such as ACES2065-1, are "
    "unknown to MaterialX's default colour management; a host that has OpenColorIO may convert them.",
    "Use a colour space of MaterialX's library, such as srgb_texture, lin_rec709 or acescg.",
)

DOC_CYCLE = Rule(
    "DOC_CYCLE",
    Severity.ERROR,
    "graph is cyclic or too deep",
    "Nodes feed each other in a circle, or in a chain so long that generators, which work recursively, exhaust "
    "the stack.",
    "Break the circle at the connection that is named; merge long chains into node graphs.",
)

DOC_TOO_LARGE = Rule(
    "DOC_TOO_LARGE",
    Severity.ERROR,
    "definitions come to too many nodes",
    f"A surface comes to more than {MAXIMUM_NODES:,} nodes when each node that a graph defines is counted as "
    "the nodes of that graph. Definitions that use each other twice double that number with each of them: "
    "twenty come to a million. Shader compilers evaluate them all. Real surfaces have a few hundred.",
    "Use definitions less often inside of each other; compute once what is used several times.",
)

DOC_FILE = Rule(
    "DOC_FILE",
    Severity.ERROR,
    "file cannot be read",
    "An image or a shader source that the document refers to does not exist, or is not a file; a set of images "
    "(<UDIM> and the like) has no file; or OpenImageIO cannot read the image.",
    "Correct the file name; it is relative to the document's folder, or to one named by --root.",
)

DOC_NO_RENDERABLE = Rule(
    "DOC_NO_RENDERABLE",
    Severity.WARNING,
    "nothing to render",
    "The document has no material with a surface, and no output of a graph that can be shown: there is nothing "
    "to generate a shader from. Volumes, lights and displacements alone are not compared. A library of "
    "definitions is such a document; in USD, a stage none of whose Materials has a MaterialX network; in glTF, "
    "an asset without materials.",
    "Add a surfacematerial node with a surface shader; in USD, connect `outputs:mtlx:surface` of a Material; "
    "in glTF, add a material.",
)

DOC_NOT_COMPARED = Rule(
    "DOC_NOT_COMPARED",
    Severity.WARNING,
    "part of a material is not compared",
    "The material has a displacement, or another surface for its back. Generated shaders have neither: what is "
    "compared with the reference is its surface alone.",
    "Nothing is wrong with the document; check what is named in the renderer.",
)
