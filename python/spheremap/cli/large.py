"""One file of `spheremap convert --memory`: part by part, in the memory that it is given."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING

import spheremap as sm
from spheremap import io
from spheremap.cli import files, targets
from spheremap.cli.conversion import Options, convert_file, map_of_file, refuse_existing
from spheremap.cli.steps import Step
from spheremap.cli.terminal import UsageError, tell_worlds
from spheremap.io.images import STORED
from spheremap.resample.conversion import needs_chain

if TYPE_CHECKING:
    from spheremap.io import Header

__all__ = ["IDLE", "as_bytes", "convert_any"]

# Options that need the whole image at once, or change its texels.
IDLE = (
    "face_sun", "alpha", "skipna", "channels", "drop_alpha", "half", "float_", "bits",
    "colorspace", "tonemap", "exposure", "preview", "mips",
)  # fmt: skip

_BYTES = re.compile(r"(\d+)\s*([kmgt]?)(?:i?b)?", re.IGNORECASE)


def as_bytes(text: str) -> int:
    """Return 536870912 of "512M"."""
    found = _BYTES.fullmatch(text)
    if found is None:
        raise UsageError(f"--memory is a number of bytes, as 512M or 4G; got {text!r}")
    return int(found[1]) << (10 * " kmgt".index(found[2].lower() or " "))


def convert_any(
    source: Path, out: Path, options: Options, step: Step, stdout: str | None
) -> list[str]:
    """Convert a file, in parts where memory is said, and return what there is to say of it."""
    work = convert_file if options.memory is None else _convert_large
    return work(source, out, options, step, stdout)


def _convert_large(
    source: Path, out: Path, options: Options, step: Step, stdout: str | None
) -> list[str]:
    if stdout or targets.has_faces(out) or targets.has_faces(source):
        raise UsageError("--memory is for one file into one file")
    if needs_chain(options.filter):
        raise UsageError(f"--memory has no --filter {options.filter}, which needs all at once")
    refuse_existing([out], options)
    head = io.header(source, part=options.part)
    _expect_kept(source, out, head)
    src, assumed = map_of_file(source, head.projection, (head.height, head.width), options)
    step(f"converting {source.name}: {files.described(src)} to {files.described(options.dst)}")
    tell_worlds(src, options.dst, options.world)
    start = time.perf_counter()
    with step.listening():
        made = io.convert_file(
            source,
            out,
            src,
            options.dst,
            size=options.size,
            memory=options.memory or 0,
            rotation=sm.rotation(*options.rotate) if any(options.rotate) else None,
            filter=options.filter,
            fill=options.fill,
            antialias=not options.alias,
            world=options.world,
            any_aspect=True,
            part=options.part,
            compression=options.compression,
            noted=files.noted(options.to, options.dst),
            resume=options.resume,
        )
    said = (
        f"{out}: {files.described(options.dst)}, {made.width} x {made.height}, "
        f"{', '.join(made.channels)}, {made.dtype}; in {time.perf_counter() - start:.1f} s"
    )
    return [said, *assumed]


def _expect_kept(source: Path, out: Path, head: Header) -> None:
    """Raise a usage error for what would change texels on their way."""
    kinds = STORED.get(out.suffix.lower(), ())
    if head.dtype not in kinds and not (head.dtype == "float16" and "float32" in kinds):
        raise UsageError(
            f"--memory keeps types: {out.suffix} holds {', '.join(kinds) or 'none'}, and "
            f"{str(source)!r} has {head.dtype}"
        )
    if head.alpha == "straight":
        raise UsageError(
            f"--memory weights no colors, and {str(source)!r} has straight alpha: "
            "premultiply it first"
        )
