"""compare: what it says of known pairs, and that its matrix is what both maps do."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import NAMES
from hypothesis import given
from hypothesis import strategies as st

ROWS = [f"{row['kind']}:{row['name']}" for row in sm.conventions()]
ALL_AXES = [
    f"{a}{x} {b}{y} {c}{z}"
    for x, y, z in ("xyz", "xzy", "yxz", "yzx", "zxy", "zyx")
    for a in "+-"
    for b in "+-"
    for c in "+-"
]


def same_kind(a: str, b: str) -> bool:
    p, q = sm.projection(a), sm.projection(b)
    return p.name == q.name and p.parameters == q.parameters


@pytest.mark.parametrize(
    ("a", "b", "says"),
    [
        ("latlong:ict", "latlong:nvdiffrec", "the same, texel by texel"),
        ("latlong:skylibs", "latlong:threejs", "yaw"),
        ("latlong:skylibs", "latlong:openexr", "yaw 180°"),
        ("latlong:mitsuba", "latlong:openimageio", "grid differs: corners-v and centers"),
        ("latlong:skylibs", "latlong:cmft", "mirrored (z changes sign)"),
        ("latlong:blender", "latlong:threejs", "+z, which is up, becomes +y"),
        ("angular:debevec", "angular:openimageio", "mirrored (z changes sign)"),
        ("cube:opengl", "cube:threejs", "mirrored (x changes sign)"),
        ("cube:opengl", "cube:openexr", "0 1 2 3 5 4 of the second"),
        ("cube:opengl", "cube:py360convert-list", "face order differs"),
        ("cube:directxtex-v-cross", "cube:directxtex-v-cross-fnz", "layout differs"),
        ("latlong:blender", "cube:opengl", "another kind of image"),
        ("angular", "angular:skylibs-skyangular", "fov 180"),
    ],
)
def test_words(a, b, says):
    assert says in str(sm.align.compare(a, b))


def test_a_quarter_turn_has_the_sign_of_rotation():
    # What `rotation(yaw, 0, 0)` does to directions, compare calls yaw.
    base = sm.projection("latlong")
    for yaw, axes in ((90, "-z -y -x"), (-90, "+z -y +x"), (180, "-x -y +z")):
        found = sm.align.compare(base, sm.projection("latlong", axes=axes))
        # `rotation`'s cosine of 90° is 6e-17; the matrix found is of 0 and ±1.
        assert np.abs(found.matrix - sm.rotation(yaw, 0, 0)).max() < 1e-12
        assert found.differences == (f"yaw {yaw}°",)


@given(st.sampled_from(ALL_AXES), st.sampled_from(ALL_AXES), st.sampled_from(NAMES))
def test_the_matrix_is_what_the_maps_do(a, b, name):
    p, q = sm.projection(name, axes=a), sm.projection(name, axes=b)
    found = sm.align.compare(p, q)
    uv = 0.5 + 0.35 * np.random.default_rng(70).uniform(-1, 1, (50, 2))
    if p.faces > 1:
        uv = np.hstack([uv, np.arange(50)[:, None] % p.faces])
    d = p.decode(uv)
    held = np.isfinite(d[:, 0])
    assert held.sum() > 20
    # Axes swap and negate components, after the same decoding: at most the last bits of 1.
    assert np.abs(d @ found.matrix.T - q.decode(uv))[held].max() < 1e-15
    assert found.mirrored == (p.mirrored != q.mirrored)
    assert found.same == (a == b) and (found.differences == ()) == found.same
    back = sm.align.compare(q, p)
    assert np.array_equal(back.matrix, found.matrix.T)


@pytest.mark.parametrize("a", ROWS[::3])
def test_every_pair_of_rows_has_an_answer(a):
    for b in ROWS:
        found = sm.align.compare(a, b)
        assert found.same == (a == b or "the same, texel by texel" in str(found).splitlines())
        if not same_kind(a, b):
            assert found.matrix is None and not found.same
        if found.matrix is not None:
            assert np.array_equal(found.matrix @ found.matrix.T, np.eye(3))
        if found.same:
            p, q = sm.projection(a), sm.projection(b)
            size = p.shape(4)
            assert np.array_equal(p.directions(size), q.directions(size), equal_nan=True)


def test_faces_that_turn_each_in_its_own_way_have_no_matrix():
    # Read as a stack of the same order, OpenEXR's last two faces are mirrored the other way round.
    a = sm.projection("cube", layout="column")
    b = sm.projection("cube", convention="openexr", grid="centers")
    found = sm.align.compare(a, b)
    assert found.matrix is None and found.mirrored is None
    text = str(found)
    assert "cell (0, 0): mirrored (z" in text and "cell (0, 4): mirrored (x" in text


def test_bad_names():
    with pytest.raises(ValueError, match="did you mean 'latlong'"):
        sm.align.compare("latlon", "cube")
    with pytest.raises(ValueError, match=r"'cube' has ffmpeg-c1x6, ffmpeg-c3x2"):
        sm.align.compare("latlong", "cube:ffmpeg")
    with pytest.raises(TypeError, match="Projection or the name"):
        sm.align.compare(3, "cube")
