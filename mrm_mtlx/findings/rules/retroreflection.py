"""The retroreflective flag, and what it does."""

from __future__ import annotations

from mrm_mtlx.findings.finding import Rule, Severity

RETRO_UNDEFINED = Rule(
    "RETRO_UNDEFINED",
    Severity.ERROR,
    "node cannot be retroreflective",
    "The node's definition has no such input. The boolean `retroreflective` exists on conductor_bsdf, "
    "dielectric_bsdf and generalized_schlick_bsdf, from MaterialX 1.39.5 on. The amounts "
    "`specular_retroreflectivity` of open_pbr_surface and `retroreflectivity` of standard_surface and gltf_pbr "
    "are this project's, and not in the standard library.",
    "Use a node that has the input, or remove it. Amounts need `--library mrm`.",
)

RETRO_VERSION = Rule(
    "RETRO_VERSION",
    Severity.WARNING,
    "flag in a document of an earlier version",
    "The boolean `retroreflective` exists from MaterialX 1.39.5 on, in documents of version 1.39. A host that takes "
    "the stated version at its word knows no such input: it refuses the document, or drops the flag and shows an "
    "ordinary lobe. MaterialX itself upgrades documents of an earlier version when it reads them, keeps the input, "
    "and says nothing. Of what is included, the version of its own file counts.",
    "State version 1.39, after looking at what else that version changes; or remove the flag.",
)

RETRO_TRANSMISSION = Rule(
    "RETRO_TRANSMISSION",
    Severity.WARNING,
    "retroreflective on a node that only transmits",
    "With scatter_mode T the node has no reflection, and the flag acts on reflection alone (MaterialX "
    "specification; Portsmouth et al. 2026, section 5): it does nothing.",
    "Use scatter_mode R or RT, or remove the flag.",
)

RETRO_INVISIBLE = Rule(
    "RETRO_INVISIBLE",
    Severity.WARNING,
    "retroreflective lobe cannot be seen",
    "The lobe's weight is 0 or its reflectance is black, so that the flag or the amount has no visible effect. "
    "Of a surface model, that is said of all lobes of the base.",
    "Give the lobe a weight and a reflectance. A dielectric of index 1 reflects nothing.",
)
