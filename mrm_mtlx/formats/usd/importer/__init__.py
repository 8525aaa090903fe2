"""The materials of a stage as a document.

* `stage_materials`: all of them, in all variants, over `network` (one material), `versions` (of MaterialX) and `assets`
  (files that they name).
* `validators`: what USD's own validators say of the stage.
"""
