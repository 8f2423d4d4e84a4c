"""Borders: exact permutations where they are, and everywhere what the sphere holds there."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import DEFAULTS, GRIDS, LAYOUTS, each

DTYPES = (np.uint8, np.uint16, np.float16, np.float32, np.float64)


def inner(padded: np.ndarray, n: int, channels: int) -> np.ndarray:
    rows = slice(n, -n or None)
    return padded[(..., rows, rows) + (slice(None),) * channels]


@each(DEFAULTS)
@pytest.mark.parametrize("n", [0, 1, 3, 20])
def test_the_image_stays_inside(case, n):
    p = case.make()
    rng = np.random.default_rng(220)
    for dtype in DTYPES:
        for channels in ((), (3,)):
            image = (rng.random((*p.shape(8), *channels)) * 200).astype(dtype)
            got = sm.pad(image, p, n)
            assert got.dtype == dtype
            want = (*image.shape[: -2 - len(channels)],)
            height, width = p.shape(8)[-2:]
            assert got.shape == (*want, height + 2 * n, width + 2 * n, *channels)
            assert np.array_equal(inner(got, n, len(channels)), image)


@each([c for c in DEFAULTS if c.make().coverage == "sphere"])
@pytest.mark.parametrize("grid", GRIDS)
def test_a_border_shows_what_lies_there(case, grid):
    # The slope of a smooth function goes on over the edge: no step of the border is larger than
    # twice the largest step inside. Over a pole whose rows are √v away from it, from the first row
    # to itself half a turn around: 2√½/(√1½ - √½) = 2.73 times the next step.
    p = case.make(grid=grid)
    n = 64
    d = np.nan_to_num(p.directions(n))
    image = reference.smooth_function(d)
    padded = sm.pad(image, p, 2)
    r = reference.of(p)
    faces = padded if padded.ndim == 4 else padded[None]
    height, width = faces.shape[1:3]
    ok = np.zeros((height, width), bool)
    ok[2:-2, 2:-2] = ~np.isnan(p.directions(n)[..., 0]).reshape(-1, height - 4, width - 4)[0]
    across = ok[:, 1:] | ok[:, :-1]
    inside = ok[:, 1:] & ok[:, :-1]
    for face in faces:
        step = np.abs(np.diff(face, axis=1)).max(-1)
        border = across & ~inside
        if r.used_part < 1:
            border[:, 2:-2] = False  # corners of the image itself hold nothing
        assert step[border].max(initial=0) <= 2 * step[inside].max()
        down = np.abs(np.diff(face, axis=0)).max(-1)[:, 2:-2]
        if r.used_part == 1:
            most = 3 if case.name in reference.ROOT_RIMS else 2
            # Steps of some 0.1 round by ε: this only lets equal ones be equal.
            assert down[[1, -2]].max() <= most * down[2:-2].max() + 1e-9


def test_latlong_is_a_permutation():
    image = np.arange(4 * 8).reshape(4, 8).astype(np.uint16)
    got = sm.pad(image, "latlong", 1)
    assert np.array_equal(got[1:-1], np.concatenate([image[:, -1:], image, image[:, :1]], 1))
    assert np.array_equal(got[0], np.roll(got[1, 1:-1], 4)[np.arange(-1, 9) % 8])
    # Around a pole twice: the rows come back.
    wide = sm.pad(image, "latlong", 8)
    assert np.array_equal(wide[0, 8:16], image[0]) and np.array_equal(wide[8:12, 8:16], image)
    odd = np.array([[1.0, 2.0, 4.0]])
    assert np.array_equal(sm.pad(odd, "latlong", 1)[0, 1:4], [3.0, 2.5, 1.5])
    assert np.array_equal(sm.pad(odd.astype(np.uint8), "latlong", 1)[0, 1:4], [3, 3, 2])


def test_octahedral_is_a_permutation():
    image = np.arange(16.0).reshape(4, 4)
    got = sm.pad(image, "octahedral", 1)
    assert np.array_equal(got[0, 1:5], image[0, ::-1]) and np.array_equal(
        got[-1, 1:5], image[-1, ::-1]
    )
    assert np.array_equal(got[1:5, 0], image[::-1, 0])
    # Beyond a corner lies the opposite one: all four are one direction.
    assert got[0, 0] == image[3, 3] and got[0, 5] == image[3, 0]


@pytest.mark.parametrize("grid", GRIDS)
def test_corner_grids_do_not_repeat_the_edge(grid):
    p = sm.projection("latlong", grid=grid)
    image = sm.sample(
        np.random.default_rng(221).random((9, 17)), sm.directions(p, (9, 17)), "latlong"
    )
    padded = sm.pad(image, p, 1)
    # With a row on the pole, what lies beyond it is the row next to the pole.
    row, turn = (0, 17) if grid == "centers" else (1, 16 if grid == "corners" else 17)
    near, far = (image[row, (8 + k + turn // 2) % turn] for k in (0, turn % 2))
    # The mean of two numbers below 1: one rounding, or none.
    assert padded[0, 9] == pytest.approx((near + far) / 2, abs=1e-15)
    # With a column on the seam, the last is the first, and the next is the second.
    assert padded[1, -1] == (image[0, 1] if grid == "corners" else image[0, 0])
    q = sm.projection("octahedral", grid=grid)
    square = np.random.default_rng(222).random((6, 6))
    beside = 1 if grid == "corners" else 0
    assert np.array_equal(sm.pad(square, q, 1)[1:-1, 0], square[::-1, beside])


@each([c for c in LAYOUTS if c.make().layout is not None])
def test_faces_continue_their_own_formula(case):
    p = case.make()
    apart = sm.projection(case.name)
    n, border = 32, 3
    image = np.nan_to_num(reference.smooth_function(np.nan_to_num(p.directions(n))))
    got = sm.pad(image, p, border)
    assert got.shape == (apart.faces, n + 2 * border, n + 2 * border, 3)
    for face in range(apart.faces):
        if case.name != "cube":
            continue
        # The plane of the face, larger: what a wider picture of it shows.
        i = (np.arange(-border, n + border) + 0.5) / n * 2 - 1
        q, x = np.meshgrid(i, i, indexing="ij")
        r = reference.make("cube")
        d = reference.permute(
            r.axes, reference.decode_cube(x, q, np.full_like(x, face), {}), back=True
        )
        want = reference.smooth_function(reference.unit(d))
        # Bilinear: 1/8 h² |f''|, h = 2/32 and |f''| < 8.
        assert np.abs(got[face] - want).max() < (2 / n) ** 2


@pytest.mark.parametrize("row", sm.conventions("cube"), ids=lambda row: row["name"])
def test_conventions_of_cubes_pad_alike(row):
    p = sm.projection("cube", convention=row["name"], layout="faces", grid="centers")
    image = reference.smooth_function(p.directions(24)).astype(np.float64)
    got = sm.pad(image, p, 2)
    inside = np.abs(np.diff(image, axis=1)).max()
    assert np.abs(np.diff(got, axis=1)).max() < 1.6 * inside


def test_where_nothing_lies_beyond_edges_repeat():
    image = np.random.default_rng(222).random((5, 5))
    for name in ("perspective", "hemioctahedral"):
        assert np.array_equal(sm.pad(image, name, 2), np.pad(image, 2, mode="edge"))
    ring = sm.pad(np.full((16, 16), 7.0), "matcap", 2)
    assert np.all(ring == 7)
    wide = np.random.default_rng(223).random((4, 16))
    got = sm.pad(wide, "cylindrical", 2)
    assert np.array_equal(got[2:-2], np.concatenate([wide[:, -2:], wide, wide[:, :2]], 1))
    assert np.array_equal(got[0], got[2]) and np.array_equal(got[-1], got[-3])


def test_bad_borders_are_refused():
    image = np.zeros((4, 8))
    with pytest.raises(ValueError, match="of 0 to"):
        sm.pad(image, "latlong", -1)
    with pytest.raises(TypeError):
        sm.pad(image, "latlong", 1.5)
    with pytest.raises(ValueError, match=r"shape \(F, N, N\)"):
        sm.pad(image, "cube", 1)
    with pytest.raises(TypeError, match="dtype"):
        sm.pad(image.astype(complex), "latlong", 1)


@pytest.mark.parametrize("filter", ["area", "mode", "ewa", "trilinear"])
@each(DEFAULTS)
def test_filters_that_look_nothing_up_are_refused_by_all_maps(case, filter):
    p = case.make()
    with pytest.raises(ValueError, match="looks no direction up"):
        sm.pad(np.zeros(p.shape(8)), p, 1, filter=filter)
