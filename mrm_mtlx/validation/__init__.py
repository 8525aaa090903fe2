"""Documents go in, verdicts come out: findings, rules, comparison, and the pipeline that ties them together."""
