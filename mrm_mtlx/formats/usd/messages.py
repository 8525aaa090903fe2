"""Messages of USD, as they are shown."""

from __future__ import annotations

import re

# Layers without a file have their address as name, and what follows it. A stage has one more, for what is selected.
_SESSION = re.compile(r",?@anon:[^@]*-session\.usda@")
_ADDRESS = re.compile(r"anon:0x[0-9a-f]+:?")


def said(error: object) -> str:
    """A message of USD, on one line, without places in its own source and folders of this machine."""
    text = str(error).strip()
    found = re.search(r"in file \S+ : '(.*?)'\s*(?:Error in|$)", text, re.DOTALL)
    text = _SESSION.sub("", " ".join((found[1] if found else text).split()))
    text = _ADDRESS.sub("", re.sub(r" <0x[0-9a-f]+>", "", text))
    return re.sub(r"[^\s@'<(]*/([^/\s@]+\.usd[acz]?)", r"\1", text)[:300]
