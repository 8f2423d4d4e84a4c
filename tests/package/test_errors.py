"""Every error is a ValueError or a TypeError that says what was expected and what came."""

from __future__ import annotations

import re
from pathlib import Path

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
    with pytest.raises(ValueError, match=r"`world` '.*' names no frame: "):
        sm.projection("latlong", world=axes)


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


@pytest.mark.parametrize("size", [1.5, "4", None, (2.5, 5), True, np.True_])
def test_sizes_of_the_wrong_type(size):
    with pytest.raises(TypeError, match="`size`"):
        sm.solid_angle("latlong", size)


def test_a_size_that_does_not_fit_is_told_from_an_image():
    with pytest.raises(ValueError, match=r"^Expected `size` of an image of projection 'cube'"):
        sm.convert(IMAGE, "latlong", "cube", size=(4, 4))
    with pytest.raises(ValueError, match=r"^Expected `source_shape` of an image"):
        sm.remap_plan("latlong", "cube", size=4, source_shape=IMAGE.shape)
    for size in (10**9, 10**30):
        with pytest.raises(ValueError, match="`size` to be at most 268435456"):
            sm.convert(IMAGE, "latlong", "cube", size=size)


@pytest.mark.parametrize("image", ["sky.exr", Path("sky.exr"), None])
def test_what_is_no_image_at_all(image):
    for call in (
        lambda: sm.convert(image, "latlong", "cube"),
        lambda: sm.sample(image, D, "latlong"),
        lambda: sm.light.integrate(image, "latlong"),
    ):
        with pytest.raises(TypeError, match=r"`image` to be an array, got (None|the name of)"):
            call()


@pytest.mark.parametrize("alpha", [True, "last", 1.0])
def test_the_number_of_a_channel_is_a_whole_number(alpha):
    for call in (
        lambda: sm.convert(IMAGE, "latlong", "cube", alpha=alpha),
        lambda: sm.sample(IMAGE, D, "latlong", alpha=alpha),
        lambda: sm.remap_plan("latlong", "cube", size=4, alpha=alpha),
    ):
        with pytest.raises(TypeError, match="`alpha` to be a whole number"):
            call()


@pytest.mark.parametrize("flag", [1, 0, None, "no", 1.0, np.ones(2, bool)])
def test_a_flag_is_a_bool_and_its_message_has_its_name(flag):
    p = sm.projection("latlong")
    calls = {
        "skipna": [
            lambda: sm.convert(IMAGE, p, "cube", size=2, skipna=flag),
            lambda: sm.convert(IMAGE[None], p, "cube", size=2, skipna=flag),
            lambda: sm.convert(IMAGE > 0, p, "cube", size=2, filter="nearest", skipna=flag),
            lambda: sm.sample(IMAGE, D, p, skipna=flag),
            lambda: p.sample(IMAGE, D, skipna=flag),
            lambda: p.convert(IMAGE, "cube", size=2, skipna=flag),
            lambda: sm.remap_plan(p, "cube", size=2, skipna=flag),
            lambda: sm.embed(IMAGE, p, IMAGE, p, skipna=flag),
            lambda: sm.light.integrate(IMAGE, p, skipna=flag),
        ],
        "antialias": [
            lambda: sm.convert(IMAGE, p, "cube", size=2, antialias=flag),
            lambda: sm.remap_plan(p, "cube", size=2, antialias=flag),
            lambda: sm.embed(IMAGE, p, IMAGE, p, antialias=flag),
        ],
        "channels_first": [lambda: sm.convert(IMAGE, p, "cube", size=2, channels_first=flag)],
        "nest": [lambda: sm.healpix.pix2vec(4, 0, nest=flag)],
    }
    for name, those in calls.items():
        for call in those:
            with pytest.raises(TypeError, match=f"Expected `{name}` to be a bool, got"):
                call()


def test_a_flag_may_be_numpys():
    yes = np.True_
    once = sm.convert(IMAGE, "latlong", "cube", size=2, skipna=yes, antialias=yes)
    assert np.array_equal(once, sm.convert(IMAGE, "latlong", "cube", size=2, skipna=True))


def test_what_a_verb_does_not_take_is_said_in_its_name():
    for call, verb in (
        (lambda **o: sm.remap_plan("latlong", "cube", size=4, **o), "remap_plan"),
        (lambda **o: sm.projection("latlong").plan("cube", size=4, **o), "remap_plan"),
        (
            lambda **o: sm.weights_matrix("latlong", "cube", size=2, source_shape=(8, 16), **o),
            "weights_matrix",
        ),
        (lambda **o: sm.embed(IMAGE, "latlong", IMAGE, "latlong", **o), "embed"),
    ):
        with pytest.raises(TypeError, match=f"`filtr` is no option of `{verb}`; it takes .*filter"):
            call(filtr="area")


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


SUN = sm.light.Sun(np.eye(3)[0], 1e-4, np.ones(1), np.zeros(1), 0.1)
GRAY = np.ones((8, 16))
# Numbers, words and flags of which Python or numpy would say neither which nor what was expected.
SCALARS = {
    "roughness": lambda: sm.light.prefilter(GRAY, "latlong", "cube", roughness=(1,), size=2),
    "samples": lambda: sm.light.prefilter(
        GRAY, "latlong", "cube", roughness=1.0, size=2, samples="9"
    ),
    "distribution": lambda: sm.light.dfg(8, distribution=np.ones(3)),
    "multiscatter": lambda: sm.light.dfg(8, multiscatter=np.ones(3)),
    "size": lambda: sm.light.prefilter_chain(GRAY, "latlong", "cube", size=(4, 8)),
    "levels": lambda: sm.light.prefilter_chain(GRAY, "latlong", "cube", size=4, levels=[1]),
    "lobe": lambda: sm.light.convolve(GRAY, "latlong", "cube", lobe=["cone"], size=2),
    "half_angle": lambda: sm.light.convolve(
        GRAY, "latlong", "cube", lobe="cone", half_angle="x", size=2
    ),
    "skipna": lambda: sm.light.integrate(GRAY, "latlong", skipna=np.ones(3)),
    "normalized": lambda: sm.light.weights("latlong", 4, normalized=[]),
    "compensate": lambda: sm.light.Distribution(GRAY, "latlong", compensate=np.ones(2)),
    "peak": lambda: sm.light.ws_psnr(GRAY, GRAY, "latlong", peak="x"),
    "method": lambda: sm.light.lights(GRAY, "latlong", count=1, method=np.ones(2)),
    "sun": lambda: sm.light.add_sun(GRAY, "x", "latlong"),
    "order": lambda: sm.sh.project(GRAY, "latlong", order="two"),
    "window": lambda: sm.sh.window(np.ones(4), width=(1,)),
    "texels": lambda: sm.sh.project(GRAY, "latlong", order=1, texels=np.ones(2)),
    "yaw": lambda: sm.rotation("x", 0, 0),
    "axes": lambda: sm.encode(D, "latlong", axes=np.ones(3)),
    "dtype": lambda: sm.directions("latlong", 4, dtype="x"),
    "n": lambda: sm.pad(GRAY, "latlong", 1.5),
    "feather": lambda: sm.embed(GRAY, "latlong", GRAY, "latlong", feather="x"),
    "family": lambda: sm.packing.packings(family=[]),
    "nest": lambda: sm.healpix.reorder(np.zeros(12), nest=None),
    "step": lambda: sm.healpix.boundaries(4, 0, step=1.5),
    "exposure": lambda: sm.io.tonemap(GRAY, exposure="x"),
    "path": lambda: sm.io.write_dds(3, [np.ones((4, 4, 3))]),
    "as_matrix": lambda: sm.encode(D, "latlong", rotation=type("R", (), {"as_matrix": 3})()),
    "color": lambda: sm.light.bake_matcap(GRAY, size=2, color="x"),
    "faces": lambda: sm.projections(faces="x"),
}


@pytest.mark.parametrize("name", SCALARS)
def test_what_is_no_number_word_or_flag_is_named(name):
    with pytest.raises(TypeError) as info:
        SCALARS[name]()
    said = "\n".join([str(info.value), *getattr(info.value, "__notes__", ())])
    assert name in said or (name == "window" and "width" in said), said


def test_numbers_beyond_floats_are_value_errors():
    for call in (
        lambda: sm.rotation(10**400, 0, 0),
        lambda: sm.projection("angular", fov=10**400),
        lambda: sm.light.prefilter(GRAY, "latlong", "cube", roughness=10**400, size=2),
        lambda: sm.sh.lobe("phong", order=2, exponent=10**400),
    ):
        with pytest.raises(ValueError, match="a float can hold"):
            call()


def test_shapes_that_do_not_broadcast_are_named():
    two, five = np.ones((2, 3)), np.ones((5, 3))
    for call, names in (
        (lambda: sm.reflect(two, five), ("view", "normal")),
        (lambda: sm.healpix.ang2pix(4, two[:, 0], five[:, 0]), ("theta", "phi")),
        (lambda: sm.healpix.pix2vec([4, 8], [1] * 5), ("nside", "pixels")),
        (lambda: sm.packing.pack_frame(two, five), ("normals", "tangents")),
        (lambda: sm.sample(IMAGE, two, "latlong", lod=[1] * 5), ("directions", "lod")),
    ):
        with pytest.raises(ValueError) as e:
            call()
        first, second = names
        got = rf"\(2,.*\) for `{first}`, \(5,.*\) for `{second}`"
        assert re.fullmatch(rf"Expected shapes that broadcast, got {got}\.", str(e.value))


def test_signaling_nan_gives_no_warning():
    bits = np.full((4, 3), 0x7F800001, np.uint32).view(np.float32)
    assert np.isnan(sm.light.irradiance_at(GRAY, bits, "latlong")).all()
    assert np.isnan(sm.sh.rotate(bits[:, 0], np.eye(3))).all()
    with pytest.raises(ValueError, match="not finite"):
        sm.packing.pack_frame(bits, bits)


@pytest.mark.parametrize("path", ["a\0b.dds", "\ud800.dds"])
def test_paths_that_no_disk_can_have(path):
    with pytest.raises(ValueError, match="`path`"):
        sm.io.write_dds(path, [np.ones((4, 4, 3))])


def test_ragged_codes_are_named():
    with pytest.raises(ValueError, match="Expected `codes` to be an array"):
        sm.packing.unpack([[1], [1, 2]], "oct32")


HUGE = np.full((8, 16, 3), 1e308)
NOTHING = np.full((8, 16, 3), np.nan)


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (
            lambda: sm.sample_uv(np.zeros((4, 4, 3)), np.zeros((3, 2)), filter=np.ones(3)),
            TypeError,
            "str",
        ),
        (lambda: sm.sample(IMAGE, D, "latlong", filter=np.ones(3)), TypeError, "str"),
        (
            lambda: sm.packing.unpack_frame(np.zeros(3, np.uint64), np.zeros(4, [("a", "f8")])),
            TypeError,
            "`name` to be a str",
        ),
        (
            lambda: sm.view(IMAGE, "latlong").box(np.broadcast_to(np.int64(1), 2**40)),
            ValueError,
            "`box` to be left, top, right, bottom, got more",
        ),
        (lambda: sm.io.to_linear([[1], [1, 2]]), ValueError, "`image`"),
        (lambda: sm.projection("perspective", fov=np.ma.masked), TypeError, "`fov` must be"),
        (lambda: sm.align.identify(NOTHING, IMAGE), ValueError, "finite values, got none"),
        (lambda: sm.code("latlong", "glsl", name=""), ValueError, "Expected `name`"),
        (lambda: sm.code("latlong", "glsl_es", name="half"), ValueError, "a word of its own"),
        (lambda: sm.code("latlong", "c", name="gl_a"), ValueError, "GLSL's own"),
    ],
)
def test_hostile_calls(call, error, said):
    """Each was answered by another library, or without an end."""
    with pytest.raises(error, match=said):
        call()


def test_numbers_that_overflow_are_no_warnings():
    assert np.isinf(sm.light.bake_matcap(HUGE, size=12)).any()
    view = np.random.default_rng(0).random((12, 12, 3)).astype("float32")
    sky = np.full((32, 64, 3), np.inf, "float32")
    assert not np.isfinite(sm.embed(view, "double_sphere", sky, "latlong")).all()
