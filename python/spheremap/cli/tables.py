"""Tables, an entry a line: whole in a pipe, as many columns as fit on a terminal."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence

from spheremap._show import GAP, text_table


def print_table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: bool = False
) -> None:
    """Print a table, and what it leaves out where a terminal is too narrow for all columns.

    No cell is cut. With `numbers` all columns but the first are to the right.
    """
    widths = [max(len(row[k]) for row in (heads, *rows)) for k in range(len(heads))]
    shown = len(heads) if not sys.stdout.isatty() else _fitting(widths)
    print(text_table(heads[:shown], [row[:shown] for row in rows], numbers=numbers))
    if shown < len(heads):
        print(f"not shown, for want of width: {', '.join(heads[shown:])}")


def _fitting(widths: Sequence[int]) -> int:
    """Return how many columns fit, but for the first, which is always there."""
    room = shutil.get_terminal_size().columns
    total = widths[0]
    for k, width in enumerate(widths[1:], 1):
        total += len(GAP) + width
        if total > room:
            return k
    return len(widths)
