"""Output on terminals and pipes of any encoding."""

from __future__ import annotations

import codecs
import io
import sys

# What old code pages lack of what the commands print.
_PLAIN = {
    "∫": "integral of",
    "ω": "omega",
    "π": "pi",
    "θ": "theta",
    "φ": "phi",
    "²": "^2",
    "°": " deg",
    "±": "+-",
    "×": "x",
    "·": "*",
    "→": "->",
    "−": "-",
    "–": "-",
}


def print_anywhere() -> None:
    """Let a character that the encoding of stdout or stderr lacks be spelled, not end the run."""
    codecs.register_error("spheremap.spelled", _spelled)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="spheremap.spelled")


def _spelled(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    missing = error.object[error.start : error.end]
    text = "".join(_PLAIN.get(character, "?") for character in missing)
    return text, error.end
