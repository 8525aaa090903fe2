"""Generated code: what it does beside the reference."""

from __future__ import annotations

from mrm_mtlx.findings.finding import Rule, Severity

SHADER_GENERATE = Rule(
    "SHADER_GENERATE",
    Severity.ERROR,
    "shader generation failed",
    "MaterialX could not generate source code for the target; the message is its own.",
    "Commonly a node without an implementation for the target, or a source file that is not found.",
)

SHADER_COMPILE = Rule(
    "SHADER_COMPILE",
    Severity.ERROR,
    "compilation failed",
    "The target's compiler rejects the generated source. The message is the compiler's, with its line of the "
    "generated code.",
    "Look at the source with `mrm generate`; a custom implementation in the document is the usual cause.",
)

SHADER_DIFFERS = Rule(
    "SHADER_DIFFERS",
    Severity.ERROR,
    "shader differs from the reference",
    "The shader's response misses the float64 reference by more than float32 arithmetic explains. Allowed per "
    "sample: 24 times the sum of the reference's own movements under single float32 roundings of each axis of "
    "v and l, of the document's numbers and of ill-conditioned intermediate results, plus 40 roundings of the "
    "result. 24 counts the roundings of a half-vector at GLSL 4.60's precisions (section 4.7.1).",
    "The worst sample is named. A document's own implementation of a node is a common cause.",
)

UPSTREAM_DEVIATION = Rule(
    "UPSTREAM_DEVIATION",
    Severity.WARNING,
    "MaterialX deviates from its specification",
    "The shader is not what the specification says, but what MaterialX's generators or libraries are known to "
    "make of it: the float64 reference, deviating in the same way, agrees with it within its tolerance; or the "
    "source agrees with the reference once what causes the deviation, in it or in the document, is mended. "
    "docs/upstream-notes.md has each deviation by its name, with the smallest document that shows it.",
    "Other renderers may show the material as specified; the notes say how to avoid the deviation.",
)

SHADER_NOT_FINITE = Rule(
    "SHADER_NOT_FINITE",
    Severity.ERROR,
    "shader gives NaN or infinity",
    "For valid directions and a unit light the shader's colour is not a finite number. Such pixels spread in "
    "denoisers and filters.",
    "Look for divisions by an input that is 0, and for an alpha of 0 at the peak of a lobe.",
)

SHADER_IGNORES_RETRO = Rule(
    "SHADER_IGNORES_RETRO",
    Severity.WARNING,
    "target ignores the retroreflective flag",
    "The generated code for this target does not depend on the flag, so that the material looks ordinary "
    "there. In MaterialX 1.39.5 this is so for MDL (before module 1.11) and, without the node library of this "
    "project, for OSL (the value is never read).",
    "Nothing in the document is wrong; do not rely on this target for the effect.",
)
