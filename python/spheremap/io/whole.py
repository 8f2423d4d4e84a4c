"""Files that appear whole or not at all.

A file is written beside its place, brought to the disk and renamed. Its name tells who writes it:
what a process left that was killed is removed by the next one that writes into the folder.

Of many files in a new folder, nothing is left and none is of use before the last: they are brought
to the disk together. One by one, that took ten times as long as writing them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

__all__ = [
    "as_path",
    "bring_to_disk",
    "check_place",
    "write_bytes",
    "written_among",
    "written_whole",
]

_MARK = "spheremap-part"
_LEFT = re.compile(rf"\..*\.{_MARK}-(\d+)-[0-9a-f]{{8}}(\.[^.]*)?")


def as_path(path: object) -> str:
    """Return a path as text that a file system can have."""
    try:
        text = os.fsdecode(path)  # type: ignore[arg-type]
    except TypeError:
        kind = type(path).__name__
        raise TypeError(f"Expected `path` to be a path, got {kind}.") from None
    if "\0" in text or any("\ud800" <= c <= "\udfff" for c in text):
        raise ValueError(f"Expected `path` to be a path, got {text!r:.80}.")
    return text


def check_place(target: Path, name: str) -> None:
    """Raise an OSError where no file can be written; `name` is what the caller called it."""
    if target.is_dir():
        raise IsADirectoryError(f"cannot write {name!r}: it is a folder")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"cannot write {name!r}: no folder {str(target.parent)!r}")
    # The rename asks the folder alone; a file that its owner protected must stay as well.
    for place in (target.parent, target):
        if place.exists() and not os.access(place, os.W_OK):
            raise PermissionError(f"cannot write {name!r}: no permission to write {str(place)!r}")


def written_whole(target: Path, write: Callable[[Path], None]) -> None:
    """Call `write` with a place beside the target, then put what it wrote there.

    Parameters
    ----------
    target : Path
        With symbolic links resolved: a rename would replace them.
    write : callable
        Gets a path with the target's extension, and raises OSError where it cannot write.

    Raises
    ------
    OSError
        As `write` does, and where the disk does not take what was written.
    """
    _remove_left(target.parent)
    _written(target, write, at_once=True)


def written_among(target: Path, write: Callable[[Path], None]) -> None:
    """Do as `written_whole` for one of many files in a new folder, which `bring_to_disk` is for."""
    _written(target, write, at_once=False)


def bring_to_disk(folder: Path) -> None:
    """Wait until the disk has all files of a folder; an OSError where it does not take them."""
    if hasattr(os, "sync"):
        os.sync()
    for place, _, names in os.walk(folder):
        for name in names:
            _bring(Path(place, name))


def _bring(file: Path) -> None:
    with open(file, "rb+") as held:
        os.fsync(held.fileno())


def _written(target: Path, write: Callable[[Path], None], at_once: bool) -> None:
    name = f".{target.stem}.{_MARK}-{os.getpid()}-{os.urandom(4).hex()}{target.suffix}"
    beside = target.with_name(name)
    try:
        write(beside)
        if at_once:
            # A full disk may show only when bytes are brought to it.
            _bring(beside)
        os.replace(beside, target)
    finally:
        with suppress(OSError):
            beside.unlink()


def write_bytes(
    path: str | os.PathLike[str], data: bytes, put: Callable[..., None] = written_whole
) -> None:
    """Write a file whole or not at all."""
    name = as_path(path)
    target = Path(os.path.realpath(name))

    def write(place: Path) -> None:
        place.write_bytes(data)

    try:
        check_place(target, name)
        put(target, write)
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(f"cannot write {name!r}: {error.strerror}") from None


def _remove_left(folder: Path) -> None:
    """Remove what processes that are no more left half written."""
    with suppress(OSError):
        for name in os.listdir(folder):
            found = _MARK in name and _LEFT.fullmatch(name)
            if found and not _is_alive(int(found[1])):
                with suppress(OSError):
                    (folder / name).unlink()


def _is_alive(process: int) -> bool:
    if os.name != "posix":
        # Asking would end it there.
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True
