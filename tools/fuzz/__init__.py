"""Mutated documents, stages, assets, data and images against everything that opens them; see docs/reliability.md.

* `odd`: values, names and files that programs trip over.
* `raw`, `xml`, `text`, `gltf`, `data`, `images`: mutators; `kinds` says which is for what.
* `corpus`: what is mutated.
* `mutants`: the mutant of a kind, a seed and a number; always the same.
* `target`: what is done with one, and what counts as a failure.
* `run`: many of them, in worker processes that may die; `report` counts and prints.
"""
