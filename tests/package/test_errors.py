"""Every error is a ValueError or a TypeError that says what was expected and what came."""

from __future__ import annotations

import re

import numpy as np
import pytest
import spheremap as sm
from conftest import NAMES, REGISTRY

D = np.ones((4, 3))
UV = np.full((4, 2), 0.5)
IMAGE = np.zeros((8, 16, 3), np.float32)


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("octahedrel", "octahedral"),
        ("latlon", "latlong"),
        ("Sphere", "sphere"),
        ("angualr", "angular"),
        ("cubes", "cube"),
        ("hemi_octahedral", "hemioctahedral"),
        ("dualparaboloid", "dual_paraboloid"),
        ("mat_cap", "matcap"),
    ],
)
def test_unknown_projection_names_the_nearest(name, near):
    for call in (
        lambda: sm.projection(name),
        lambda: sm.encode(D, name),
        lambda: sm.decode(UV, name),
        lambda: sm.solid_angle(name, 4),
        lambda: sm.convert(IMAGE, name, "cube"),
        lambda: sm.convert(IMAGE, "latlong", name),
    ):
        with pytest.raises(ValueError) as e:
            call()
        assert str(e.value) == f"unknown projection '{name}'; did you mean '{near}'?"


@pytest.mark.parametrize("name", sorted({name for entry in REGISTRY for name in entry["known_as"]}))
def test_names_that_others_use_are_translated(name):
    assert name not in NAMES
    here = [entry["name"] for entry in REGISTRY if name in entry["known_as"]]
    with pytest.raises(ValueError) as e:
        sm.encode(D, name)
    translated = "' or '".join(here)
    assert str(e.value) == f"unknown projection '{name}'; here it is '{translated}'"


def test_unknown_projection_that_is_near_nothing():
    with pytest.raises(ValueError, match=r"unknown projection 'xyzzyplugh'"):
        sm.projection("xyzzyplugh")
    with pytest.raises(ValueError, match=r"unknown projection ''"):
        sm.projection("")


def test_unknown_convention():
    with pytest.raises(ValueError, match=r"unknown convention 'mitsubo'.*'mitsuba'"):
        sm.projection("latlong", convention="mitsubo")
    with pytest.raises(ValueError, match=r"unknown convention 'mitsubo'.*'mitsuba'"):
        sm.encode(D, "latlong:mitsubo")
    with pytest.raises(ValueError, match="convention"):
        sm.projection("octahedral", convention="mitsuba")
    with pytest.raises(ValueError, match="unknown"):
        sm.conventions("latlon")


@pytest.mark.parametrize(
    "axes",
    ["", "+x +y", "+x +y +y", "x y z", "+x -y +w", "+x +y +z +x", "xyz", "+X +Y +Z"],
)
def test_axes(axes):
    with pytest.raises(ValueError, match="axes"):
        sm.projection("latlong", axes=axes)
    with pytest.raises(ValueError, match="axes"):
        sm.encode(D, "latlong", axes=axes)


def test_grid_layout_filter_and_parameters():
    with pytest.raises(ValueError, match=r"grid.*corner"):
        sm.projection("latlong", grid="corner")
    with pytest.raises(ValueError, match=r"layout"):
        sm.projection("cube", layout="crosss")
    with pytest.raises(ValueError, match=r"layout"):
        sm.projection("latlong", layout="cross")
    with pytest.raises(ValueError, match=r"filter.*'linear'|'linear'.*filter"):
        sm.sample(IMAGE, D, "latlong", filter="linear")
    with pytest.raises(ValueError, match=r"filter"):
        sm.convert(IMAGE, "latlong", "cube", filter="Nearest")
    for bad in ({"fov": 400}, {"fov": 0}, {"fov": -1}, {"fov": float("nan")}):
        with pytest.raises(ValueError, match="`fov` must be in"):
            sm.projection("angular", **bad)
    with pytest.raises((TypeError, ValueError)):
        sm.projection("angular", fov="wide")
    with pytest.raises((TypeError, ValueError), match="foo"):
        sm.projection("angular", foo=1)
    with pytest.raises((TypeError, ValueError), match="fov"):
        sm.projection("latlong", fov=90)


def test_message_for_a_field_of_view_out_of_range():
    with pytest.raises(ValueError) as e:
        sm.projection("angular", fov=400)
    assert str(e.value) == "`fov` must be in (0, 360], got 400."


def test_message_for_a_wrong_shape():
    with pytest.raises(ValueError) as e:
        sm.encode(np.ones((4, 2)), "octahedral")
    assert str(e.value) == "Expected `directions` to have shape (..., 3), got (4, 2)."
    with pytest.raises(
        ValueError, match=re.escape("Expected `directions` to have shape (..., 3), got ()")
    ):
        sm.encode(1.0, "octahedral")
    with pytest.raises(
        ValueError, match=re.escape("Expected `uv` to have shape (..., 2), got (4, 3)")
    ):
        sm.decode(D, "octahedral")
    with pytest.raises(
        ValueError, match=re.escape("Expected `uv` to have shape (..., 3), got (4, 2)")
    ):
        sm.decode(UV, "cube")


def test_images_of_the_wrong_shape():
    with pytest.raises(ValueError, match="image"):
        sm.sample(np.zeros(5), D, "latlong")
    with pytest.raises(ValueError, match="image"):
        sm.sample(np.zeros((2, 2, 2, 2, 2)), D, "latlong")
    with pytest.raises(ValueError, match="image"):
        sm.sample(np.zeros((8, 16, 3, 1)), D, "latlong")
    with pytest.raises(ValueError, match="image"):
        sm.sample(np.zeros((5, 8, 8, 3)), D, "cube")
    with pytest.raises(ValueError, match="image"):
        sm.sample(np.zeros((8, 8)), D, "cube")
    with pytest.raises(ValueError, match=r"image|empty|shape"):
        sm.sample(np.zeros((0, 16, 3)), D, "latlong")
    with pytest.raises(ValueError, match=r"directions"):
        sm.sample(IMAGE, np.ones((4, 2)), "latlong")


@pytest.mark.parametrize("dtype", [np.int32, np.int8, np.uint32, np.complex64, bool, object])
def test_images_of_the_wrong_dtype(dtype):
    with pytest.raises(TypeError, match=r"image|dtype"):
        sm.sample(np.zeros((8, 16, 3), dtype), D, "latlong")
    with pytest.raises(TypeError, match=r"image|dtype"):
        sm.convert(np.zeros((8, 16, 3), dtype), "latlong", "cube")


@pytest.mark.parametrize("size", [0, -1, (0, 0), (4,), (4, 8, 1, 1), 1 << 62])
def test_sizes(size):
    for call in (
        lambda: sm.solid_angle("latlong", size),
        lambda: sm.directions("latlong", size),
        lambda: sm.convert(IMAGE, "latlong", "latlong", size=size),
        lambda: sm.projection("latlong").shape(size),
    ):
        with pytest.raises((ValueError, OverflowError, MemoryError)):
            call()


@pytest.mark.parametrize("size", [1.5, "4", None, (2.5, 5)])
def test_sizes_of_the_wrong_type(size):
    with pytest.raises(TypeError):
        sm.solid_angle("latlong", size)


def test_fill_must_fit():
    for fill in (-1, 256, 0.5, float("nan")):
        try:
            got = sm.sample(np.zeros((4, 4), np.uint8), [0, 0, 0.0], "octahedral", fill=fill)
        except (ValueError, TypeError, OverflowError):
            continue
        assert got.dtype == np.uint8  # clamped or rounded, but nothing else
    with pytest.raises((TypeError, ValueError)):
        sm.sample(np.zeros((4, 4)), [0, 0, 0.0], "octahedral", fill="black")


def test_rotation_of_the_wrong_type():
    with pytest.raises((TypeError, ValueError), match="rotation"):
        sm.encode(D, "latlong", rotation="x")
    with pytest.raises((TypeError, ValueError), match="rotation"):
        sm.encode(D, "latlong", rotation=object())


def test_keywords_only_and_positional_only():
    with pytest.raises(TypeError):
        sm.encode(directions=D, projection="cube")
    with pytest.raises(TypeError):
        sm.encode(D, "cube", None)
    with pytest.raises(TypeError):
        sm.sample(IMAGE, D, "latlong", "nearest")
    with pytest.raises(TypeError):
        sm.projection("latlong", "mitsuba")


def test_no_panic_crosses():
    # Sizes and strides that are odd but legal, and absurd ones that are not.
    p = sm.projection("latlong")
    huge = np.broadcast_to(np.float32(1), (1 << 40, 3))
    with pytest.raises((MemoryError, ValueError)):
        p.encode(huge)
    zero_stride = np.broadcast_to(np.float32(1), (1 << 10, 3))
    assert np.all(p.encode(zero_stride) == p.encode(np.ones(3, np.float32)))
    one = np.zeros((1, 1, 3))
    for name in sm.projections():
        q = sm.projection(name)
        image = np.zeros((*q.shape(1), 3))
        got = q.sample(image, np.eye(3), fill=0)
        assert np.all(got == 0)
    assert sm.sample(one, np.eye(3), "latlong").shape == (3, 3)


def test_channels_zero():
    try:
        got = sm.sample(np.zeros((4, 8, 0)), D, "latlong")
    except ValueError as e:
        assert "image" in str(e) or "channel" in str(e)
    else:
        assert got.shape == (4, 0)
