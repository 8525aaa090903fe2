"""Documents go in, verdicts come out.

* `options`, `results`, `reports`: what is asked, what comes of it as plain data, and how it is written.
* `runner`: the run, over `collecting` (documents of folders), `workers` (processes) and `steps` (what a process that
  dies leaves behind).
* `document`: one document; `element`: one surface on all targets, over `energy`, `compiling` and `flag_use`;
  `retro_sweep`: its variants with the flag on.
* `checks`: documents before anything is generated; `comparison`: generated code beside the reference.
"""
