"""Documents go in, verdicts come out: checks, comparison with the reference, the run over many documents."""
