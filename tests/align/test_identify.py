"""identify: what was done to an image is what it finds."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import some_fast
from oracles import openimageio_oracle
from scenes import scene

SOURCE = scene(sm.directions("latlong", 120))


def seen_through(found: sm.align.Candidate, image: np.ndarray, d: np.ndarray) -> np.ndarray:
    return sm.sample(image, d, found.projection, rotation=found.rotation, fill=np.nan)


@pytest.mark.parametrize(
    ("kind", "axes", "yaw"),
    [
        ("latlong", "+x -y -z", 0),
        ("latlong", "-x -y -z", 37.5),
        ("cube", "+z +x -y", -20.2),
        ("octahedral", "-y +z +x", 44),
        ("sphere", "+y -z +x", 163),
        ("hemioctahedral", "-z -y +x", -100),
    ],
)
def test_finds_what_was_done(kind, axes, yaw):
    p = sm.projection(kind, axes=axes)
    turn = sm.rotation(yaw, 0, 0)
    image = sm.convert(SOURCE, "latlong", p.turned(turn), size=120)
    result = sm.align.identify(SOURCE, image, "latlong", kind)
    assert result.certain, str(result)
    best = result.best
    assert best.score > 0.97
    d = sm.directions("octahedral", 60).reshape(-1, 3)
    want, got = sm.sample(SOURCE, d, "latlong"), seen_through(best, image, d)
    ok = ~np.isnan(got[:, 0])
    a, b = np.log1p(want[ok]).ravel(), np.log1p(got[ok]).ravel()
    assert np.corrcoef(a, b)[0, 1] > 0.97
    # As a matrix, the axes and the yaw are what was asked for, to a fifth of a degree.
    made = reference.axes_matrix(best.axes) @ best.rotation.T
    asked = reference.axes_matrix(axes) @ turn.T
    assert np.degrees(np.linalg.norm(made - asked) / np.sqrt(2)) < 0.2
    assert -45 <= best.yaw < 45


@pytest.mark.parametrize("grid", ["centers", "corners"])
def test_tells_the_grid(grid):
    image = scene(sm.projection("latlong", grid=grid, axes="+z -y +x").directions(90))
    result = sm.align.identify(SOURCE, image, "latlong", "latlong")
    assert result.certain and result.best.axes == "+z -y +x"
    assert result.best.grid == grid and abs(result.best.yaw) < 0.05


def test_exposure_color_and_size_do_not_matter():
    image = scene(sm.directions("cube", 64)) * np.float32(30) * np.array([1, 0.8, 0.9], np.float32)
    result = sm.align.identify(SOURCE, image)
    assert result.certain and result.best.projection.name == "cube"
    assert result.best.axes == sm.projection("cube").axes


def test_integers_gray_and_alpha():
    bright = np.clip(SOURCE * 12, 0, 255).astype(np.uint8)
    alpha = np.dstack([bright, np.full(bright.shape[:2], 255, np.uint8)])
    for image in (alpha[:, ::-1], bright.mean(-1)[:, ::-1], bright[:, ::-1, :1]):
        result = sm.align.identify(SOURCE, image)
        assert result.certain and result.best.mirrored and result.best.axes == "-x -y -z"


def test_negative_and_invalid_texels():
    image = SOURCE[:, ::-1].copy()
    rng = np.random.default_rng(80)
    image[rng.random(image.shape[:2]) < 0.01] = -4000
    image[rng.random(image.shape[:2]) < 0.002] = np.nan
    image[rng.random(image.shape[:2]) < 0.002] = np.inf
    result = sm.align.identify(SOURCE, image)
    assert result.certain and result.best.axes == "-x -y -z"


def test_what_lies_outside_the_disk_does_not_count():
    image = sm.convert(SOURCE, "latlong", "angular", size=150, rotation=sm.rotation(-30, 0, 0))
    outside = ~sm.valid(
        np.moveaxis((np.indices((150, 150)) + 0.5) / 150, 0, -1)[..., ::-1], "angular"
    )
    image[outside] = 1e6  # a credit in white
    result = sm.align.identify(SOURCE, image)
    assert result.certain and result.best.axes == "+x -y -z"
    assert abs(result.best.yaw - 30) < 0.1


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda d: np.ones(d.shape), "no features"),
        (lambda d: 1 + d[..., 1:2] * np.ones(3), "two ways fit"),  # any yaw
        (lambda d: 1 + np.abs(d), "two ways fit"),  # mirrored or not
        (lambda d: np.zeros(d.shape), "no features"),
    ],
)
def test_says_when_it_cannot_tell(make, why):
    image = make(sm.directions("latlong", 64))
    result = sm.align.identify(image, image)
    assert not result.certain and result.best is None
    assert why in result.reason and str(result).startswith("cannot tell")


def test_another_scene_does_not_fit():
    noise = np.random.default_rng(81).random((64, 128, 3))
    result = sm.align.identify(SOURCE, noise)
    assert not result.certain and "nothing fits" in result.reason


def test_bad_input():
    with pytest.raises(ValueError, match="say which it is"):
        sm.align.identify(SOURCE, np.ones((30, 47, 3)))
    with pytest.raises(ValueError, match="finite"):
        sm.align.identify(SOURCE, np.full((32, 64, 3), np.nan))
    with pytest.raises(TypeError, match="`image_a` to be real"):
        sm.align.identify(SOURCE.astype(complex), SOURCE)
    with pytest.raises(ValueError, match="unknown projection"):
        sm.align.identify(SOURCE, SOURCE, "latlon")
    with pytest.raises(ValueError, match="to have shape"):
        sm.align.identify(SOURCE, SOURCE, "latlong", "cube")
    with pytest.raises(ValueError, match="`count`"):
        sm.align.identify(SOURCE, SOURCE, count=0)


def test_the_official_pair(data_folder):
    # One scene as OpenEXR's cube and as its latlong.
    cube = openimageio_oracle.read(data_folder / "OrientationCube.exr")[..., :3]
    panorama = openimageio_oracle.read(data_folder / "OrientationLatLong.exr")[..., :3]
    result = sm.align.identify(panorama, cube, "latlong:openexr", "cube:openexr")
    assert result.certain and result.best.score > 0.97
    row = next(r for r in sm.conventions("cube") if r["name"] == "openexr")
    assert result.best.axes == row["axes"] and result.best.grid == row["grid"]
    assert abs(result.best.yaw) < 0.05 and not result.best.mirrored


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_real_probe_mirrored_rolled_and_resampled(data_folder, mirrored):
    probe = openimageio_oracle.read(data_folder / "grace_probe.hdr")[..., :3]
    panorama = np.roll(sm.convert(probe, "angular", "latlong", size=300), 100, axis=1)
    if mirrored:
        panorama = panorama[:, ::-1]
    result = sm.align.identify(probe, panorama, "angular:debevec", "latlong")
    assert result.certain and result.best.mirrored == mirrored
    assert result.best.score > 0.99
    # Rolled to the right by 100 of 600 columns, what was ahead is 60° to the right.
    turn = reference.axes_matrix(result.best.axes) @ result.best.rotation.T
    view = turn @ [0, 0, -1]
    side = -1 if mirrored else 1
    # The search has texels of 2.8°; a parabola through its peak is good to 1/14 of one.
    assert np.degrees(np.arctan2(view[0], view[2])) == pytest.approx(side * 60, abs=0.2)


CUBE = sm.convert(SOURCE, "latlong", "cube", size=64)
COLUMN = sm.projection("cube", layout="column")


def provoked(way: str) -> np.ndarray:
    """Return the cube with something wrong that a score over all faces forgives."""
    image = CUBE.copy()
    if way == "swapped":
        image[[4, 5]] = image[[5, 4]]
    elif way == "turned":
        image[2], image[3] = np.rot90(image[2]), np.rot90(image[3])
    elif way == "half turn":
        image[2] = np.rot90(image[2], 2)
    elif way == "upside down":
        image = image[:, ::-1].copy()
    elif way == "one mirrored":
        image[0] = image[0, :, ::-1]
    return image


@some_fast(
    ("way", "words"),
    [
        ("swapped", "face +z shows -z; face -z shows +z"),
        ("turned", "face +y shows +y turned by 90°; face -y shows -y turned by 90°"),
        ("half turn", "face +y shows +y turned by 180°"),
        ("upside down", "each shows its own side mirrored and turned by 180°"),
        ("one mirrored", "face +x shows +x mirrored"),
    ],
    fast=[("one mirrored", "face +x shows +x mirrored")],
)
def test_a_face_that_does_not_fit_is_named(way, words):
    result = sm.align.identify(SOURCE, provoked(way), "latlong", "cube")
    assert not result.certain and result.best is None
    assert words in result.reason, result.reason


@some_fast(
    ("given", "true"),
    [
        ("mollweide", "latlong"),
        ("latlong", "mollweide"),
        ("hammer", "sinusoidal"),
        ("cube_equiangular", "cube"),
        ("cube", "cube_equiangular"),
        ("angular", "sphere"),
    ],
    fast=[("cube", "cube_equiangular")],
)
def test_the_kind_that_fits_is_named_where_the_given_one_does_not(given, true):
    image = sm.convert(SOURCE, "latlong", true, size=120)
    result = sm.align.identify(SOURCE, image, "latlong", given)
    assert not result.certain
    assert f"image_b fits as '{true}'" in result.reason and f"not as '{given}'" in result.reason
    assert result.candidates[0].kind == true and f"as {true}" in str(result.candidates[0])


def test_the_first_image_may_be_of_another_kind():
    image = sm.convert(SOURCE, "latlong", "mollweide", size=120)
    result = sm.align.identify(image, CUBE, "latlong", "cube")
    assert not result.certain and "image_a fits as 'mollweide'" in result.reason


@some_fast("row", ["py360convert-list", "equilib-list", "unreal", "cmft"], fast=("cmft",))
def test_faces_in_the_order_of_a_row(row):
    # A cube as another program stores it, taken for one of ours.
    p = sm.projection("cube", convention=row)
    image = sm.convert(SOURCE, "latlong", p, size=64)
    result = sm.align.identify(SOURCE, image, "latlong", "cube")
    assert result.certain, str(result)
    assert result.best.score > 0.98
    assert f"cube:{row}" in result.rows or f"cube:{row}" in result.reason, str(result)
    d = sm.directions("octahedral", 40).reshape(-1, 3)
    want, got = sm.sample(SOURCE, d, "latlong"), seen_through(result.best, image, d)
    assert np.corrcoef(np.log1p(want).ravel(), np.log1p(got).ravel())[0, 1] > 0.97


@some_fast(
    ("row", "layout"),
    [
        ("openexr", "column"),
        ("py360convert-horizon", "strip"),
        ("equilib-horizon", "strip"),
    ],
    fast=[("openexr", "column")],
)
def test_faces_in_the_order_of_a_row_in_one_picture(row, layout):
    p = sm.projection("cube", convention=row)
    image = scene(p.directions(64))
    given = sm.projection("cube", layout=layout)
    result = sm.align.identify(SOURCE, image, "latlong", given)
    assert result.certain and f"stored as in cube:{row}" in result.reason, str(result)
    best = result.best.projection
    assert (best.layout, best.axes, best.grid) == (p.layout, p.axes, p.grid)
    d = sm.directions("octahedral", 40).reshape(-1, 3)
    assert np.abs(best.encode(d) - p.encode(d)).max() < 1e-12  # Roundings of other axes.


@some_fast(
    ("layout", "way", "words"),
    [
        ("column", "swapped x", "face +x shows -x; face -x shows +x"),
        ("strip", "half turn", "face +y shows +y turned by 180°"),
        ("cross", "turned", "face +y shows +y turned by 90°; face -y shows -y turned by 90°"),
        ("vertical_cross", "one mirrored", "face +x shows +x mirrored"),
        ("3x2", "upside down", "each shows its own side mirrored and turned by 180°"),
    ],
    fast=[("column", "swapped x", "face +x shows -x; face -x shows +x")],
)
def test_a_face_that_does_not_fit_is_named_in_one_picture(layout, way, words):
    image = CUBE[[1, 0, 2, 3, 4, 5]] if way == "swapped x" else provoked(way)
    p = sm.projection("cube", layout=layout)
    # Nearest texels: nothing is mixed where neighbors are wrong.
    picture = sm.convert(image, "cube", p, size=64, filter="nearest")
    result = sm.align.identify(SOURCE, picture, "latlong", p)
    assert not result.certain and result.best is None
    assert words in result.reason, result.reason


def test_a_face_of_something_else_in_one_picture_is_named():
    image = CUBE.copy()
    image[4] = np.random.default_rng(82).random(image[4].shape)
    result = sm.align.identify(SOURCE, image.reshape(384, 64, 3), "latlong", COLUMN)
    assert not result.certain and "face +z does not" in result.reason, result.reason


def test_faces_are_named_by_where_the_given_map_has_them():
    p = sm.projection("cube:py360convert-list")  # its first face is +z
    image = scene(p.directions(64))
    image[0] = np.rot90(image[0], 2)
    result = sm.align.identify(SOURCE, image, "latlong", p)
    assert "face +z shows +z turned by 180°" in result.reason, result.reason


def test_a_picture_of_another_kind_and_one_of_another_order():
    image = scene(sm.projection("cube_equiangular", layout="column").directions(64))
    result = sm.align.identify(SOURCE, image, "latlong", COLUMN)
    assert not result.certain and "fits as 'cube_equiangular'" in result.reason, str(result)
    # Another order may be near to another kind in this one.
    image = scene(COLUMN.directions(64))
    result = sm.align.identify(SOURCE, image, "latlong", "cube:openexr")
    assert result.certain and "faces stored as in cube:" in result.reason, str(result)


@pytest.mark.parametrize("layout", ["column", "cross"])
def test_another_scene_in_one_picture_does_not_fit(layout):
    p = sm.projection("cube", layout=layout)
    noise = np.random.default_rng(83).random((6, 64, 64, 3))
    picture = sm.convert(noise, "cube", p, size=64)
    assert not sm.align.identify(SOURCE, picture, "latlong", p).certain
    smooth = scene(p.directions(64) @ sm.rotation(10, 70, 20))
    assert not sm.align.identify(SOURCE, smooth, "latlong", p).certain


def test_rows_of_the_table_end_the_answer():
    result = sm.align.identify(SOURCE, CUBE, "latlong", "cube")
    assert "cube:opengl" in result.rows
    assert str(result).splitlines()[-1].startswith("as in the table: cube:")
    turned = sm.convert(
        SOURCE, "latlong", sm.projection("cube").turned(sm.rotation(20, 0, 0)), size=64
    )
    assert sm.align.identify(SOURCE, turned, "latlong", "cube").rows == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["venice", "studio", "park", "night"])
def test_real_scenes_do_not_mislead(data_folder, name):
    image = openimageio_oracle.read(data_folder / f"{name}.exr")[..., :3]
    cube = sm.convert(image, "latlong", "cube", size=96)
    assert sm.align.identify(image, cube, "latlong", "cube").certain
    joined = (6 * 96, 96, 3)
    assert sm.align.identify(image, cube.reshape(joined), "latlong", COLUMN).certain
    turned = cube.copy()
    turned[2] = np.rot90(turned[2])
    for wrong in (cube[[0, 1, 2, 3, 5, 4]], cube[:, ::-1], turned):
        assert not sm.align.identify(image, wrong, "latlong", "cube").certain
    for wrong in (cube[[1, 0, 2, 3, 4, 5]], cube[:, ::-1], turned):
        assert not sm.align.identify(image, wrong.reshape(joined), "latlong", COLUMN).certain


@pytest.mark.slow
def test_no_unrelated_scenes_are_related(data_folder):
    names = ("venice", "studio", "park", "night")
    scenes = {n: openimageio_oracle.read(data_folder / f"{n}.exr")[..., :3] for n in names}
    for name, image in scenes.items():
        cube = sm.convert(image, "latlong", "cube", size=96)
        for other, unrelated in scenes.items():
            if other > name:
                assert not sm.align.identify(image, unrelated, "latlong", "latlong").certain
                assert not sm.align.identify(unrelated, cube, "latlong", "cube").certain
                column = cube.reshape(-1, 96, 3)
                assert not sm.align.identify(unrelated, column, "latlong", COLUMN).certain
                assert not sm.align.identify(cube, unrelated[::-1], "cube", "latlong").certain


@some_fast(
    ("a", "b"),
    [
        ("latlong:blender", "cube:opengl"),
        ("latlong:unity", "latlong:mitsuba"),
        ("latlong", "cube:unreal"),
    ],
    fast=[("latlong", "cube:unreal")],
)
def test_the_rows_are_those_that_convert_makes(a, b):
    source = sm.convert(SOURCE, "latlong", a, size=120)
    image = sm.convert(source, a, b, size=64)
    kind = b.split(":")[0]
    result = sm.align.identify(source, image, a, kind)
    assert result.certain and b in result.rows, str(result)
    # What is found turns the second into the first again, also where b's program is given.
    best = sm.align.identify(source, image, a, b).best
    assert best.projection.world == sm.projection(a).world
    back = sm.convert(image, best.projection, a, size=60, rotation=best.rotation)
    want = sm.convert(source, a, a, size=60)
    assert np.corrcoef(np.log1p(want).ravel(), np.log1p(back).ravel())[0, 1] > 0.97


def test_a_batch_is_answered_by_what_to_write():
    images = np.ones((3, 8, 16, 3))
    with pytest.raises(
        ValueError, match=r"`image_b` to be one image, got a batch .*identify\(a, b\)"
    ):
        sm.align.identify(images[0], images, "latlong", "latlong")


def test_a_view_of_more_texels_than_there_are_addresses():
    huge = np.broadcast_to(np.uint8(1), (2**30, 2**31))
    with pytest.raises(MemoryError, match="no room"):
        sm.align.identify(huge, np.ones((8, 16)), "latlong", "latlong")


@some_fast(
    "program",
    ["blender", "healpy", "unreal", "pbrt", "usd-z-up", "openimageio-z-up"],
    fast=("blender", "openimageio-z-up"),
)
def test_a_yaw_is_about_what_is_up_in_the_world_of_the_first(program):
    name = f"latlong:{program}"
    source = sm.convert(SOURCE, "latlong", name, size=64)
    image = np.roll(source, 5, axis=1)
    result = sm.align.identify(source, image, name, name)
    best = result.best
    # 5 of 128 columns; `with_grid` tries yaws 0.07° apart.
    assert result.certain and abs(abs(best.yaw) - 5 / 128 * 360) < 0.15, str(result)
    assert best.axes == sm.projection(name).axes and not best.mirrored
    up = sm.projection(name).world.split()[1]
    assert f"° about {up}" in str(result).splitlines()[1]
    assert best.projection.world == sm.projection(name).world
    # What is up stays.
    axis = "xyz".index(up[1])
    assert best.rotation[axis, axis] == 1
    d = sm.directions("octahedral", 40).reshape(-1, 3)
    want, got = sm.sample(source, d, name), seen_through(best, image, d)
    # A yaw 0.1° off on slopes of some units a radian.
    assert np.sqrt(np.mean((want - got) ** 2)) < 0.02 * np.std(want)


def test_what_multiplies_a_channel_does_not_matter():
    plain = sm.align.identify(SOURCE, CUBE, "latlong", "cube").candidates[0]
    image = CUBE * np.array([0.2, 1, 3], np.float32)
    found = sm.align.identify(SOURCE, image, "latlong", "cube").best
    # Roundings of float32, in a correlation.
    assert found is not None and abs(found.score - plain.score) < 1e-5


def test_numbers_beyond_float32():
    wide = SOURCE[::2, ::2].astype(np.float64)
    result = sm.align.identify(wide * 1e300, wide[:, ::-1] * 1e-300)
    assert result.certain and result.best.axes == "-x -y -z"


def test_a_grid_finer_than_the_first_image_can_tell_is_not_told(data_folder):
    venice = openimageio_oracle.read(data_folder / "venice.exr")[..., :3]
    small = sm.convert(venice, "latlong", "latlong", size=64)
    fine = sm.convert(small, "latlong", "latlong", size=200)
    result = sm.align.identify(small, fine)
    assert result.certain and result.best.grid in (None, "centers"), str(result)
