"""Where a command writes to: names made of the input's, one file a face, standard output."""

from __future__ import annotations

import os
import string
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import spheremap as sm
from spheremap.cli.terminal import UsageError
from spheremap.io.images import TEXTURES

STDOUT = "-"
# The names of the faces toward +x, -x, +y, -y, +z and -z, and by number.
FACES = {
    "px": ("px", "nx", "py", "ny", "pz", "nz"),
    "posx": ("posx", "negx", "posy", "negy", "posz", "negz"),
    "0": ("0", "1", "2", "3", "4", "5"),
}
# Programs that look up a face with an axis negated, and give files and layers the names that they
# look up: theirs are in the order of the hardware's table, and `px` or `pz` shows the other side.
_NEGATING = ("threejs", "playcanvas", "bevy")


def check_apart(pairs: Sequence[tuple[Path, Path]]) -> None:
    """Raise a usage error where a result would replace another, or the input of another."""
    inputs = {path.resolve() for path, _ in pairs}
    taken = set()
    for path, out in pairs:
        place = out.resolve()
        if place in inputs and place != path.resolve():
            raise UsageError(f"the result of {str(path)!r} would replace {str(out)!r}, an input")
        if place in taken:
            raise UsageError(f"several images would be written to {str(out)!r}; use {{stem}}")
        taken.add(place)


def check_outputs(outputs: Sequence[Path], layout: str | None, faces: int) -> None:
    """Raise a usage error where names and faces do not go together."""
    for out in outputs:
        if (layout == "faces" and out.suffix.lower() not in TEXTURES) != has_faces(out):
            raise UsageError(
                "a file holds one image: --layout faces needs {face} in the name of OUT, "
                "and {face} needs it"
            )
        if out.suffix.lower() in TEXTURES and faces not in (1, 6):
            raise UsageError(f"{out.suffix} holds a cube or one image, not {faces} faces")


def named(pattern: str, source: Path, **more: str) -> Path:
    """Return where the result of an input goes: {stem}, {name}, {suffix}, {parent} are its own.

    So are those that a command has more.
    """
    fields = {
        "stem": source.stem,
        "name": source.name,
        "suffix": source.suffix,
        "parent": str(source.parent),
        **more,
        "face": "{face}",
    }
    try:
        used = {field for _, field, _, _ in string.Formatter().parse(pattern) if field is not None}
    except ValueError as error:
        raise UsageError(f"--output {pattern!r}: {error}") from None
    for field in used:
        if field not in fields:
            *others, last = (f"{{{known}}}" for known in fields)
            raise UsageError(
                f"--output {pattern!r} has {{{field}}}; there are {', '.join(others)} and {last}"
            )
    return Path(pattern.format(**fields))


def has_faces(path: Path) -> bool:
    """Tell whether a name stands for a file a face."""
    return "{face}" in path.name


def face_paths(path: Path, names: Sequence[str]) -> list[Path]:
    """Return the file of each face."""
    return [path.with_name(path.name.replace("{face}", name)) for name in names]


def places(path: Path, projection: sm.Projection, style: str) -> list[Path]:
    """Return the files that a result is: one, or one a face."""
    return face_paths(path, face_names(projection, style)) if has_faces(path) else [path]


def face_names(projection: sm.Projection, style: str) -> tuple[str, ...]:
    """Return the name of each face: its program's, by the axis at its center, or its number."""
    count = projection.faces
    if style == "0" or count != 6:
        return tuple(str(k) for k in range(count))
    if projection.convention in _NEGATING:
        return FACES[style]
    places = np.array([(0.5, 0.5, k) for k in range(count)])
    directions = projection.decode(places)
    axes = np.abs(directions).argmax(axis=-1)
    signs = np.take_along_axis(directions, axes[:, np.newaxis], axis=-1)[:, 0] < 0
    return tuple(
        FACES[style][2 * axis + negative] for axis, negative in zip(axes, signs, strict=True)
    )


def found_faces(path: Path, projection: sm.Projection) -> list[Path]:
    """Return the files of the faces of an input, named in whichever way is there."""
    for style in FACES:
        paths = face_paths(path, face_names(projection, style))
        if all(place.exists() for place in paths):
            return paths
    missing = next(place for place in face_paths(path, face_names(projection, "px")))
    raise FileNotFoundError(f"no such file: {str(missing)!r}, nor as posx or 0")


def to_stdout(suffix: str, write: Callable[[Path], None]) -> None:
    """Write a file and hand its bytes to standard output."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / f"out{suffix}"
        write(place)
        sys.stdout.flush()
        with open(place, "rb") as file, os.fdopen(os.dup(1), "wb") as out:
            while part := file.read(1 << 20):
                out.write(part)
