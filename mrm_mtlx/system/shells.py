"""Setting a variable of the environment, as each shell has it."""

from __future__ import annotations

import shlex


def assignments(variable: str, value: str) -> dict[str, str]:
    r"""The line that sets a variable for programs that are started from a shell, by the names of the shells.

    Examples
    --------
    >>> for shell, line in assignments("FOLDERS", "/it's here").items():
    ...     print(f"{shell:10} {line}")
    bash, zsh  export FOLDERS='/it'"'"'s here'
    fish       set -gx FOLDERS '/it\'s here'
    PowerShell $env:FOLDERS = '/it''s here'
    cmd        set "FOLDERS=/it's here"
    """
    in_fish = value.replace("\\", "\\\\").replace("'", "\\'")
    in_powershell = value.replace("'", "''")
    return {
        "bash, zsh": f"export {variable}={shlex.quote(value)}",
        "fish": f"set -gx {variable} '{in_fish}'",
        "PowerShell": f"$env:{variable} = '{in_powershell}'",
        "cmd": f'set "{variable}={value}"',
    }
