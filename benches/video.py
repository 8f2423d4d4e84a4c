"""Time videos against ffmpeg's v360; write their part of BENCHMARKS.md.

    python benches/video.py            # rewrites the section
    python benches/video.py --quick    # a smoke test: few small frames, printed only

Times are of CPU, of all threads together and of ffmpeg's process: entrants take turns, and the
median of the rounds counts. Each makes a short film and a long one: a frame's time is their
difference, shared by the frames that one has more, and the start is what a film takes beside that
(v360 computes tables). ffmpeg's part of the remap alone is what v360 adds to decoding.
"""

from __future__ import annotations

import argparse
import random
import re
import resource
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import av
import imageio_ffmpeg
import numpy as np
import spheremap as sm
from measure import machine, publish, say, table
from spheremap.video.display import Display
from spheremap.video.frames import FrameConversion

BEGIN, END = "<!-- video: written by benches/video.py -->", "<!-- video: end -->"
FILTERS = {"nearest": "nearest", "bilinear": "linear", "catmull-rom": "cubic",
           "lanczos3": "lanczos"}  # fmt: skip
SRC, DST = "latlong:ffmpeg-output", "cube:ffmpeg-c3x2"
ENCODER = {"preset": "ultrafast", "crf": "23"}
Call = Callable[[], object]


def film(path: Path, shape: tuple[int, int], count: int) -> None:
    """Write frames of blocks that move, as H.264."""
    rng = np.random.default_rng(0)
    small = rng.integers(0, 256, (shape[0] // 16, shape[1] // 16, 3), np.uint8)
    with av.open(str(path), "w") as file:
        stream = file.add_stream("libx264", 25, width=shape[1], height=shape[0], options=ENCODER)
        for k in range(count):
            rgb = np.repeat(np.repeat(np.roll(small, k, 1), 16, 0), 16, 1)
            frame = av.VideoFrame.from_ndarray(rgb).reformat(format="yuv420p")
            frame.pts = k
            file.mux(stream.encode(frame))
        file.mux(stream.encode(None))


def ffmpeg(*arguments: object) -> Call:
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-y", *map(str, arguments)]
    return lambda: subprocess.run(command, check=True)


def cpu() -> float:
    """Return the seconds of CPU that this process and its children took."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def race(entrants: dict[str, Call], rounds: int) -> dict[str, float]:
    times: dict[str, list[float]] = {name: [] for name in entrants}
    order = random.Random(0)
    for call in entrants.values():
        call()
    for _ in range(rounds):
        for name, call in order.sample(list(entrants.items()), len(entrants)):
            start = cpu()
            call()
            times[name].append(cpu() - start)
    return {name: statistics.median(each) for name, each in times.items()}


def v360(interp: str, shape: tuple[int, int]) -> str:
    return f"v360=e:c3x2:interp={interp}:w={shape[1]}:h={shape[0]}"


def remap(
    path: Path,
    shape: tuple[int, int],
    count: int,
    filter: str,
    siting: str,
    *,
    antialias: bool = False,
) -> Call:
    """Return the conversion of as many frames, which are decoded."""
    with av.open(str(path)) as file:
        frame = next(file.decode(video=0))
    options = {"filter": filter, "antialias": antialias, "any_aspect": False}
    src, dst = sm.projection(SRC), sm.projection(DST)
    formats, sitings = (frame.format.name,) * 2, (siting, siting)
    work = FrameConversion(frame, formats, Display(), src, dst, shape, sitings, options)
    return lambda: [work.take_back(work(frame)) for _ in range(count)] and None


def frames_and_start(
    make: Callable[[str], dict[str, Call]], lengths: dict[str, int], rounds: int
) -> dict[str, tuple[float, float]]:
    """Return milliseconds of a frame, and of the start, of each entrant of a film."""
    entrants = {(name, film): call for film in lengths for name, call in make(film).items()}
    s = race({f"{name} {film}": call for (name, film), call in entrants.items()}, rounds)
    more = lengths["long"] - lengths["short"]
    found = {}
    for name in {name for name, _ in entrants}:
        frame = (s[f"{name} long"] - s[f"{name} short"]) / more * 1e3
        found[name] = frame, s[f"{name} short"] * 1e3 - lengths["short"] * frame
    return found


def rows(
    films: dict[str, Path], lengths: dict[str, int], shape: tuple[int, int], rounds: int
) -> list[list[str]]:
    body = []
    null = ("-f", "null", "-")
    for filter in FILTERS:
        say(f"remap alone, {filter}")
        effect = v360(FILTERS[filter], shape)

        def remapping(film: str, filter: str = filter, effect: str = effect) -> dict[str, Call]:
            path, count = films[film], lengths[film] // 2
            return {
                "decode": ffmpeg("-i", path, *null),
                "v360": ffmpeg("-i", path, "-vf", effect, *null),
                "ours": remap(path, shape, count, filter, "center"),
                "sited": remap(path, shape, count, filter, "left"),
                "default": remap(path, shape, count, filter, "left", antialias=True),
            }

        s = frames_and_start(remapping, lengths, rounds)
        theirs = s["v360"][0] - s["decode"][0], s["v360"][1] - s["decode"][1]
        # Half as many frames, which are all alike.
        ours, sited = ((2 * frame, start) for frame, start in (s["ours"], s["sited"]))
        body.append(row(f"remap alone, `{filter}`", theirs, ours, sited, 2 * s["default"][0]))
    target = films["long"].with_name("out.mp4")
    encode = [word for key, value in ENCODER.items() for word in (f"-{key}", value)]

    def converting(film: str) -> dict[str, Call]:
        path, effect = films[film], v360(FILTERS["bilinear"], shape)
        default = {"size": shape, "options": ENCODER}
        options = {"antialias": False, **default}
        return {
            "v360": ffmpeg("-i", path, "-vf", effect, "-c:v", "libx264", *encode, target),
            "ours": lambda: sm.video.convert(path, target, SRC, DST, siting="center", **options),
            "sited": lambda: sm.video.convert(path, target, SRC, DST, **options),
            "default": lambda: sm.video.convert(path, target, SRC, DST, **default),
        }

    say("decode, convert, encode")
    s = frames_and_start(converting, lengths, rounds)
    ours = s["ours"], s["sited"], s["default"][0]
    body.append(row("decode, convert, encode, `bilinear`", s["v360"], *ours))
    return body


def row(
    what: str,
    theirs: tuple[float, float],
    ours: tuple[float, float],
    sited: tuple[float, float],
    default: float,
) -> list[str]:
    each = [theirs[0], ours[0], sited[0], default]
    of_100 = [frame + start / 100 for frame, start in (theirs, ours, sited)]
    return [
        what,
        *(f"{t:.0f}" for t in each),
        f"{each[0] / each[1]:.2f}×",
        f"{theirs[1]:.0f}",
        f"{max(ours[1], 0):.0f}",
        f"{of_100[0] / of_100[1]:.2f}×",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a smoke test with small frames")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--remark", default="", help="what to say of the machine")
    args = parser.parse_args()
    source, shape = (1920, 3840), (1920, 2880)
    lengths = {"short": 10, "long": 40}
    if args.quick:
        source, shape, lengths = (192, 384), (192, 288), {"short": 4, "long": 8}
    with tempfile.TemporaryDirectory() as folder:
        films = {name: Path(folder) / f"{name}.mp4" for name in lengths}
        for name, path in films.items():
            film(path, source, lengths[name])
        body = rows(films, lengths, shape, args.rounds)
    said = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), "-version"], capture_output=True, text=True, check=True
    ).stdout
    version = (re.findall(r"version n?([\d.]+)", said) or ["?"])[0]
    remark = args.remark and f", {args.remark}"
    text = [
        BEGIN,
        "## Video",
        f"Milliseconds of CPU a frame, {source[1]}×{source[0]} yuv420p to a cube of "
        f"{shape[1]}×{shape[0]} (c3x2), `antialias=False` but for one column, which are our "
        f"defaults: v360 never antialiases; medians of {args.rounds} rounds in "
        f"turn, of films of {lengths['short']} and {lengths['long']} frames; {machine()}{remark}; "
        f"ffmpeg {version}, PyAV {av.__version__}. v360 takes chroma as if it were sited in the "
        'center, "center" here; files of H.264 have it on the left. The start is what comes once; '
        "the last column is the ratio of films of 100 frames with it. Encoded by x264, ultrafast.",
        table(
            [
                "work",
                "v360",
                "ours, center",
                "ours, left",
                "antialiased",
                "ratio",
                "start, v360",
                "start, ours",
                "ratio of 100 frames",
            ],
            body,
        ),
        END,
    ]
    publish(text, args.quick)


if __name__ == "__main__":
    main()
