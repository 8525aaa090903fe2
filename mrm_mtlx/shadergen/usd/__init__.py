"""Materials as networks of USD, for hosts that generate their shaders themselves.

* `network`: a renderable element as a layer of its own.
* `material_prims`: materials as prims of a stage, over `scope` (what lies beside each other in one).
* `values`: types, values, colour spaces and terminals of MaterialX in USD, and back.
"""
