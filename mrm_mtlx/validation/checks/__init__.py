"""Checks of documents, before anything is generated.

* `graph`: the structure, over a module per subject (`nodes`, `values`, `connections`, `cycles`, `definitions`, `looks`,
  `color_spaces`, `size`, `scope`, and `materialx`, whose own validation has the last word).
* `files`: images and, in `sources`, the source code of implementations.
* `retroreflection`: lobes and surface models with the flag.
"""
