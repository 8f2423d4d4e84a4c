"""Windows of a result, and the tiles of a source that they see."""

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from spheremap.resample.seen import Rectangle, SourceTiles, tiles

rng = np.random.default_rng(11)

CROSS = sm.projection("cube", layout="cross")

# Faces apart, an atlas with empty cells, rims, poles, blind spots, a grid of corners.
TARGETS = {
    "cube": (6, 80, 80),
    "cube:filament": (240, 320),
    "angular": (150, 150),
    "sphere": (96, 96),
    "latlong:mitsuba": (90, 180),
    "dual_paraboloid": (2, 90, 90),
    "cube:openexr": (486, 81),
    "healpix": (12, 32, 32),
}


def windows(shape, many):
    """Return some windows of an image of this shape."""
    *faces, rows, columns = shape
    for _ in range(many):
        top, bottom = np.sort(rng.integers(0, rows + 1, 2))
        left, right = np.sort(rng.integers(0, columns + 1, 2))
        face = (int(rng.integers(faces[0])),) if faces else ()
        yield (slice(int(top), int(bottom)), slice(int(left), int(right)), *face)


def cut(image, window):
    rows, columns, *face = window
    return image[(*face, rows, columns)]


@pytest.mark.parametrize("dst", TARGETS)
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"antialias": False, "filter": "lanczos3"},
        pytest.param({"filter": "area", "skipna": True}, marks=pytest.mark.slow),
        {"filter": "trilinear", "alpha": -1},
        {"filter": "nearest"},
    ],
    ids=lambda options: options.get("filter", "default"),
)
def test_windows_have_the_bits_of_the_whole(dst, options):
    image = rng.random((100, 200, 2)).astype(np.float32)
    shape = TARGETS[dst]
    whole = sm.convert(image, "latlong", dst, size=shape, **options)
    for window in windows(shape, 4):
        part = sm.convert(image, "latlong", dst, size=shape, window=window, **options)
        np.testing.assert_array_equal(part, cut(whole, window))


def test_windows_of_batches_channels_first_labels_and_out():
    images = rng.integers(0, 9, (2, 1, 40, 80), np.int64)
    window = (slice(2, 9), slice(-4, None), -1)
    options = {"size": 32, "filter": "nearest", "channels_first": True}
    whole = sm.convert(images, "latlong", "cube", **options)
    part = sm.convert(images, "latlong", "cube", window=window, **options)
    np.testing.assert_array_equal(part, whole[:, 5, :, 2:9, -4:])
    out = np.empty((7, 4))
    one = images[0, 0].astype(float)
    assert sm.convert(one, "latlong", "cube", size=32, window=window, out=out) is out
    np.testing.assert_array_equal(out, sm.convert(one, "latlong", "cube", size=32)[5, 2:9, -4:])


def test_a_window_of_what_no_memory_holds():
    image = np.ones((8, 16), np.float32)
    window = (slice(99_000, 99_010), slice(5, 25), 3)
    assert (sm.convert(image, "latlong", "cube", size=100_000, window=window) == 1).all()


@pytest.mark.parametrize(
    ("dst", "window", "error"),
    [
        ("cube", (slice(0, 1), slice(0, 1)), TypeError),
        ("cube", (slice(0, 1), slice(0, 1), 6), ValueError),
        ("cube", (slice(0, 1), slice(0, 1), 0.0), TypeError),
        ("latlong", (slice(0, 1), slice(0, 1), 0), TypeError),
        ("latlong", (slice(0, 8, 2), slice(0, 1)), ValueError),
        ("latlong", (slice("a", 2), slice(0, 1)), TypeError),
        ("latlong", (1, slice(0, 1)), TypeError),
        ("latlong", [slice(0, 1), slice(0, 1)], TypeError),
        ("latlong", 7, TypeError),
    ],
)
def test_what_is_no_window_is_an_error(dst, window, error):
    with pytest.raises(error, match="window"):
        sm.convert(np.zeros((8, 16)), "latlong", dst, size=8, window=window)


@pytest.mark.parametrize("dst", TARGETS)
@pytest.mark.parametrize("src", ["latlong", "cube", "angular"])
@some_fast("filter", ["bilinear", "lanczos3"], fast=("bilinear",))
def test_a_window_needs_no_tile_but_those_it_sees(src, dst, filter):
    source = sm.projection(src)
    target = sm.projection(dst).in_world_of(source)
    shape = source.shape(192)
    image = rng.random(shape)
    parts = tiles(shape, (24, 32))
    known = SourceTiles(source, shape, parts)
    whole = sm.convert(image, source, dst, size=TARGETS[dst], filter=filter)
    unseen = 0
    for window in tiles(TARGETS[dst], (40, 50)):
        seen = known.seen_by(target, TARGETS[dst], window)
        partly = np.full(shape, np.nan)
        for k in seen:
            partly[parts[k].index] = image[parts[k].index]
        part = sm.convert(
            partly, source, dst, size=TARGETS[dst], filter=filter, window=window.window
        )
        np.testing.assert_array_equal(part, whole[window.index])
        unseen += len(parts) - len(seen)
    assert unseen > 0


@pytest.mark.parametrize(("src", "dst"), [("latlong", "cube"), ("angular", "latlong:mitsuba")])
def test_a_mean_needs_no_tile_but_those_it_sees(src, dst):
    test_a_window_needs_no_tile_but_those_it_sees(src, dst, "area")


@pytest.mark.parametrize(
    ("name", "layout"), [("cube", "cross"), ("cube:openexr", None), ("healpix", "4x3")]
)
def test_faces_side_by_side_are_apart(name, layout):
    source = sm.projection("latlong")
    target = sm.projection(name, layout=layout).in_world_of(source)
    size = target.shape(200)
    known = SourceTiles(source, (800, 1600), tiles((800, 1600), (50, 50)))
    # Of 512: what holds a pole sees the rows there. What saw its neighbor as well would see all.
    for window in tiles(size, (100, 100), target):
        assert len(known.seen_by(target, size, window)) <= 200


def test_tiles_are_the_image():
    covered = np.zeros((2, 7, 9), int)
    for tile in tiles(covered.shape, (3, 4)):
        covered[tile.index] += 1
    assert (covered == 1).all()
    assert tiles((4, 4), (4, 4)) == [Rectangle(0, 4, 0, 4)]
    covered = np.zeros((15, 20), int)
    for tile in tiles(covered.shape, (3, 4), CROSS):
        covered[tile.index] += 1
        assert tile.top // 5 == (tile.bottom - 1) // 5 and tile.left // 5 == (tile.right - 1) // 5
    assert (covered == 1).all()
