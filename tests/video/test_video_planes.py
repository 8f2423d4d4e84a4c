"""Planes and siting: which formats, where chroma lies, what is moved."""

from __future__ import annotations

import av
import numpy as np
import pytest
import spheremap as sm
from spheremap.video import planes, siting


def described(name: str, color_range: int = 0) -> tuple[planes.Plane, ...]:
    return planes.described(av.VideoFormat(name, 64, 32), color_range)


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("yuv420p", [(16, 1, 1), (128, 2, 2), (128, 2, 2)]),
        ("yuvj420p", [(0, 1, 1), (128, 2, 2), (128, 2, 2)]),
        ("yuv422p10le", [(64, 1, 1), (512, 2, 1), (512, 2, 1)]),
        ("yuv411p", [(16, 1, 1), (128, 4, 1), (128, 4, 1)]),
        ("yuv444p16le", [(4096, 1, 1), (32768, 1, 1), (32768, 1, 1)]),
        ("yuva420p", [(16, 1, 1), (128, 2, 2), (128, 2, 2), (0, 1, 1)]),
        ("gbrp", [(0, 1, 1)] * 3),
        ("gray", [(0, 1, 1)]),
        ("gbrpf32le", [(0, 1, 1)] * 3),
    ],
)
def test_formats(name: str, wanted: list[tuple[float, int, int]]) -> None:
    assert [(p.black, p.across, p.down) for p in described(name)] == wanted
    assert described("yuv420p", 2)[0].black == 0


def test_what_is_packed_becomes_planes_of_the_same_numbers() -> None:
    rng = np.random.default_rng(900)
    rgb = rng.integers(0, 256, (32, 64, 3), np.uint8)
    frame = av.VideoFrame.from_ndarray(rgb, "rgb24").reformat(format=planes.planar("rgb24"))
    g, b, r = planes.views(frame, planes.described(frame.format, 0))
    assert np.array_equal(np.stack([r, g, b], -1), rgb)
    for name in ("nv12", "p010le", "yuyv422", "rgb48be", "yuv420p10be"):
        found = planes.planar(name)
        assert found != name and described(found)
    for name in ("pal8", "rgb24", "monow", "nv12"):
        with pytest.raises(ValueError, match=name):
            described(name)


@pytest.mark.parametrize(
    ("source", "wanted", "formats"),
    [
        ("yuv420p", "yuv420p10le", ("yuv420p", "yuv420p")),
        ("nv12", "p010le", ("yuv420p", "yuv420p")),
        ("yuv420p10le", "yuv444p", ("yuv420p10le", "yuv444p10le")),
        ("yuv420p", "rgb24", ("yuv420p", "yuv444p")),
        ("yuvj422p", "nv12", ("yuvj422p", "yuvj420p")),
        ("bgr0", "yuv420p10le", ("yuv444p10le", "yuv420p10le")),
        ("rgb24", "yuv444p", ("gbrp", "gbrp")),
        ("yuv420p", "gray", ("yuv420p", "yuv420p")),
        ("gray", "yuv420p", ("gray", "gray")),
        # Of 4:1:1 there is none with alpha.
        ("yuva420p", "yuv411p", ("yuv420p", "yuv411p")),
    ],
)
def test_between(source: str, wanted: str, formats: tuple[str, str]) -> None:
    assert planes.between(source, wanted) == formats


def test_no_format_lies_between() -> None:
    with pytest.raises(ValueError, match="'yuva422p10le' can become, got 'uyyvyy411'"):
        planes.between("yuva422p10le", "uyyvyy411")


def test_views_are_the_frame_s_own_memory() -> None:
    frame = av.VideoFrame(50, 20, "yuv420p10le")
    for view in planes.views(frame, planes.described(frame.format, 0)):
        view[...] = 700
    assert all((v == 700).all() for v in planes.views(frame, planes.described(frame.format, 0)))


@pytest.mark.parametrize(
    "p",
    [
        sm.projection("latlong"),
        sm.projection("latlong:mitsuba").turned(sm.rotation(10, 20, 30)),
        sm.projection("lambert_cylindrical"),
        sm.projection("cylindrical(fov=120)"),
    ],
    ids=str,
)
def test_around_an_axis_a_shift_is_a_turn(p: sm.Projection) -> None:
    shape = p.shape(64)
    found = siting.turn(p, shape, (-0.25, 0))
    assert found is not None
    uv = np.random.default_rng(901).uniform(0.1, 0.9, (50, 2))
    want = p.decode(uv - [0.25 / shape[1], 0])
    # To the rounding of a cosine, and of a fit to 81 of them.
    assert np.abs(p.turned(found).decode(uv) - want).max() < 1e-14


@pytest.mark.parametrize("name", ["angular", "perspective", "cube:ffmpeg-c3x2", "octahedral"])
def test_elsewhere_it_is_none(name: str) -> None:
    p = sm.projection(name)
    assert siting.turn(p, p.shape(64), (-0.25, 0)) is None
    assert siting.turn(sm.projection("latlong"), (64, 128), (-0.25, -0.25)) is None


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_moved(dtype: type) -> None:
    top = None if dtype == np.float32 else np.iinfo(dtype).max
    unit = 1.0 if top is None else top
    x, y = np.meshgrid(np.arange(64), np.arange(48))

    def wave(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return unit * (0.5 + 0.4 * np.sin(x / 9) * np.cos(y / 8))

    plane = wave(x, y)
    plane = (np.rint(plane) if top else plane).astype(dtype)
    for shift in ((0.25, 0), (-0.25, 0), (0.375, -0.25), (0.5, 0.5)):
        got = siting.moved(plane, shift, (1, 1), top).astype(float)
        want = wave(x + shift[0], y + shift[1])
        inside = np.s_[2:-2, 2:-2]
        # Halves of the source's rounding grow by up to 1.25 along each axis, and each axis rounds
        # again; floats have 24 bits.
        rounding = 0.5 * (1.25**2 + 1.25 + 1) if top else 1e-6
        # The cubic errs by t(1 - t)(1 - 2t)/12 third derivatives, of 0.4/8³, and less of others.
        assert np.abs(got - want)[inside].max() < unit * 4e-5 + rounding
    assert siting.moved(plane, (0, 0), (1, 1), top) is plane


def test_faces_do_not_mix() -> None:
    plane = np.repeat(np.array([[10, 200, 90]], np.uint8), 8, 1).repeat(8, 0)
    for shift in ((0.25, 0), (-0.25, 0.5)):
        assert np.array_equal(siting.moved(plane, shift, (2, 3), 255), plane)
    assert siting.cells(sm.projection("cube:ffmpeg-c3x2")) == (2, 3)
    assert siting.cells(sm.projection("latlong")) == (1, 1)


def test_offsets() -> None:
    chroma, narrow = described("yuv420p")[1], described("yuv411p")[1]
    assert siting.offset(chroma, "left") == (-0.25, 0)
    assert siting.offset(chroma, "top-left") == (-0.25, -0.25)
    assert siting.offset(chroma, "center") == (0, 0)
    assert siting.offset(narrow, "left") == (-0.375, 0)
    assert siting.offset(described("yuv420p")[0], "left") == (0, 0)
