"""Test vectors of the model: lobes, directions, and the values of the reference."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import dataclass
from typing import Any

from mrm_mtlx.system.shown import Shown

# Parameters that are colours, also where a number stands for a grey one.
_COLORS = ("tint", "color0", "color82", "color90", "extinction")
_HEADER = "  theta_v    phi_v  theta_l    phi_l   f [1/sr]                              pdf [1/sr]    albedo"
_SHOWN = ("case", "theta_v_deg", "phi_v_deg", "theta_l_deg", "phi_l_deg", "v", "l", "f", "pdf", "albedo")


@dataclass(frozen=True, repr=False)
class TestVectors(Shown):
    """Test vectors, to check an implementation against; docs/model.md explains them.

    Attributes
    ----------
    rows
        A dictionary for each: the lobe's parameters, directions, and values.
    """

    __test__ = False  # no class of tests, whatever its name

    rows: tuple[dict[str, Any], ...]

    def __repr__(self) -> str:
        cases = dict.fromkeys(row["case"] for row in self.rows)
        return f"{len(self.rows)} test vectors of {len(cases)} cases: {', '.join(cases)}"

    def report(self) -> str:
        """One block per case, a line per pair of directions."""
        lines: list[str] = []
        previous = None
        for row in self.rows:
            if row["case"] != previous:
                previous = row["case"]
                shown = ", ".join(f"{name}={_brief(value)}" for name, value in row.items() if name not in _SHOWN)
                lines += ["", f"{previous}:", f"  {shown}", _HEADER]
            angles = " ".join(f"{row[k]:8.1f}" for k in ("theta_v_deg", "phi_v_deg", "theta_l_deg", "phi_l_deg"))
            f = " ".join(f"{x:<12.6g}" for x in row["f"])
            lines.append(f" {angles}   {f}{row['pdf']:<14.6g}{' '.join(f'{x:.3f}' for x in row['albedo'])}")
        return "\n".join(lines[1:])

    def to_csv(self) -> str:
        """One column per number: a vector or colour gives three, `v_x`, `f_r`; a width two, `alpha_x`."""
        flat = [_flat(row) for row in self.rows]
        columns = list(dict.fromkeys(name for row in flat for name in row))
        # Directions and values last, whichever row has a parameter first.
        columns.sort(key=lambda name: name.partition("_")[0] in {"theta", "phi", "v", "l", "f", "pdf", "albedo"})
        text = io.StringIO()
        writer = csv.DictWriter(text, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(flat)
        return text.getvalue().rstrip("\n")

    def to_json(self) -> str:
        """A line per vector."""
        from mrm_mtlx.bsdf.testvectors import SCHEMA
        from mrm_mtlx.system.versions import __version__

        lines = ",\n".join("    " + json.dumps(row) for row in self.rows)
        versions = json.dumps({"mrm": __version__})
        return f'{{\n  "schema": "{SCHEMA}",\n  "versions": {versions},\n  "vectors": [\n{lines}\n  ]\n}}'


def vectors() -> TestVectors:
    """Test vectors of the model, by the reference."""
    from mrm_mtlx.bsdf.testvectors import rows

    return TestVectors(tuple(rows()))


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in row.items():
        if isinstance(value, bool):
            found[name] = str(value).lower()
        elif isinstance(value, list):
            axes = "xyz" if name in {"alpha", "v", "l"} else "rgb"
            found |= {f"{name}_{axis}": number for axis, number in zip(axes, value, strict=False)}
        elif name in _COLORS:
            found |= {f"{name}_{channel}": value for channel in "rgb"}
        else:
            found[name] = value
    return found


def _brief(value: Any) -> str:
    return f"({', '.join(f'{x:g}' for x in value)})" if isinstance(value, list) else str(value)
