"""The mutant of a kind, a seed and a number: always the same, whatever else is run."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random
from typing import TYPE_CHECKING, NamedTuple

from tools.fuzz import corpus
from tools.fuzz.kinds import KINDS

if TYPE_CHECKING:
    from pathlib import Path


class Key(NamedTuple):
    """What a mutant is made from."""

    kind: str
    seed: int
    number: int

    def __str__(self) -> str:
        return f"{self.kind}-{self.seed}-{self.number}"


class Mutant(NamedTuple):
    """The ending of a file's name and its content."""

    suffix: str
    content: bytes


@dataclass
class Maker:
    """Makes mutants from the corpora in a folder; see `corpus.build`."""

    folder: Path
    _seeds: dict[str, dict[str, list[bytes]]] = field(default_factory=dict)

    def make(self, key: Key) -> Mutant:
        """The mutant of a key."""
        if key.kind not in self._seeds:
            self._seeds[key.kind] = corpus.load(self.folder, key.kind)
        rng = Random(str(key))
        forms = KINDS[key.kind]
        (form,) = rng.choices(forms, [form.share for form in forms])
        seeds = self._seeds[key.kind].get(form.suffix, [b""])
        return Mutant(form.suffix, form.mutator(rng.choice(seeds), rng, rng.choice(seeds)))
