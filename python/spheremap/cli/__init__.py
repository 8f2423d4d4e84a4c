"""The command `spheremap`. It needs `pip install spheremap[cli]`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.util import find_spec


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command and exit: 0 if all went well, 1 for a failure, 2 for wrong usage."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given == ["--version"]:
        # Programs ask this often; no parser is needed.
        import spheremap

        print(f"spheremap {spheremap.__version__}")
        sys.exit(0)
    for name in ("typer", "rich"):
        if find_spec(name) is None:
            print(
                f"error: the command line needs {name}: pip install spheremap[cli]", file=sys.stderr
            )
            sys.exit(1)
    from spheremap.cli.app import run

    sys.exit(run(given))
