"""The process that makes the calls: limits on memory and time, and a verdict on each.

It writes the number of the call that it begins into a file, so that whoever started it knows at
which one it ended.
"""

from __future__ import annotations

import ast
import contextlib
import dis
import io
import json
import mmap
import os
import re
import resource
import signal
import struct
import sys
import tempfile
import types
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import spheremap as sm

from .calls import call

# What a call may take.
CPU_SECONDS = 10
# Seconds by the clock: it is a wait without end that this finds, on however busy a machine.
WAIT_SECONDS = 300
ROOM = 1 << 30

HERE = os.path.dirname(os.path.abspath(sm.__file__))
RAISES = {dis.opmap[name] for name in ("RAISE_VARARGS", "RERAISE") if name in dis.opmap}
# How messages of the compiled core begin, and Python's own about names of arguments.
OURS = re.compile(
    r"Expected |`|unknown |two conventions |projection '|filter '|grid '|[Aa]n? image|[Tt]he image|"
    r"There is no room|'[\w-]+' (has|is no) |[\w.]+\(\) (got|missing|takes)"
)


def main() -> None:
    """Make the calls of a seed from one number to another."""
    seed, first, last = map(int, sys.argv[1:4])
    place = open(sys.argv[4], "r+b")  # noqa: SIM115
    begun = mmap.mmap(place.fileno(), 8)
    names = {"sm": sm, "np": np, "nan": float("nan"), "inf": float("inf")}
    sm.set_num_threads(2)
    warm_up()
    os.chdir(tempfile.mkdtemp(prefix="fuzz", dir=os.path.dirname(sys.argv[4])))
    leave_junk()
    leave_video()
    limit_memory()
    report = os.fdopen(os.dup(1), "w")
    for index in range(first, last):
        begun[:] = struct.pack("q", index)
        text = call(seed, index)
        verdict = verdict_on(text, dict(names))
        if verdict is not None:
            report.write(json.dumps([index, *verdict]) + "\n")
            report.flush()
    begun[:] = struct.pack("q", last)


def verdict_on(text: str, names: dict[str, Any]) -> tuple[str, str] | None:
    """Make one call: return what is wrong with how it ended, or None."""
    call = ast.parse(text, mode="eval").body
    assert isinstance(call, ast.Call)
    limit_time(True)
    try:
        with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                function = made(call.func, names)
                given = [made(node, names) for node in call.args]
                named = {str(k.arg): made(k.value, names) for k in call.keywords}
            except BaseException as error:
                # What numpy does not make is no argument.
                return fault_of(error, text) if raised_in(error)[0].startswith(HERE) else None
            function(*given, **named)
    except BaseException as error:
        return fault_of(error, text)
    finally:
        limit_time(False)
        if "set_num_threads" in text:
            sm.set_num_threads(2)
    return None


def made(node: ast.expr, names: dict[str, Any]) -> Any:
    return eval(compile(ast.Expression(node), "<argument>", "eval"), names)


def fault_of(error: BaseException, text: str) -> tuple[str, str] | None:
    """Return what is wrong with an error."""
    file, line, instruction = raised_in(error)
    said = f"{type(error).__name__}: {error} [{os.path.relpath(file, HERE)}:{line}]"
    if isinstance(error, Warning):
        # Those that the library gives are no fault.
        ours = type(error).__module__.startswith("spheremap")
        ours |= type(error) is UserWarning and file.startswith(HERE)
        return None if ours else ("warning", said)
    # What converts an argument of the core says which in a note.
    named = any("while processing '" in note for note in getattr(error, "__notes__", ()))
    allowed: tuple[type[BaseException], ...] = (ValueError, TypeError, MemoryError)
    files = "sm.io.", "sm.tiles.", "sm.cameras.", "sm.video.", ".save(", "_file("
    if any(word in text for word in files):
        allowed += (OSError,)
    if named:
        # An integer beyond 64 bits.
        allowed += (OverflowError,)
    if not isinstance(error, allowed):
        return "exception", said
    if isinstance(error, MemoryError | OSError):
        # Whoever was asked for memory or a file says best what was missing.
        return None
    if not str(error).strip():
        return "no message", said
    by_us = file.startswith(HERE) and instruction in RAISES
    if by_us or named or OURS.match(str(error)):
        return None
    return "another library's message", said


def raised_in(error: BaseException) -> tuple[str, int, int]:
    """Return the file, the line and the instruction that an error comes from."""
    trace = error.__traceback__
    assert trace is not None
    while trace.tb_next is not None:
        trace = trace.tb_next
    code = trace.tb_frame.f_code
    return code.co_filename, trace.tb_lineno or 0, code.co_code[trace.tb_lasti]


def limit_time(on: bool) -> None:
    """Let the system end this process where a call takes too long."""
    signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS if on else 0)
    signal.setitimer(signal.ITIMER_REAL, WAIT_SECONDS if on else 0)


def limit_memory() -> None:
    """Allow no more memory than there is now, and some room."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + ROOM
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def warm_up() -> None:
    """Start threads and import what is imported late: their memory is no call's."""
    image = np.ones((64, 128, 3), np.float32)
    sm.convert(np.ones((512, 1024), np.float32), "latlong", "cube", size=256)
    sm.light.energy(image, "latlong")
    for name in ("sh", "packing", "healpix", "ball", "align", "tiles", "io"):
        assert isinstance(getattr(sm, name), types.ModuleType)
    with contextlib.suppress(ImportError):
        import OpenImageIO  # noqa: F401


def leave_junk() -> None:
    """Leave files that are none of what their names say."""
    rng = np.random.default_rng(0)
    for name in ("exr", "png", "hdr", "tif", "jpg", "mp4"):
        Path(f"junk.{name}").write_bytes(rng.bytes(500))
    os.mkdir("folder.exr")


def leave_video() -> None:
    """Leave a video that is one, where PyAV is."""
    with contextlib.suppress(ImportError):
        import av

        with av.open("sky.mkv", "w") as file:
            stream = file.add_stream("ffv1", rate=25, width=16, height=8)
            for shade in (20, 90):
                picture = np.full((8, 16, 3), shade, np.uint8)
                frame = av.VideoFrame.from_ndarray(picture).reformat(format="yuv420p")
                file.mux(stream.encode(frame))
            file.mux(stream.encode(None))
        sm.video.convert("sky.mkv", "warm.mp4", "latlong", "latlong", codec="libx264")


if __name__ == "__main__":
    main()
