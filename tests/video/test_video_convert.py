"""Videos: planes are those of plans to the bit, times and audio stay, and it is nearer the truth
than ffmpeg's v360."""

from __future__ import annotations

import signal
import struct
import subprocess
import sys
from pathlib import Path

import av
import filming
import numpy as np
import pytest
import spheremap as sm
from oracles import ffmpeg_oracle

SHAPE = (64, 128)


def sky(path: Path, count: int = 3, kind: str = "yuv420p", **more: object) -> Path:
    frames = [filming.rendered("latlong", SHAPE, k, kind) for k in range(count)]
    return filming.film(path, frames, kind, **more)  # type: ignore[arg-type]


def expected(plane: np.ndarray, black: float, dst: str, size: int, **options: object) -> np.ndarray:
    return sm.convert(plane, "latlong", dst, size=size, fill=black, **options)


@pytest.mark.parametrize("kind", ["yuv420p", "yuv420p10le", "yuv444p"])
@pytest.mark.parametrize("dst", ["cube:ffmpeg-c3x2", "angular(fov=180)", "latlong"])
def test_planes_are_those_of_convert(kind: str, dst: str, tmp_path: Path) -> None:
    source, target = sky(tmp_path / "in.mkv", kind=kind), tmp_path / "out.mkv"
    turn = sm.rotation(20, 10, 5)
    done = sm.video.convert(source, target, "latlong", dst, size=48, rotation=turn, siting="center")
    assert (done.frames, done.codec, done.pixel_format) == (3, "ffv1", kind)
    unit = 4 if kind.endswith("10le") else 1
    for before, after in zip(filming.read(source), filming.read(target), strict=True):
        for k, (plane, got) in enumerate(zip(before, after, strict=True)):
            side = 48 * plane.shape[0] // SHAPE[0]
            black = (128 if k else 16) * unit
            assert np.array_equal(got, expected(plane, black, dst, side, rotation=turn))


def test_chroma_sited_left_is_that_of_a_turned_panorama(tmp_path: Path) -> None:
    source, target = sky(tmp_path / "in.mkv"), tmp_path / "out.mkv"
    sm.video.convert(source, target, "latlong", "latlong", size=48)
    for before, after in zip(filming.read(source), filming.read(target), strict=True):
        assert np.array_equal(after[0], expected(before[0], 16, "latlong", 48))
        for plane, got in zip(before[1:], after[1:], strict=True):
            # A quarter of a texel to the left: of 64 columns, and of 48.
            there = sm.projection("latlong").turned(sm.rotation(360 / 4 / 64))
            here = sm.projection("latlong").turned(sm.rotation(360 / 4 / 48))
            want = sm.convert(plane, there, here, size=24, fill=128)
            # The turn is found by a fit: a sum that is halfway between two bytes may go either way.
            assert np.abs(got.astype(int) - want).max() <= 1
            assert (got == want).mean() > 0.99


@pytest.mark.parametrize(
    ("src", "dst", "shape", "effect"),
    [
        ("latlong:ffmpeg-output", "cube:ffmpeg-c3x2", (128, 192), "e:c3x2"),
        ("latlong:ffmpeg-output", "perspective(fov=90):ffmpeg", (128, 128),
         "e:flat:h_fov=90:v_fov=90"),
        ("dual_fisheye(fov=190):ffmpeg", "latlong:ffmpeg-output", (128, 256),
         "dfisheye:e:ih_fov=190:iv_fov=190"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("filter, interp", [("bilinear", "linear"), ("catmull-rom", "cubic")])
def test_it_is_nearer_the_truth_than_v360(
    src: str, dst: str, shape: tuple[int, int], effect: str, filter: str, interp: str,
    tmp_path: Path,
) -> None:  # fmt: skip
    frames = [filming.rendered(src, (128, 256), k, "yuv420p") for k in range(2)]
    source, target = filming.film(tmp_path / "in.mkv", frames), tmp_path / "out.mkv"
    sm.video.convert(source, target, src, dst, size=shape, filter=filter, antialias=False)
    v360 = f"v360={effect}:interp={interp}:w={shape[1]}:h={shape[0]}"
    theirs = tmp_path / "theirs.mkv"
    command = [ffmpeg_oracle.program(), "-loglevel", "error", "-i", str(source), "-vf", v360]
    subprocess.run([*command, "-c:v", "ffv1", str(theirs)], check=True)
    for k, (a, b) in enumerate(zip(filming.read(target), filming.read(theirs), strict=True)):
        truth = filming.rendered(dst, shape, k, "yuv420p")
        for ours, other, plane in zip(a, b, truth, strict=True):
            assert filming.psnr(ours, plane) > filming.psnr(other, plane)


@pytest.mark.parametrize("dst", ["latlong:ffmpeg-output", "cube:ffmpeg-c3x2"])
def test_chroma_on_the_corner(dst: str, tmp_path: Path) -> None:
    shape = sm.projection(dst).shape(64)
    corner = (-0.25, -0.25)
    src = "latlong:ffmpeg-output"
    frame = filming.rendered(src, (128, 256), 1, "yuv420p", corner)
    source, target = filming.film(tmp_path / "in.mkv", [frame]), tmp_path / "out.mkv"
    truth = filming.rendered(dst, shape, 1, "yuv420p", corner)
    found = {}
    for siting in ("top-left", "left"):
        sm.video.convert(source, target, src, dst, size=shape, siting=siting)  # type: ignore[arg-type]
        found[siting] = [filming.psnr(a, b) for a, b in zip(filming.read(target)[0], truth,
                                                            strict=True)]  # fmt: skip
    assert found["top-left"][0] == found["left"][0]
    assert all(a > b for a, b in zip(found["top-left"][1:], found["left"][1:], strict=True)), found


@pytest.mark.parametrize("wanted", filming.RATIOS)
@pytest.mark.parametrize("kind", filming.RATIOS)
@pytest.mark.parametrize(
    ("dst", "shape"), [("latlong:ffmpeg-output", (128, 256)), ("cube:ffmpeg-c3x2", (128, 192))]
)
def test_chroma_of_another_size_lies_as_it_is_sited(
    kind: str, wanted: str, dst: str, shape: tuple[int, int], tmp_path: Path
) -> None:
    src = "latlong:ffmpeg-output"
    frame = filming.rendered(src, (128, 256), 1, kind)
    source, target = filming.film(tmp_path / "in.mkv", [frame], kind), tmp_path / "out.mkv"
    done = sm.video.convert(
        source, target, src, dst, size=shape, pixel_format=wanted, filter="catmull-rom"
    )
    assert done.pixel_format == wanted
    (got,), truth = filming.read(target), filming.rendered(dst, shape, 1, wanted)
    for a, b in zip(got, truth, strict=True):
        # 44 dB and more where texels are lost, else 50; half a texel of luma aside 41 at most.
        assert a.shape == b.shape and (np.array_equal(a, b) or filming.psnr(a, b) > 43)


def test_chroma_of_jpeg_lies_in_the_center(tmp_path: Path) -> None:
    frame = filming.rendered("latlong", (128, 256), 1, "yuv420p")
    source, target = filming.film(tmp_path / "in.mkv", [frame]), tmp_path / "out.mkv"
    lossless = {"codec": "libx264", "options": {"qp": "0"}}
    sm.video.convert(source, target, "latlong", "latlong", pixel_format="yuvj420p", **lossless)  # type: ignore[arg-type]
    (got,) = filming.read(target)
    center = filming.rendered("latlong", (128, 256), 1, "yuv420p", (0, 0))
    for ours, a, b in zip(got[1:], center[1:], frame[1:], strict=True):
        # Bytes of full range are 255/224 of others.
        narrow = 128 + (ours - 128.0) * 224 / 255
        assert filming.psnr(narrow, a) > filming.psnr(narrow, b) + 5


def test_rgb_and_chroma(tmp_path: Path) -> None:
    whole = filming.rendered("latlong", (128, 256), 1, "yuv444p")
    halved = filming.rendered("latlong", (128, 256), 1, "yuv420p")
    source, target = tmp_path / "in.mkv", tmp_path / "out.mkv"
    # Paler, so that all of it has an RGB.
    pale = [[(96 + plane // 4).astype(np.uint8) for plane in planes] for planes in (whole, halved)]
    sm.video.convert(
        filming.film(source, [pale[1]]), target, "latlong", "latlong", pixel_format="bgr0"
    )
    with av.open(str(target)) as file:
        (frame,) = file.decode(video=0)
        # BT.601 of limited range, as of most video.
        found = filming.arrays(frame.reformat(format="yuv444p", dst_color_range=1))
    sm.video.convert(target, source, "latlong", "latlong", pixel_format="yuv420p")
    for got, truth in ((found, pale[0]), (filming.read(source)[0], pale[1])):
        for a, b in zip(got, truth, strict=True):
            # Two roundings, to bytes of RGB and of Y'CbCr, are 0.17 to 0.24; chroma that is half a
            # texel of luma aside has 0.48 and 0.8 before any.
            assert np.mean((a.astype(float) - b) ** 2) < 0.3


def test_what_is_rgb_says_so(tmp_path: Path) -> None:
    red = np.full((64, 128, 3), (200, 60, 20), np.uint8)
    source, target = tmp_path / "in.mkv", tmp_path / "out.mkv"
    frame = av.VideoFrame.from_ndarray(red).reformat(format="gbrp")
    with av.open(str(source), "w") as file:
        stream = file.add_stream("libx264rgb", rate=25, width=128, height=64, options={"qp": "0"})
        stream.pix_fmt = "bgr24"
        file.mux([*stream.encode(frame.reformat(format="bgr24")), *stream.encode(None)])
    for codec, kind in (("libx264", "yuv444p"), ("libx264rgb", "bgr24")):
        sm.video.convert(source, target, "latlong", "latlong", codec=codec, pixel_format=kind)
        with av.open(str(target)) as file:
            (frame,) = file.decode(video=0)
        # By the encoder's loss, and bytes of Y'CbCr.
        assert np.abs(frame.to_ndarray(format="rgb24") - red.astype(int)).max() <= 2
        source = target.replace(source)


MATRIX = (1, 0, 0, 1)


def shown(path: Path, matrix: tuple[float, ...]) -> Path:
    """Write into an MP4 file how its frames are shown."""

    def packed(a: float, b: float, c: float, d: float) -> bytes:
        parts = (round(65536 * x) for x in (a, b, 0, c, d, 0, 0, 0))
        return struct.pack(">9i", *parts, 1 << 30)

    data = path.read_bytes()
    at = data.index(packed(*MATRIX), data.index(b"tkhd"))
    path.write_bytes(data[:at] + packed(*matrix) + data[at + 36 :])
    return path


@pytest.mark.parametrize(
    "matrix",
    [
        MATRIX, (-1, 0, 0, -1), (-1, 0, 0, 1), (1, 0, 0, -1),
        (0, 1, -1, 0), (0, -1, 1, 0), (0, 1, 1, 0), (0, -1, -1, 0),
    ],
)  # fmt: skip
def test_frames_are_those_that_ffmpeg_shows(
    matrix: tuple[int, int, int, int], tmp_path: Path
) -> None:
    frames = [filming.rendered("perspective(fov=90, aspect=2)", SHAPE, 1, "yuv444p")]
    lossless = {"codec": "libx264", "options": {"qp": "0"}}
    path = shown(filming.film(tmp_path / "in.mp4", frames, "yuv444p", **lossless), matrix)  # type: ignore[arg-type]
    theirs = tmp_path / "theirs.mkv"
    command = [ffmpeg_oracle.program(), "-loglevel", "error", "-i", str(path), "-c:v", "ffv1"]
    subprocess.run([*command, str(theirs)], check=True)
    results = []
    for source in (path, theirs):
        target = tmp_path / "out.mkv"
        aspect = 2 if matrix[0] else 0.5
        src = f"perspective(fov=90, aspect={aspect})"
        sm.video.convert(source, target, src, "latlong", size=32, codec="ffv1")
        results.append(filming.read(target)[0])
    assert all(np.array_equal(a, b) for a, b in zip(*results, strict=True))


def test_chroma_is_turned_with_frames(tmp_path: Path) -> None:
    """What is sited left and shown upside down is right of the center."""
    right = filming.rendered("latlong", (128, 256), 1, "yuv420p", (0.25, 0))
    stored = [np.ascontiguousarray(plane[::-1, ::-1]) for plane in right]
    lossless = {"codec": "libx264", "options": {"qp": "0"}}
    path = shown(filming.film(tmp_path / "in.mp4", [stored], **lossless), (-1, 0, 0, -1))  # type: ignore[arg-type]
    target = tmp_path / "out.mkv"
    sm.video.convert(path, target, "latlong", "latlong", codec="ffv1", filter="catmull-rom")
    truth = filming.rendered("latlong", (128, 256), 1, "yuv420p")
    for a, b in zip(filming.read(target)[0], truth, strict=True):
        # 50 dB; 41 where chroma is half a texel of luma aside.
        assert np.array_equal(a, b) or filming.psnr(a, b) > 48


def test_other_turns_are_refused(tmp_path: Path) -> None:
    path = shown(sky(tmp_path / "in.mp4", 1, codec="libx264"), (0.6, 0.8, -0.8, 0.6))
    with pytest.raises(ValueError, match="shown turned by -53"):
        sm.video.convert(path, path, "latlong", "cube")


def test_nothing_else_is_lost(tmp_path: Path) -> None:
    """Of H.264 without loss in MP4, of another speed in each frame, with audio."""
    # In 1/90000 s.
    times = [0, 3600, 5400, 12600, 18000]
    source = sky(
        tmp_path / "in.mp4", 5, codec="libx264", options={"qp": "0"}, times=times, audio=True
    )
    target = tmp_path / "out.mp4"
    sm.video.convert(source, target, "latlong", "cube", options={"qp": "0"})
    assert filming.times(target) == filming.times(source)
    assert [float(t) for t in filming.times(target)] == [t / 90000 for t in times]
    assert filming.sounds(target) == filming.sounds(source)
    assert len(filming.sounds(target)) > 5
    sm.video.convert(source, target, "latlong", "cube", audio=False)
    with pytest.raises(IndexError):
        filming.sounds(target)


def test_frames_that_are_reordered_keep_their_times(tmp_path: Path) -> None:
    source = sky(tmp_path / "in.mp4", 8, codec="libx264", options={"crf": "30", "bf": "3"})
    target = tmp_path / "out.mp4"
    sm.video.convert(source, target, "latlong", "latlong", size=32, options={"bf": "3"})
    assert filming.times(target) == filming.times(source)
    assert len(filming.times(target)) == 8


@pytest.mark.parametrize(
    ("codec", "kind", "ending"),
    [
        ("libx264", "yuv420p10le", "mp4"),
        ("libx265", "yuv420p10le", "mp4"),
        ("libvpx-vp9", "yuv420p", "webm"),
        ("prores_ks", "yuv422p10le", "mov"),
        ("mpeg2video", "yuv420p", "mkv"),
        ("mjpeg", "yuvj420p", "mkv"),
        ("ffv1", "bgr0", "mkv"),
        ("ffv1", "gray", "mkv"),
        ("ffv1", "yuva420p", "mkv"),
    ],
)
def test_every_codec(codec: str, kind: str, ending: str, tmp_path: Path) -> None:
    target = tmp_path / f"out.{ending}"
    sm.video.convert(
        sky(tmp_path / "in.mkv"), target, "latlong", "cube:ffmpeg-c3x2", size=(64, 96),
        codec=codec, pixel_format=kind,
    )  # fmt: skip
    again = tmp_path / f"again.{ending}"
    done = sm.video.convert(target, again, "cube:ffmpeg-c3x2", "latlong", size=(64, 128))
    assert (done.frames, done.pixel_format, done.shape) == (3, kind, (64, 128))
    assert len(filming.times(again)) == 3


def test_chroma_of_half_the_width_alone_goes_through_faces(tmp_path: Path) -> None:
    """Squares are no squares then."""
    source, cube, back = sky(tmp_path / "in.mkv", 1, "yuv422p"), *tmp_path_pair(tmp_path)
    for siting in ("left", "center"):
        options = {"filter": "catmull-rom", "antialias": False, "siting": siting}
        sm.video.convert(source, cube, "latlong", "cube", size=64, **options)
        sm.video.convert(cube, back, "cube", "latlong", size=SHAPE, **options)
        (before,), (after,) = filming.read(source), filming.read(back)
        for a, b in zip(before, after, strict=True):
            # 50 dB and more; where one of the two took the other siting it is 29 to 31.
            assert filming.psnr(a, b) > 45


def tmp_path_pair(folder: Path) -> tuple[Path, Path]:
    return folder / "cube.mkv", folder / "back.mkv"


def test_rotation_over_time(tmp_path: Path) -> None:
    source, target = sky(tmp_path / "in.mkv", 4), tmp_path / "out.mkv"
    keys = sm.video.Keyframes((0, 0.08), ((0, 0, 0), (40, 0, 0)))
    sm.video.convert(source, target, "latlong", "latlong", rotation=keys, siting="center")
    for k, (before, after) in enumerate(
        zip(filming.read(source), filming.read(target), strict=True)
    ):
        # Half the way in the second of frames that are 0.04 s apart, and no further in the fourth.
        turn = sm.rotation(20.0 * min(k, 2))
        for plane, got, black in zip(before, after, (16, 128, 128), strict=True):
            want = sm.convert(plane, "latlong", "latlong", rotation=turn, fill=black)
            # The rotation comes by way of a quaternion, so what is halfway may go either way.
            assert np.abs(got.astype(int) - want).max() <= 1


def test_ctrl_c_leaves_what_was_converted(tmp_path: Path) -> None:
    source = sky(tmp_path / "in.mp4", 12, codec="libx264", options={"qp": "0"}, audio=True)
    target, begun = tmp_path / "out.mp4", []

    def turn(seconds: float) -> np.ndarray:
        begun.append(seconds)
        if len(begun) == 6:
            signal.raise_signal(signal.SIGINT)
        return np.eye(3)

    with pytest.raises(KeyboardInterrupt):
        sm.video.convert(source, target, "latlong", "latlong", rotation=turn)
    assert filming.times(target) == filming.times(source)[:5]
    assert sm.video.projection(target) == sm.projection("latlong")
    played = subprocess.run(
        [ffmpeg_oracle.program(), "-v", "warning", "-i", str(target), "-f", "null", "-"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert played.stderr == ""
    assert sorted(p.name for p in tmp_path.iterdir()) == ["in.mp4", "out.mp4"]


def test_ctrl_c_before_the_first_frame_and_errors_leave_nothing(tmp_path: Path) -> None:
    source, target = sky(tmp_path / "in.mkv", 4), tmp_path / "out.mkv"
    target.write_bytes(b"what was there")

    def interrupt(seconds: float) -> np.ndarray:
        raise KeyboardInterrupt

    def fail(seconds: float) -> np.ndarray:
        return np.eye(3) if seconds < 0.1 else np.ones((3, 3))

    with pytest.raises(KeyboardInterrupt):
        sm.video.convert(source, target, "latlong", "latlong", rotation=interrupt)
    with pytest.raises(ValueError, match="rotation"):
        sm.video.convert(source, target, "latlong", "latlong", rotation=fail)
    cut = tmp_path / "cut.mkv"
    cut.write_bytes(source.read_bytes()[:200])
    with pytest.raises((OSError, ValueError), match=r"cut\.mkv"):
        sm.video.convert(cut, target, "latlong", "latlong")
    assert target.read_bytes() == b"what was there"
    assert {p.name for p in tmp_path.iterdir()} == {"in.mkv", "out.mkv", "cut.mkv"}


def test_a_video_may_replace_itself(tmp_path: Path) -> None:
    source = sky(tmp_path / "in.mkv", 2)
    before = filming.times(source)
    sm.video.convert(source, source, "latlong", "cube", size=16)
    assert filming.times(source) == before and filming.read(source)[0][0].shape == (48, 64)


def test_bad_arguments_are_named(tmp_path: Path) -> None:
    source, target = sky(tmp_path / "in.mkv", 1), tmp_path / "out.mkv"

    def bad(says: str, src: object = "latlong", dst: object = "latlong", **more: object) -> None:
        with pytest.raises((ValueError, TypeError), match=says):
            sm.video.convert(source, target, src, dst, **more)  # type: ignore[arg-type]

    bad("does not say its projection", src=None)
    bad("unknown projection", dst="latlang")
    bad("as wide as high", src="angular")
    bad(r"cross", src="cube")
    bad(r"`size` to have a width that is a multiple of 2 and a.*65 x 65", dst="angular", size=65)
    bad("no such encoder", codec="nothing")
    bad("none of video", codec="aac")
    bad("takes no 'rgb24'", pixel_format="rgb24")
    bad("no option 'speed'", options={"speed": "1"})
    bad("'libx264' takes.*'crf': 'abc'", codec="libx264", options={"crf": "abc"})
    bad("'mjpeg' takes.*'yuv420p'", codec="mjpeg")
    bad("20000000 x 10000000", size=10**7)
    bad("`siting`", siting="right")
    bad("`metadata`", metadata="v3")
    bad(r"\.mp4", metadata="v1")
    bad("`audio`", audio="yes")
    bad("unknown filter", filter="sharp")
    with pytest.raises(ValueError, match="this ending"):
        sm.video.convert(source, tmp_path / "out.txt", "latlong", "latlong")
    with pytest.raises(FileNotFoundError, match="none"):
        sm.video.convert(tmp_path / "none.mp4", target, "latlong", "latlong")
    (tmp_path / "no.mp4").write_bytes(b"no video")
    with pytest.raises(OSError, match=r"cannot read .*no\.mp4"):
        sm.video.convert(tmp_path / "no.mp4", target, "latlong", "latlong")
    assert not target.exists()


@pytest.mark.parametrize("codec", ["libx264", "libx265", "libsvtav1"])
def test_encoders_are_silent(codec: str, tmp_path: Path) -> None:
    source, target = sky(tmp_path / "in.mkv", 1), tmp_path / "out.mkv"
    code = (
        "import sys, spheremap as sm\n"
        "sm.video.convert(*sys.argv[1:3], 'latlong', 'latlong', codec=sys.argv[3])"
    )
    command = [sys.executable, "-c", code, str(source), str(target), codec]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


def test_pyav_is_imported_by_those_who_need_it() -> None:
    code = (
        "import sys; sys.modules['av'] = None; import spheremap as sm; sm.video.Keyframes\n"
        "try: sm.video.convert('a.mp4', 'b.mp4', 'latlong', 'cube')\n"
        "except ImportError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "videos need PyAV: pip install spheremap[video]\n"
