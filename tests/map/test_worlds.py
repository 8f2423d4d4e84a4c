"""Worlds of programs: up stays up, ahead stays ahead, and a person reads what is written there."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from spheremap import _core

TABLE = _core.convention_table()
ROWS = [f"{row['kind']}:{row['name']}" for row in TABLE]
WHOLE = [name for name in ROWS if sm.projection(name).coverage == "sphere"]


def vector(word: str) -> np.ndarray:
    return np.eye(3)["xyz".index(word[1])] * (1 if word[0] == "+" else -1)


def person(row: dict[str, Any]) -> np.ndarray:
    """Return (right, up, ahead) of somebody in a row's world, from what the row says of it."""
    up, ahead = vector(row["up"]), vector(row["forward"])
    right = np.cross(ahead, up) * (-1 if row["left_handed"] else 1)
    return np.stack([right, up, ahead])


PERSON = {f"{row['kind']}:{row['name']}": person(row) for row in TABLE}
OURS = np.array([[1, 0, 0], [0, 1, 0], [0, 0, -1]])


def painted(p: sm.Projection, frame: np.ndarray, size: int) -> np.ndarray:
    """Return a sky that is white above the horizon, with an R written on it, straight ahead."""
    right, up, ahead = np.moveaxis(np.nan_to_num(p.directions(size)) @ frame.T, -1, 0)
    sky = 1 / (1 + np.exp(-4 * up))
    x, y = right, up - 0.1
    stem = np.exp(-8 * (x + 0.3) ** 2 - 2 * y**2)
    bowl = np.exp(-10 * (x - 0.15) ** 2 - 10 * (y - 0.3) ** 2)
    leg = np.exp(-8 * (x - 0.3) ** 2 - 8 * (y + 0.35) ** 2) / 2
    return np.stack([sky, (stem + bowl + leg) * (1 + np.tanh(4 * ahead)) / 2], -1)


def test_plain_names_have_our_world():
    for entry in _core.registry():
        assert sm.projection(entry["name"]).world == "+x +y -z"


@pytest.mark.parametrize("row", TABLE, ids=ROWS)
def test_what_a_row_says_is_what_its_map_has(row):
    p = sm.projection(row["kind"], convention=row["name"])
    words = [next(w for w in ("+x", "-x", "+y", "-y", "+z", "-z") if (vector(w) == axis).all())
             for axis in person(row)]  # fmt: skip
    assert p.world == " ".join(words) and row["ahead"]
    again = sm.projection(row["kind"], axes=p.axes, world=p.world)
    assert again.world == p.world and pickle.loads(pickle.dumps(again)) == again
    assert eval(f"sm.{repr(again).lower()}") == again


def test_rows_of_one_program_live_in_one_world():
    worlds: dict[str, set[str]] = {}
    for name in ROWS:
        program = name.partition(":")[2].split("-")[0]
        # Files and stages say which way is up there.
        if not name.endswith("-z-up"):
            worlds.setdefault(program, set()).add(sm.projection(name).world)
    # openexr and openimageio show the same; each is one world.
    assert all(len(found) == 1 for found in worlds.values()), worlds


@pytest.mark.parametrize("a", ROWS)
def test_a_person_sees_the_same_in_both(a):
    p = sm.projection(a)
    for b in ROWS:
        q = sm.projection(b)
        there = q.in_world_of(p)
        own, named = q.directions(6), there.directions(6)
        # Signed permutations: not a bit is rounded.
        assert np.array_equal(named @ PERSON[a].T, own @ PERSON[b].T, equal_nan=True), b
        assert there.in_world_of(q) == q and there.world == p.world


@pytest.mark.parametrize("a", WHOLE)
def test_white_stays_above_and_letters_stay_readable(a):
    source = painted(sm.projection(a), PERSON[a], 64)
    for b in WHOLE:
        q = sm.projection(b)
        got = sm.convert(source, a, b, size=16, antialias=False)
        want = painted(q, PERSON[b], 16)
        ok = ~np.isnan(q.directions(16)[..., 0])
        # A smooth sky between texels up to 7° apart (a mirror ball's, at its rim far more, where
        # few are): half of h² times a slope of the slope of 20. A mirrored R is off by 0.1.
        assert np.abs(got - want)[ok].mean() < 0.02, b
        height = q.directions(16) @ PERSON[b][1]
        assert (got[..., 0][ok & (height > 0.25)] > 0.6).all(), b
        assert (got[..., 0][ok & (height < -0.25)] < 0.4).all(), b


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ("latlong:blender", "cube:opengl"),
        ("latlong:unity", "latlong"),
        ("latlong:mitsuba", "cube:unreal"),
        ("angular:openimageio", "octahedral:unreal"),
    ],
)
@pytest.mark.parametrize("filter", ["bilinear", "area", "ewa"])
def test_literal_keeps_x_y_z(a, b, filter):
    rng = np.random.default_rng(2100)
    p, q = sm.projection(a), sm.projection(b)
    image = rng.random((*p.shape(12), 3)).astype(np.float32)
    # The same maps by axes alone, with no program behind them: all that there was before.
    bare = [
        sm.projection(x.name, axes=x.axes, grid=x.grid, layout=x.layout, **x.parameters)
        for x in (p, q)
    ]
    want = sm.convert(image, *bare, size=8, filter=filter)
    got = sm.convert(image, a, b, size=8, filter=filter, world="literal")
    assert np.array_equal(got, want)
    assert not np.array_equal(sm.convert(image, a, b, size=8, filter=filter), want)


def test_one_world_is_the_same_bits_in_both_ways():
    rng = np.random.default_rng(2101)
    for a, b in (
        ("latlong:unity", "cube:directxtex-h-cross"),
        ("latlong:threejs", "cube:opengl"),
        ("latlong:equilib", "cube:unreal"),
        ("latlong", "cube:skylibs"),
        ("latlong:ffmpeg", "cube_equiangular:ffmpeg-eac"),
    ):
        assert _core.worlds(sm.projection(a), sm.projection(b)) is None
        image = rng.random(sm.projection(a).shape(16))
        matched = sm.convert(image, a, b, size=8)
        assert np.array_equal(matched, sm.convert(image, a, b, size=8, world="literal"))


def test_there_and_back_is_the_image():
    # Centers on centers, both of one formula: a turn by a right angle moves texels and no more.
    image = np.random.default_rng(2102).random((16, 32, 3))
    for b in ("latlong:unity", "latlong:unreal", "latlong:blender", "latlong:py360convert"):
        there = sm.convert(image, "latlong:blender", b, size=16, filter="nearest")
        back = sm.convert(there, b, "latlong:blender", size=16, filter="nearest")
        assert np.array_equal(back, image), b
    cube = np.random.default_rng(2103).random((6, 8, 8))
    there = sm.convert(cube, "cube:opengl", "cube:unreal", size=8, filter="nearest")
    back = sm.convert(there, "cube:unreal", "cube:opengl", size=8, filter="nearest")
    assert np.array_equal(back, cube) and not np.array_equal(there, cube)


def test_rotation_turns_in_the_world_of_the_source():
    # Blender's z is up: a turn about it is a yaw in every program.
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    heading = sm.directions("latlong:blender", 32) @ turn.T
    got = sm.convert(heading, "latlong:blender", "latlong:unity", size=32, rotation=turn)
    # What was turn @ d at d is at turn @ d now: each texel holds its own direction, as Blender
    # names it. Quarter turns put centers on centers, so that nothing is interpolated.
    assert np.abs(got - sm.directions("latlong:unity", 32)[..., [0, 2, 1]]).max() < 1e-12


def test_a_camera_is_posed_in_its_own_world():
    # Ours: 30° to the left and up a little, whatever the panorama's program calls that.
    camera = sm.projection("perspective", fov=70).turned(sm.rotation(30, 10, 0))
    want = painted(camera, OURS, 24)
    for name in ("latlong:blender", "latlong:unity", "latlong:unreal", "latlong:mitsuba"):
        sky = painted(sm.projection(name), PERSON[name], 256)
        seen = sm.convert(sky, name, camera, size=24, antialias=False)
        # Lines between texels of 0.7°, of what has a second derivative of 40: h²/8 times that.
        assert np.abs(seen - want).max() < 1e-3


@pytest.mark.parametrize("world", ["match", "literal"])
def test_plans_do_as_convert_does(world):
    image = np.random.default_rng(2104).random((32, 64))
    pair = "latlong:blender", "latlong:unity"
    plan = sm.remap_plan(*pair, size=16, source_shape=(32, 64), world=world, filter="nearest")
    want = sm.convert(image, *pair, size=16, world=world, filter="nearest")
    assert np.array_equal(plan(image), want)
    assert np.array_equal(pickle.loads(pickle.dumps(plan))(image), want)
    x, y = plan.maps(dtype=np.float64)
    # Places fall between texels there: which is nearest, rounding decides.
    near = np.array([[image[int(np.floor(b + s)) % 32, int(np.floor(a + t)) % 64]
                      for s in (0.499, 0.501) for t in (0.499, 0.501)]
                     for a, b in zip(x.ravel(), y.ravel(), strict=True)])  # fmt: skip
    assert (near == want.reshape(-1, 1)).any(axis=1).all()


def test_light_is_matched_as_well():
    name = "latlong:blender"
    sky = painted(sm.projection(name), PERSON[name], 32)[..., 0]
    plain = painted(sm.projection("latlong"), OURS, 32)[..., 0]

    def near(a: Any, b: Any) -> bool:
        # A quarter turn apart: sums over the same texels in another order.
        return bool(np.abs(np.asarray(a) - np.asarray(b)).max() < 1e-9 * np.abs(b).max())

    for make in (
        lambda image, p: sm.light.irradiance(image, p, "cube", size=4),
        lambda image, p: sm.light.irradiance(image, p, "cube", size=4, method="sh"),
        lambda image, p: sm.light.convolve(image, p, "cube", lobe="vmf", kappa=4, size=4),
        lambda image, p: sm.light.prefilter(image, p, "cube", roughness=0.7, size=4),
    ):
        assert near(make(sky, name), make(plain, "latlong"))
    with pytest.raises(ValueError, match="'match' or 'literal'"):
        sm.light.irradiance(sky, name, "cube", world="same")


def test_a_bake_has_up_where_plain_names_have_it():
    name = "latlong:blender"
    sky = painted(sm.projection(name), PERSON[name], 16)[..., 0]
    options: dict[str, Any] = {"size": 8, "levels": 2, "diffuse_size": 4, "samples": 64}
    baked = sm.light.bake(sky, name, **options)
    up = sm.directions("cube", 4)[..., 1]
    assert baked.diffuse[up > 0.6].min() > baked.diffuse[up < -0.6].max()
    assert baked.specular[0][2].min() > 0.9 > 0.1 > baked.specular[0][3].max()
    # Y(1, -1) is y, which is up; Y(1, 0) is z.
    assert baked.sh[1] > 0.5 and abs(baked.sh[2]) < 1e-9
    literal = sm.light.bake(sky, name, world="literal", **options)
    assert literal.sh[2] > 0.5 and literal.specular[0][4].min() > 0.9


def test_embedding_puts_a_view_where_it_was_taken():
    name = "latlong:unreal"
    sky = painted(sm.projection(name), PERSON[name], 128)
    camera = sm.projection("perspective", fov=60).turned(sm.rotation(70, 20, 0))
    crop = sm.convert(sky, name, camera, size=128)
    black = sm.embed(crop, camera, np.zeros_like(sky), name)
    seen = black[..., 0] > 0
    # Twice interpolated between texels of 1.4°, of what has a second derivative of 40: h²/8 times
    # that, and antialiasing averages as much again. Any other place is off by 0.2.
    assert 0.02 < seen.mean() < 0.2 and np.abs(black - sky)[seen].max() < 0.012


def test_words():
    def said(a: str, b: str) -> str | None:
        return _core.worlds(sm.projection(a), sm.projection(b))

    assert said("latlong:blender", "cube:opengl") == (
        "blender (+z up, +y ahead) → opengl (+y up, -z ahead): turned by 90° about -x"
    )
    assert said("latlong:blender", "latlong:blender") is None
    assert "another hand, so that nothing is mirrored" in (said("latlong", "cube:unreal") or "")
    for a in ROWS:
        for b in ROWS:
            same = sm.projection(a).world == sm.projection(b).world
            assert (said(a, b) is None) is same


def test_bad_worlds_say_what_there_is():
    image = np.zeros((4, 8))
    with pytest.raises(ValueError, match="match, literal"):
        sm.convert(image, "latlong", "cube", world="upright")
    with pytest.raises(ValueError, match="sign"):
        sm.projection("latlong", world="x y z")
