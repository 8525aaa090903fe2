"""Energy, and lobes that cannot be drawn."""

from __future__ import annotations

from mrm_mtlx.findings.finding import Rule, Severity

# Largest albedo that the check lets pass. MaterialX's energy compensation is a fit: an ideal white isotropic lobe comes
# out at up to 1.086 (alpha 0.0025 at 85 degrees; measured with validation.energy, alpha 0.0025 to 1, 0 to 88 degrees).
ALBEDO_BOUND = 1.10

# Up to this view angle [degrees], mean-width masking adds nothing: white lobes up to (0.9, 0.1) stay below 0.98 there.
STEEP_DEGREES = 30.0

# Below this width, the roundings of a half-vector (21 units of 2^-24, see reference.float32) are a twentieth of the
# lobe's width, and move its flank by a tenth: 2 * 21 * 2^-24 / alpha = 0.1.
NARROWEST_ALPHA = 2.5e-5

ENERGY_GAIN = Rule(
    "ENERGY_GAIN",
    Severity.ERROR,
    "surface reflects more light than it receives",
    "The directional albedo, the integral of response(v, l) over all l, is above 1 for some view direction and "
    f"channel. It is integrated by importance sampling over every lobe of the reference; values up to "
    f"{ALBEDO_BOUND:g} pass, since MaterialX's energy compensation is a fit that gives an ideal white lobe as "
    "much.",
    "Lower the reflectances, or put one lobe over the other with `layer` instead of `add`.",
)

ENERGY_ANISOTROPIC = Rule(
    "ENERGY_ANISOTROPIC",
    Severity.WARNING,
    "anisotropic lobe returns more than it gets",
    "As ENERGY_GAIN, but only at view angles beyond "
    f"{STEEP_DEGREES:g} degrees and with an anisotropic lobe. MaterialX masks such lobes with their mean width "
    "sqrt(alpha_x alpha_y) in every direction, which is too little masking along the wider axis: a white lobe "
    "of widths (0.3, 0.05) reflects 1.17 at 75 and 1.74 at 85 degrees. Nothing in the document is wrong.",
    "Reduce the anisotropy or the reflectance if the material is seen at grazing angles.",
)

LOBE_TOO_NARROW = Rule(
    "LOBE_TOO_NARROW",
    Severity.WARNING,
    "lobe is too narrow for float32",
    f"The microfacet width alpha is below {NARROWEST_ALPHA:g}. The half-vector is known to about 21 roundings "
    "of 2^-24; on the flank of the lobe D moves by 2 * 21 * 2^-24 / alpha relative, which is a tenth there: "
    "shaders hit or miss the peak by chance. The comparison leaves the peak out, which is why it is told also "
    "of surface models, in which a roughness of 0 is how a mirror or a smooth glass is written. Environment "
    "light is not affected.",
    "Use an alpha of at least 2.5e-05 (a roughness of 0.005); real retroreflectors have 0.0025 and more.",
)
