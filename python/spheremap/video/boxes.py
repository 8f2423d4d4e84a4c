"""The boxes of MP4 and QuickTime files: more put into the index of a finished one.

A box is its length in 4 bytes, its name in 4, and what it holds; a length of 1 says that it stands
in 8 bytes behind the name (ISO/IEC 14496-12, 4.2).
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

__all__ = ["add", "box", "full_box", "identified"]

_HEAD = 8
# What boxes hold before other boxes (ISO/IEC 14496-12, 8.5.2).
_FIELDS = {b"stsd": 8}


def box(name: bytes, *parts: bytes) -> bytes:
    """Return a box that holds these."""
    held = b"".join(parts)
    return struct.pack(">I4s", _HEAD + len(held), name) + held


def full_box(name: bytes, *parts: bytes) -> bytes:
    """Return a box of version 0 without flags."""
    return box(name, bytes(4), *parts)


def add(path: Path, to_track: bytes, to_description: bytes) -> None:
    """Put boxes into the video track of a file whose index lies behind its frames.

    Nothing else moves, so that no place in the file that the index names changes.

    Parameters
    ----------
    path : Path
        An MP4 or QuickTime file.
    to_track, to_description : bytes
        Boxes for the end of its first video's ``trak``, and of the description of its samples.

    Raises
    ------
    ValueError
        For a file without a video, or whose index is not the last thing in it.
    """

    def described(held: bytes) -> bytes:
        (name, entry), *rest = _boxes(held)
        return b"".join([box(name, entry, to_description), *(box(n, h) for n, h in rest)])

    def tracked(held: bytes) -> bytes:
        where = (b"mdia", b"minf", b"stbl", b"stsd")
        return _changed(held, where, described) + to_track

    with open(path, "rb+") as file:
        start, index = _index(file)
        held, is_done = [], False
        for name, inner in _boxes(index):
            is_ours = name == b"trak" and not is_done and _is_video(inner)
            is_done |= is_ours
            held.append(box(name, tracked(inner) if is_ours else inner))
        if not is_done:
            raise ValueError(f"no video in {str(path)!r}")
        file.seek(start)
        file.write(box(b"moov", *held))


def identified(path: str, identity: bytes) -> bytes:
    """Return what the first video's box of a UUID holds; nothing where there is none.

    Of any file: others have no index.
    """
    with open(path, "rb") as file:
        index = next((held for _, _, held in _indices(file)), b"")
    for name, inner in _boxes(index):
        if name == b"trak" and _is_video(inner):
            found = (held for n, held in _boxes(inner) if n == b"uuid" and held[:16] == identity)
            return next(found, b"")[16:]
    return b""


def _index(file: BinaryIO) -> tuple[int, bytes]:
    """Return where the index begins, and what it holds."""
    size = file.seek(0, 2)
    for start, end, held in _indices(file):
        if end == size:
            return start, held
    raise ValueError("Expected a file with its index at the end.")


def _indices(file: BinaryIO) -> Iterator[tuple[int, int, bytes]]:
    """Yield where indices of a file begin and end, and what they hold."""
    size, start = file.seek(0, 2), 0
    while start + _HEAD <= size:
        file.seek(start)
        length, name = struct.unpack(">I4s", file.read(_HEAD))
        if length == 1:
            (length,) = struct.unpack(">Q", file.read(8))
        if length < _HEAD:
            return
        if name == b"moov":
            yield start, start + length, file.read(length - _HEAD)
        start += length


def _boxes(data: bytes) -> list[tuple[bytes, bytes]]:
    """Return the names of boxes, and what they hold."""
    found, at = [], 0
    while at + _HEAD <= len(data):
        length, name = struct.unpack_from(">I4s", data, at)
        found.append((name, data[at + _HEAD : at + length]))
        at += max(length, _HEAD)
    return found


def _changed(data: bytes, path: tuple[bytes, ...], change: Callable[[bytes], bytes]) -> bytes:
    """Return boxes, one of which is changed; its path are the names of those around it, and its."""
    if not path:
        return change(data)
    parts, is_done = [], False
    for name, held in _boxes(data):
        if name == path[0] and not is_done:
            fields = _FIELDS.get(name, 0)
            held, is_done = held[:fields] + _changed(held[fields:], path[1:], change), True
        parts.append(box(name, held))
    return b"".join(parts)


def _is_video(track: bytes) -> bool:
    for name, held in _boxes(track):
        if name == b"mdia":
            return any(n == b"hdlr" and h[8:12] == b"vide" for n, h in _boxes(held))
    return False
