"""Times, a module per subject: `python -m benchmarks.oracle`; with `--save`, also kept in the page beside it."""
