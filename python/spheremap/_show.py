"""How values show themselves: rows as a table in text and in HTML, records in one line."""

from __future__ import annotations

import dataclasses
import html
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

import numpy as np

# What lies between two columns.
GAP = "  "
# Numbers of an array that a line shows; of more it says the dtype and the shape.
_FEW = 4


def text_table(head: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: bool = False) -> str:
    """Return rows as lines, with columns as wide as they need to be.

    With `numbers` all columns but the first are to the right.
    """
    lines = [head, *rows]
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    padded = (
        GAP.join(
            cell.rjust(width) if numbers and k else cell.ljust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    )
    return "\n".join(line.rstrip() for line in padded)


def html_table(head: Sequence[str], rows: Iterable[Sequence[str]], note: str = "") -> str:
    """Return rows as an HTML table, and a note below it."""

    def row(tag: str, cells: Iterable[str]) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(x)}</{tag}>" for x in cells) + "</tr>"

    body = "".join(row("td", cells) for cells in rows)
    table = f"<table><thead>{row('th', head)}</thead><tbody>{body}</tbody></table>"
    return f"{table}<p>{html.escape(note)}</p>" if note else table


class Rows(list[dict[str, Any]]):
    """A list of rows that prints as a table; it is a list in every other way."""

    HEAD: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def cells(cls, row: dict[str, Any]) -> tuple[str, ...]:
        """Return what the table shows of a row."""
        return tuple(str(row.get(name, "")) for name in cls.HEAD)

    def _is_table(self) -> bool:
        # A list takes anything, and is shown whatever it holds.
        return bool(self) and all(isinstance(row, dict) for row in self)

    def __repr__(self) -> str:
        if not self._is_table():
            return super().__repr__()
        return text_table(self.HEAD, map(self.cells, self))

    def _repr_html_(self) -> str:
        if not self._is_table():
            return html.escape(super().__repr__())
        return html_table(self.HEAD, map(self.cells, self))


def line(record: Any) -> str:
    """Return a dataclass in one line, its arrays by their shapes: for ``__repr__``."""
    shown = ", ".join(
        f"{field.name}={short(getattr(record, field.name))}" for field in dataclasses.fields(record)
    )
    return f"{type(record).__name__}({shown})"


def short(value: object) -> str:
    """Return a value as a part of a line."""
    if isinstance(value, bool | np.bool_) or value is None:
        return str(value)
    if isinstance(value, float | np.floating):
        return _number(value)
    if isinstance(value, np.ndarray):
        if value.ndim < 2 and value.size <= _FEW and value.dtype.kind in "fiu":
            numbers = [_number(x) for x in value.ravel()]
            return f"({', '.join(numbers)})" if value.ndim else numbers[0]
        return f"{value.dtype} {value.shape}"
    if isinstance(value, tuple | list) and type(value) in (tuple, list):
        some = [short(x) for x in value[:_FEW]]
        more = [f"... {len(value)}"] if len(value) > _FEW else []
        left, right = "()" if isinstance(value, tuple) else "[]"
        comma = "," if len(value) == 1 and left == "(" else ""
        return f"{left}{', '.join(some + more)}{comma}{right}"
    return repr(value)


def _number(x: Any) -> str:
    # Six digits: places in photos have four before the point. No negative zero.
    return f"{x + 0:.6g}"
