"""Documents of whole surfaces that benchmarks evaluate: two large models with every lobe in use, and a metal alone."""

from __future__ import annotations

from typing import Any

import MaterialX as mx

from mrm_mtlx.library import load_library

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


def document(text: str) -> Any:
    """A document with the node library behind it."""
    made = mx.createDocument()
    mx.readFromXmlString(made, text)
    made.setDataLibrary(load_library().document)
    return made
