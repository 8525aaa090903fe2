"""Untrusted files of USD as a stage: looked at one by one before USD composes them.

* `stage`: the stage, and what was not opened.
* `stage_layers`: all its layers, over `layers` (one file), `document_layers` (documents of MaterialX), `placeholders`
  (for what is not opened) and `composition_size` (the limit on what USD will compose).
* `stage_files`: where names of files lead, over `packages`; `asset_values`: such names among values.
* `crates`, over `crate_values` and `crate_packing`: what a binary file claims to hold.
"""
