"""Progress on a terminal: the work in hand, how far it is, how long it took and takes yet."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    Task,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from spheremap.cli.steps import Step


class _Percent(TaskProgressColumn):
    """Nothing where nobody knows how much there is to do."""

    def render(self, task: Task) -> Text:
        return Text("") if task.total is None else super().render(task)


class _Shown(Step):
    """A line of several things counts them; one of a single thing, each of its works by itself."""

    is_shown = True

    def __init__(self, progress: Progress, total: int) -> None:
        self._progress, self._total, self._finished = progress, total, 0
        self._task = progress.add_task("", total=total if total > 1 else None)

    def __call__(self, description: str) -> None:
        self._progress.update(self._task, description=escape(description))
        if self._total == 1:
            # Another work goes at another speed: with the old one's it would foretell nonsense.
            self._progress.tasks[0].total = None
            self._progress.reset(self._task)

    def part(self, fraction: float) -> None:
        if self._total == 1:
            self._progress.update(self._task, total=1.0, completed=fraction)
        else:
            self._progress.update(self._task, completed=self._finished + fraction)

    def done(self) -> None:
        self._finished += 1
        if self._total > 1:
            self._progress.update(self._task, completed=self._finished)


@contextmanager
def shown(total: int) -> Iterator[Step]:
    """Show on the terminal of stderr what is done of so many things."""
    count: ProgressColumn = MofNCompleteColumn() if total > 1 else _Percent()
    columns: list[ProgressColumn] = [
        SpinnerColumn(),
        TextColumn("{task.description}"),
        TimeElapsedColumn(),
        BarColumn(),
        count,
        TimeRemainingColumn(),
    ]
    # What is printed meanwhile goes above the line; what goes into a pipe must not get here.
    with Progress(
        *columns,
        console=Console(stderr=True),
        transient=True,
        redirect_stdout=sys.stdout.isatty(),
    ) as progress:
        yield _Shown(progress, total)
