"""The command on a terminal that a test reads."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

needs_terminal = pytest.mark.skipif(os.name != "posix", reason="needs a terminal to speak to")


def on_terminal(
    *arguments: object, stream: str, columns: int = 80, term: str = "xterm", code: int = 0
) -> tuple[str, str]:
    """Run the command with stdout or stderr on a terminal; return what went there and elsewhere."""
    import pty

    other = "stderr" if stream == "stdout" else "stdout"
    mine, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "spheremap", *map(str, arguments)],
        env={**os.environ, "COLUMNS": str(columns), "TERM": term},
        **{stream: theirs, other: subprocess.PIPE},
    )
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(mine, 1 << 16)
        except OSError:  # Linux, where the other side has gone
            break
        if not part:
            break
        shown += part
    os.close(mine)
    rest = b"".join(said for said in process.communicate() if said)
    assert process.returncode == code, (shown, rest)
    return shown.decode(), rest.decode()
