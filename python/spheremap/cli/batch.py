"""The subcommand `spheremap batch`: many files, by processes of this machine or of a cluster."""

from __future__ import annotations

import glob
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

import spheremap as sm
from spheremap import io
from spheremap.cli import targets, workers
from spheremap.cli.asked import Asked
from spheremap.cli.jobs import Failed, Job
from spheremap.cli.manifest import Manifest
from spheremap.cli.options import as_options, taking
from spheremap.cli.terminal import UsageError, progress, refuse

_MANIFEST = "spheremap-batch.jsonl"
# Options on which no bit of a result depends.
_OF_THE_WAY = ("memory", "resume", "no_clobber")


@taking(Asked)
def batch(
    context: typer.Context,
    patterns: Annotated[
        list[str],
        typer.Argument(metavar="IN", help="Files to read, as 'in/**/*.exr': ** is any folders."),
    ],
    output: Annotated[
        str,
        typer.Option(
            "--output",
            "-o",
            metavar="PATTERN",
            help="Names of the results, as 'out/{dir}/{stem}.ktx2'; folders are made.",
        ),
    ],
    jobs: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="How many files at once. [default: one a core]"),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Of a distributed cluster that does it, as tcp://host:8786."
        ),
    ] = None,
    retries: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=0,
            help="How often to try again what a disk or a killed worker made fail.",
        ),
    ] = 2,
    manifest: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help=f"What is done, a line of JSON each. [default: {_MANIFEST} beside the results]",
        ),
    ] = None,
    *,
    asked: Asked,
) -> None:
    """Turn many files from one projection into another, and leave out what is done.

    A result is done whose source, options and bytes are those of the manifest. Fields of PATTERN
    are {stem}, {name}, {suffix}, {parent}, {face} and {dir}, the folder below the first * of IN.
    """
    asked.check_names()
    if output == targets.STDOUT:
        raise UsageError("--output names files")
    if scheduler is not None:
        refuse(context, ["jobs"], "with --scheduler, whose workers do it")
    defaults = {field.name: field.default for field in fields(asked)}
    arguments: dict[str, Any] = {
        name: value
        for name, value in vars(asked).items()
        if value != defaults[name] and name not in _OF_THE_WAY
    }
    kept = Manifest(manifest or _fixed(output, "{") / _MANIFEST, arguments)
    pairs = [
        (source, targets.named(output, source, dir=folder))
        for source, folder in _found(patterns, kept.made())
    ]
    targets.check_apart(pairs)
    outputs = [out for _, out in pairs]
    options = asked.options(context, outputs)
    # Folders may have to be made yet.
    for place in {_nearest(out.parent) / f"a{out.suffix}" for out in outputs}:
        io.check_target(place, compression=asked.compression)
    every = [
        Job(str(source), source.absolute(), out.absolute(), options, retries)
        for source, out in pairs
    ]
    todo = [job for job in every if not kept.is_done(job)]
    failures = _all(todo, kept, jobs, scheduler)
    for job, failed in failures:
        said = as_options(failed.why, context.command.params)
        print(f"error: {job.name}: {said}", file=sys.stderr)
    there = len(every) - len(todo)
    print(
        f"{len(todo) - len(failures)} of {len(every)} images converted"
        + (f", {there} were there" if there else ""),
        file=sys.stderr if failures else sys.stdout,
    )
    if failures:
        raise typer.Exit(1)


def _all(
    todo: Sequence[Job], kept: Manifest, jobs: int | None, scheduler: str | None
) -> list[tuple[Job, Failed]]:
    """Do all jobs and return those that failed, in their order."""
    if not todo:
        return []
    cores = sm.get_num_threads()
    count = min(jobs or cores, len(todo))
    outcomes = (
        workers.on_processes(todo, count, max(1, cores // count))
        if scheduler is None
        else workers.on_cluster(todo, scheduler)
    )
    failures, warned = {}, set[str]()
    with progress(len(todo)) as step:
        step(f"{len(todo)} files")
        for job, outcome in outcomes:
            kept.note(job, outcome)
            if isinstance(outcome, Failed):
                failures[job.out] = outcome
            else:
                for line in outcome.warned:
                    if line not in warned:
                        print(line, file=sys.stderr)
                warned.update(outcome.warned)
            step(job.name)
            step.done()
    return [(job, failures[job.out]) for job in todo if job.out in failures]


def _found(patterns: Sequence[str], results: set[str]) -> Iterator[tuple[Path, str]]:
    """Yield the files that patterns stand for, and the folder of each below its pattern's root.

    What an earlier run has made is none of them.
    """
    for pattern in patterns:
        literal = os.path.exists(pattern)
        root = os.path.dirname(pattern) if literal else _fixed(pattern, *"*?[")
        names = [pattern] if literal else sorted(glob.glob(pattern, recursive=True))
        files = [Path(name) for name in names if os.path.isfile(name)]
        if not files:
            raise FileNotFoundError(f"no file is as {pattern!r}")
        for file in files:
            if os.path.abspath(file) not in results:
                yield file, os.path.relpath(file.parent, root or ".")


def _fixed(pattern: str, *marks: str) -> Path:
    """Return the folder that a pattern names before anything in it stands for more."""
    parts = Path(pattern).parts[:-1]
    open_ = [k for k, part in enumerate(parts) if any(mark in part for mark in marks)]
    return Path(*parts[: open_[0] if open_ else len(parts)])


def _nearest(folder: Path) -> Path:
    """Return a folder that is there: this one, or the nearest one that it is to lie in."""
    return next(place for place in (folder, *folder.parents) if place.exists())
