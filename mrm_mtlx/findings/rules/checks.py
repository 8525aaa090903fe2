"""Checks that did not come to an end."""

from __future__ import annotations

from mrm_mtlx.findings.finding import Rule, Severity

CHECK_CRASHED = Rule(
    "CHECK_CRASHED",
    Severity.ERROR,
    "check crashed",
    "The process that worked on the document died, used up its memory, or met an internal error. The rest was checked.",
    "Please report it with the document; MaterialX or a driver may have died on it.",
)

CHECK_TIMEOUT = Rule(
    "CHECK_TIMEOUT",
    Severity.ERROR,
    "check took too long",
    "Reading the document, or one of its surfaces on one target, was not finished within the time limit and "
    "was given up.",
    "Raise --timeout, or look for an endless loop in a custom implementation.",
)
