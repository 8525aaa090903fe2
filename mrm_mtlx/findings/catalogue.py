"""Every rule, in one list: `mrm rules` prints it, docs/rules.md is made of it, tests go through it."""

from __future__ import annotations

from mrm_mtlx.findings.finding import Rule, Severity
from mrm_mtlx.system.limits import MAXIMUM_DOCUMENT_BYTES, MAXIMUM_INCLUDES, MAXIMUM_NODES, MAXIMUM_XML_DEPTH

_ERROR, _WARNING = Severity.ERROR, Severity.WARNING

# Largest albedo that the check lets pass. MaterialX's energy compensation is a fit: an ideal white isotropic lobe comes
# out at up to 1.086 (alpha 0.0025 at 85 degrees; measured with validation.energy, alpha 0.0025 to 1, 0 to 88 degrees).
ALBEDO_BOUND = 1.10

# Up to this view angle [degrees], mean-width masking adds nothing: white lobes up to (0.9, 0.1) stay below 0.98 there.
STEEP_DEGREES = 30.0

# Below this width, the roundings of a half-vector (21 units of 2^-24, see reference.rounding) are a twentieth of the
# lobe's width, and move its flank by a tenth: 2 * 21 * 2^-24 / alpha = 0.1.
NARROWEST_ALPHA = 2.5e-5

RULES: dict[str, Rule] = {
    rule.code: rule
    for rule in (
        Rule(
            "READ_MISSING",
            _ERROR,
            "path does not exist",
            "A path on the command line names neither a file nor a folder.",
            "Check the spelling; paths are relative to the current folder.",
        ),
        Rule(
            "READ_FAILED",
            _ERROR,
            "file cannot be read",
            "The operating system refuses to read the file.",
            "Check the file's permissions, and that it is a file.",
        ),
        Rule(
            "READ_TOO_LARGE",
            _ERROR,
            "file is too large",
            f"The document, with what it includes, is larger than {MAXIMUM_DOCUMENT_BYTES // 2**20} MiB. A material is "
            "text of a few kilobytes; a file of this size is broken, or holds many materials that are better checked "
            "apart.",
            "Split the document; textures and geometry do not belong into it.",
        ),
        Rule(
            "READ_ENCODING",
            _ERROR,
            "file is not UTF-8",
            "MaterialX documents are UTF-8 (MaterialX specification, section 'MTLX File Format Definition'). Other "
            "encodings are read by some programs as garbled names.",
            "Save the file as UTF-8.",
        ),
        Rule(
            "READ_XML",
            _ERROR,
            "file is not well-formed XML",
            "The XML parser stopped. Document type declarations are refused too: they can define entities that expand "
            "without bound or read other files, and MaterialX does not use them.",
            "Correct the line that is named; an empty file has no materialx element at all.",
        ),
        Rule(
            "READ_XML_LENIENT",
            _WARNING,
            "XML that only a lenient reader takes",
            'A value of an attribute has a "<" in it, as the examples of MaterialX\'s specification write <UDIM>. XML '
            "does not allow that (XML 1.0, section 2.3); MaterialX reads it, as it is read here, and other programs "
            "refuse the file.",
            "Write &lt; for it, as in &lt;UDIM>.",
        ),
        Rule(
            "READ_FORMAT",
            _ERROR,
            "file is not what its name says",
            "The file's ending names a format (USD, glTF) that its content does not have: it is of another format, "
            "empty, cut short or damaged.",
            "Write the file anew with the program that it comes from, or give it the ending of what it holds.",
        ),
        Rule(
            "READ_TOO_DEEP",
            _ERROR,
            "elements are nested too deeply",
            f"XML elements are nested more than {MAXIMUM_XML_DEPTH} levels deep. MaterialX reads recursively and would "
            "exhaust the stack; real documents have fewer than ten levels.",
            "Flatten the document: nodes stand beside each other and are connected by name.",
        ),
        Rule(
            "READ_INCLUDE",
            _ERROR,
            "included file cannot be read",
            "A file that the document is made of (an xi:include of MaterialX, a buffer of glTF) does not exist; or it "
            "includes itself, directly or through others, as sublayers and references of USD can, too; or it takes "
            f"more than {MAXIMUM_INCLUDES} inclusions. Or something includes a file in a way that MaterialX passes "
            "over: an xi:include of another prefix or below another element, an include of a shader source that only "
            "the compiler behind it would resolve.",
            "Correct the name; break the circle; include files as MaterialX does.",
        ),
        Rule(
            "READ_OUTSIDE",
            _ERROR,
            "file name points outside the folder",
            "An included document, an image or a shader source lies outside the folder that is being checked: the one "
            "that the command was given, or in which the document lies. Documents come from elsewhere, so nothing "
            "outside that folder, and of those named by `--root`, is opened.",
            "Move the file into the folder, or name the folder that holds it by --root.",
        ),
        Rule(
            "DOC_INVALID",
            _ERROR,
            "not a valid MaterialX document",
            "MaterialX's own validation, or its reader, rejects the document.",
            "Correct what the message names; it is MaterialX's own.",
        ),
        Rule(
            "DOC_VERSION",
            _WARNING,
            "document without a version",
            "The attribute `version` of the materialx element is required (MaterialX specification, section 'MTLX File "
            "Format Definition'). MaterialX takes a document without one for its newest version, and upgrades nothing "
            "of an earlier one.",
            "State the version of MaterialX that the document was written for, such as 1.39.",
        ),
        Rule(
            "DOC_DUPLICATE_NAME",
            _WARNING,
            "two elements share a name",
            "Names are unique among siblings. MaterialX keeps the first element of a name and drops the others without "
            "a message.",
            "Rename one of the two.",
        ),
        Rule(
            "DOC_UNKNOWN_NODE",
            _ERROR,
            "unknown node",
            "No node definition in the libraries or in the document has this node category with these types. "
            "MaterialX's own validation accepts such a document; generators then fail or leave the node out.",
            "Check the spelling of the category and the node's type; custom nodes need a nodedef in the document.",
        ),
        Rule(
            "DOC_DEFINITION",
            _ERROR,
            "definition and implementation do not fit",
            "A node definition of the document has an output without a type; or the graph that implements a "
            "definition does not exist, or has other outputs. Their types have to agree, and of several outputs also "
            "the names (MaterialX specification, section 'Custom Node Definition Using Node Graphs'). A unit has a "
            "scale other than 0.",
            "Give definition and implementation the same outputs.",
        ),
        Rule(
            "DOC_UNKNOWN_INPUT",
            _ERROR,
            "unknown input",
            "The node's definition has no input of this name, so that the whole node loses its definition.",
            "Use one of the definition's inputs.",
        ),
        Rule(
            "DOC_INPUT_TYPE",
            _ERROR,
            "wrong type",
            "The input's type is not that of the node's definition, so that the whole node loses its definition.",
            "Give the input the definition's type, and its value that form.",
        ),
        Rule(
            "DOC_INPUT_VALUE",
            _ERROR,
            "value cannot be parsed",
            "The value of an input, an interface, a default or a token is not of its type, or not one of the values "
            "that the definition enumerates. A boolean is exactly true or false; a vector has its number of "
            "components, separated by commas; a struct has its members in braces, separated by semicolons. MaterialX "
            "takes what it understands of a number and passes over the rest, so that 0,5 is 0 and the integer 1.5 is "
            "1. Closures, shaders and materials have no value: they are connected.",
            "Write the value in the form of its type.",
        ),
        Rule(
            "DOC_VALUE_FORM",
            _WARNING,
            "value in a form that the specification does not have",
            "The numbers of a colour, vector or matrix are separated by spaces. MaterialX takes them so; by its "
            "specification (section 'MaterialX Data Types') they are separated by commas, and other readers may refuse "
            "what is not.",
            "Put commas between the numbers.",
        ),
        Rule(
            "DOC_VALUE_RANGE",
            _WARNING,
            "value outside the definition's range",
            "The node's definition states a range (uimin, uimax) that the value leaves. Shaders clamp some of these "
            "values and not others, so that targets differ.",
            "Bring the value into the range.",
        ),
        Rule(
            "DOC_CONNECTION",
            _ERROR,
            "connection leads nowhere or to another type",
            "The input or output names a node, an output or a graph that does not exist, or whose type is another; or "
            "it does not say which of several outputs it takes (MaterialX specification, section 'Inputs'). A look "
            "names a material, a group a look or a collection that does not exist.",
            "Correct the name, or convert the type with a node.",
        ),
        Rule(
            "DOC_OUTPUT_IGNORED",
            _WARNING,
            "output is named of a node that has one",
            "A connection to a node with one output has the attribute `output`. The specification has it ignored, "
            "whatever it names (section 'Inputs'), and so do generators; MaterialX's own validation refuses the "
            "document, and so may programs that ask it first.",
            "Leave out the attribute `output`.",
        ),
        Rule(
            "DOC_UNIFORM_CONNECTED",
            _WARNING,
            "uniform input is connected to what may vary",
            "The definition declares the input uniform, so that renderers can compile for its value. It may be "
            "connected to a `constant` or to an output that is declared uniform, also through `dot` nodes, and to "
            "nothing else (MaterialX specification, section 'Inputs'). MaterialX's validation does not enforce it; "
            "GLSL happens to accept any connection, MDL and others do not.",
            "Give the input a value. For `retroreflective`, make two copies of the BSDF, one with true and one with "
            "false, and connect the texture to the `mix` input of a mix node over the two: that works on every target.",
        ),
        Rule(
            "DOC_VALUE_IGNORED",
            _WARNING,
            "value has no effect",
            "The input falls back to geometry (its definition has a defaultgeomprop, such as the normal), and "
            "MaterialX's generators ignore a literal there: the shading normal is used all the same.",
            "Remove the value, or connect a node that gives it.",
        ),
        Rule(
            "DOC_COLOR_SPACE",
            _WARNING,
            "unknown colour space",
            "MaterialX has no transform from this colour space, so that its generators use the numbers as they are. It "
            "is told once for each space. Many names of OpenColorIO's built-in configurations, such as ACES2065-1, are "
            "unknown to MaterialX's default colour management; a host that has OpenColorIO may convert them.",
            "Use a colour space of MaterialX's library, such as srgb_texture, lin_rec709 or acescg.",
        ),
        Rule(
            "DOC_CYCLE",
            _ERROR,
            "graph is cyclic or too deep",
            "Nodes feed each other in a circle, or in a chain so long that generators, which work recursively, exhaust "
            "the stack.",
            "Break the circle at the connection that is named; merge long chains into node graphs.",
        ),
        Rule(
            "DOC_TOO_LARGE",
            _ERROR,
            "definitions come to too many nodes",
            f"A surface comes to more than {MAXIMUM_NODES:,} nodes when each node that a graph defines is counted as "
            "the nodes of that graph. Definitions that use each other twice double that number with each of them: "
            "twenty come to a million. Shader compilers evaluate them all. Real surfaces have a few hundred.",
            "Use definitions less often inside of each other; compute once what is used several times.",
        ),
        Rule(
            "DOC_FILE",
            _ERROR,
            "file cannot be read",
            "An image or a shader source that the document refers to does not exist, or is not a file; a set of images "
            "(<UDIM> and the like) has no file; or OpenImageIO cannot read the image.",
            "Correct the file name; it is relative to the document's folder, or to one named by --root.",
        ),
        Rule(
            "DOC_NO_RENDERABLE",
            _WARNING,
            "nothing to render",
            "The document has no material with a surface, and no output of a graph that can be shown: there is nothing "
            "to generate a shader from. Volumes, lights and displacements alone are not compared. A library of "
            "definitions is such a document; in USD, a stage none of whose Materials has a MaterialX network; in glTF, "
            "an asset without materials.",
            "Add a surfacematerial node with a surface shader; in USD, connect `outputs:mtlx:surface` of a Material; "
            "in glTF, add a material.",
        ),
        Rule(
            "DOC_NOT_COMPARED",
            _WARNING,
            "part of a material is not compared",
            "The material has a displacement, or another surface for its back. Generated shaders have neither: what is "
            "compared with the reference is its surface alone.",
            "Nothing is wrong with the document; check what is named in the renderer.",
        ),
        Rule(
            "INTERCHANGE_LOST",
            _WARNING,
            "not carried over into another format",
            "The file says something that the other format has no form for: an animated value has one value in "
            "MaterialX, a look of MaterialX has no place in a USD material. What is checked or written is without it.",
            "Nothing is wrong with the file; do not rely on what is named in the other format.",
        ),
        Rule(
            "INTERCHANGE_INVALID",
            _ERROR,
            "file breaks the rules of its format",
            "A property of a glTF asset has the wrong type or range, refers to what is not there, or must not be used "
            "together with another (glTF 2.0, and the JSON schemas of its extensions). The material that it belongs to "
            "is left out.",
            "Correct the place that is named, a JSON pointer into the file.",
        ),
        Rule(
            "INTERCHANGE_LEFT_OUT",
            _ERROR,
            "material has no form in the other format",
            "The material is made of parts that the other format does not have, so that it was not written at all: "
            "glTF has one metal, one dielectric over a diffuse base, and layers over these.",
            "Build the material of what the other format has, for glTF of the node gltf_pbr, or use another format.",
        ),
        Rule(
            "USD_VALIDATOR",
            _ERROR,
            "an error by USD's own validators",
            "The validators that come with USD call it an error; their name is in the message. They know nothing of "
            "MaterialX's nodes: that these are unknown to them is left out (docs/usd.md). The materials are checked "
            "all the same.",
            "Do what the message says; a stage wants defaultPrim, metersPerUnit and upAxis.",
        ),
        Rule(
            "USD_MISSING",
            _ERROR,
            "a layer of a stage is missing",
            "A sublayer, reference or payload of the stage names a file that is not there, or a document of MaterialX "
            "that is wrong. The stage is read without it. Materials that refer to it, or of which a prim around or in "
            "them does, are not checked; all others are.",
            "Correct the name, or put the file where the name leads; other places are not searched.",
        ),
        Rule(
            "USD_VALIDATOR_WARNING",
            _WARNING,
            "a warning by USD's own validators",
            "As USD_VALIDATOR, but what the validators call a warning.",
            "Do what the message says.",
        ),
        Rule(
            "RETRO_UNDEFINED",
            _ERROR,
            "node cannot be retroreflective",
            "The node's definition has no such input. The boolean `retroreflective` exists on conductor_bsdf, "
            "dielectric_bsdf and generalized_schlick_bsdf, from MaterialX 1.39.5 on. The amounts "
            "`specular_retroreflectivity` of open_pbr_surface and `retroreflectivity` of standard_surface and gltf_pbr "
            "are this project's, and not in the standard library.",
            "Use a node that has the input, or remove it. Amounts need `--library mrm`.",
        ),
        Rule(
            "RETRO_TRANSMISSION",
            _WARNING,
            "retroreflective on a node that only transmits",
            "With scatter_mode T the node has no reflection, and the flag acts on reflection alone (MaterialX "
            "specification; Portsmouth et al. 2026, section 5): it does nothing.",
            "Use scatter_mode R or RT, or remove the flag.",
        ),
        Rule(
            "RETRO_INVISIBLE",
            _WARNING,
            "retroreflective lobe cannot be seen",
            "The lobe's weight is 0 or its reflectance is black, so that the flag or the amount has no visible effect. "
            "Of a surface model, that is said of all lobes of the base.",
            "Give the lobe a weight and a reflectance. A dielectric of index 1 reflects nothing.",
        ),
        Rule(
            "ENERGY_GAIN",
            _ERROR,
            "surface reflects more light than it receives",
            "The directional albedo, the integral of response(v, l) over all l, is above 1 for some view direction and "
            f"channel. It is integrated by importance sampling over every lobe of the reference; values up to "
            f"{ALBEDO_BOUND:g} pass, since MaterialX's energy compensation is a fit that gives an ideal white lobe as "
            "much.",
            "Lower the reflectances, or put one lobe over the other with `layer` instead of `add`.",
        ),
        Rule(
            "ENERGY_ANISOTROPIC",
            _WARNING,
            "anisotropic lobe reflects more light than it receives",
            "As ENERGY_GAIN, but only at view angles beyond "
            f"{STEEP_DEGREES:g} degrees and with an anisotropic lobe. MaterialX masks such lobes with their mean width "
            "sqrt(alpha_x alpha_y) in every direction, which is too little masking along the wider axis: a white lobe "
            "of widths (0.3, 0.05) reflects 1.17 at 75 and 1.74 at 85 degrees. Nothing in the document is wrong.",
            "Reduce the anisotropy or the reflectance if the material is seen at grazing angles.",
        ),
        Rule(
            "LOBE_TOO_NARROW",
            _WARNING,
            "lobe is too narrow for float32",
            f"The microfacet width alpha is below {NARROWEST_ALPHA:g}. The half-vector is known to about 21 roundings "
            "of 2^-24; on the flank of the lobe D moves by 2 * 21 * 2^-24 / alpha relative, which is a tenth there: "
            "shaders hit or miss the peak by chance. The comparison leaves the peak out, which is why it is told also "
            "of surface models, in which a roughness of 0 is how a mirror or a smooth glass is written. Environment "
            "light is not affected.",
            "Use an alpha of at least 2.5e-05 (a roughness of 0.005); real retroreflectors have 0.0025 and more.",
        ),
        Rule(
            "SHADER_GENERATE",
            _ERROR,
            "shader generation failed",
            "MaterialX could not generate source code for the target; the message is its own.",
            "Commonly a node without an implementation for the target, or a source file that is not found.",
        ),
        Rule(
            "SHADER_COMPILE",
            _ERROR,
            "compilation failed",
            "The target's compiler rejects the generated source. The message is the compiler's, with its line of the "
            "generated code.",
            "Look at the source with `mrm generate`; a custom implementation in the document is the usual cause.",
        ),
        Rule(
            "SHADER_DIFFERS",
            _ERROR,
            "shader differs from the reference",
            "The shader's response misses the float64 reference by more than float32 arithmetic explains. Allowed per "
            "sample: 24 times the sum of the reference's own movements under single float32 roundings of each axis of "
            "v and l, of the document's numbers and of ill-conditioned intermediate results, plus 40 roundings of the "
            "result. 24 counts the roundings of a half-vector at GLSL 4.60's precisions (section 4.7.1).",
            "The worst sample is named. A document's own implementation of a node is a common cause.",
        ),
        Rule(
            "UPSTREAM_DEVIATION",
            _WARNING,
            "MaterialX deviates from its specification",
            "The shader is not what the specification says, but what MaterialX's generators or libraries are known to "
            "make of it: the float64 reference, deviating in the same way, agrees with it within its tolerance; or the "
            "source agrees with the reference once what causes the deviation, in it or in the document, is mended. "
            "docs/upstream-notes.md has each deviation by its name, with the smallest document that shows it.",
            "Other renderers may show the material as specified; the notes say how to avoid the deviation.",
        ),
        Rule(
            "SHADER_NOT_FINITE",
            _ERROR,
            "shader gives NaN or infinity",
            "For valid directions and a unit light the shader's colour is not a finite number. Such pixels spread in "
            "denoisers and filters.",
            "Look for divisions by an input that is 0, and for an alpha of 0 at the peak of a lobe.",
        ),
        Rule(
            "SHADER_IGNORES_RETRO",
            _WARNING,
            "target ignores the retroreflective flag",
            "The generated code for this target does not depend on the flag, so that the material looks ordinary "
            "there. In MaterialX 1.39.5 this is so for MDL (before module 1.11) and, without the node library of this "
            "project, for OSL (the value is never read).",
            "Nothing in the document is wrong; do not rely on this target for the effect.",
        ),
        Rule(
            "CHECK_CRASHED",
            _ERROR,
            "check crashed",
            "The process that worked on the document died, used up its memory, or met an internal error. The rest was "
            "checked.",
            "Please report it with the document; MaterialX or a driver may have died on it.",
        ),
        Rule(
            "CHECK_TIMEOUT",
            _ERROR,
            "check took too long",
            "Reading the document, or one of its surfaces on one target, was not finished within the time limit and "
            "was given up.",
            "Raise --timeout, or look for an endless loop in a custom implementation.",
        ),
    )
}
