"""A surface as formats that read less have it: the inputs of gltf_pbr, each a number times an image, plus one.

* `inputs`: those of a surface: its own, those of another surface model (`surface_models`), those that its BSDF nodes
  are (`bsdf_surfaces`), or those that come nearest to its values (`nearest`).
* `terms`: an input as a `term`, over `value_sources` (what it is connected to) and `placement` (where it reads an
  image).
* `comparison`: how far two surfaces are apart.
"""
