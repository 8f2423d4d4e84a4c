"""ffmpeg's v360 filter against the maps of its conventions."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm

from oracles import ffmpeg_oracle as oracle

# What v360 calls a layout, our name for it as it writes it, and a shape.
WRITTEN = {
    "e": ("latlong:ffmpeg-output", (100, 200)),
    "c3x2": ("cube:ffmpeg-c3x2", (128, 192)),
    "c6x1": ("cube:ffmpeg-c6x1", (40, 240)),
    "c1x6": ("cube:ffmpeg-c1x6", (240, 40)),
    "ball": ("sphere:ffmpeg", (100, 100)),
}
# Its four weights are multiples of 2^-14, so that their sum is off by up to two of them, and the
# result is an integer.
QUANTIZATION = 2 / 2**14 * 65535 + 1


def scene(d: np.ndarray) -> np.ndarray:
    """Return values from 8000 to 56000, 0 where there is no direction."""
    ok = ~np.isnan(d[..., 0])
    values = reference.smooth_function(np.where(ok[..., None], d, 0.5))[..., 0]
    return np.where(ok, 32000 + 12000 * values, 0)


@pytest.fixture(autouse=True)
def _say_the_version(record_property):
    record_property("oracle", oracle.version())
    print(f"ran against {oracle.version()}")


@pytest.mark.parametrize("target", WRITTEN)
def test_what_it_writes(target):
    # From a panorama that is fine enough to leave only the quantization.
    source = scene(sm.directions("latlong:ffmpeg", 512))
    name, shape = WRITTEN[target]
    d = sm.directions(name, shape)
    got, want = oracle.v360(source, "e", target, shape), scene(d)
    ok = ~np.isnan(d[..., 0])
    # A curve bends by 12000 · 6/8 · (2π/1024)² = 0.3 between two texels.
    assert np.abs(got - want)[ok].max() < QUANTIZATION + 1


# What v360 calls the maps of src/convention/views.rs, with what it must be told, and a shape.
ROUND = ":h_fov=180:v_fov=180"
VIEWS = {
    "angular": ("fisheye" + ROUND, (100, 100)),
    "equisolid": ("equisolid" + ROUND, (100, 100)),
    "stereographic": ("sg" + ROUND, (100, 100)),
    "orthographic": ("og" + ROUND, (100, 100)),
    "perspective": ("flat:h_fov=90:v_fov=90", (100, 100)),
    "octahedral": ("octahedron", (100, 100)),
    "lambert_cylindrical": ("cylindricalea", (100, 314)),
    "dual_fisheye": ("dfisheye" + ROUND, (100, 200)),
    "mercator": ("mercator", (100, 100)),
    "hammer": ("hammer", (100, 200)),
    "sinusoidal": ("sinusoidal", (100, 200)),
    "tetrahedral": ("tetrahedron", (90, 208)),
}


@pytest.mark.parametrize("kind", VIEWS)
def test_views_and_world_maps(kind):
    source = scene(sm.directions("latlong:ffmpeg", 512))
    target, shape = VIEWS[kind]
    d = sm.directions(f"{kind}:ffmpeg", shape)
    got, want = oracle.v360(source, "e", target, shape), scene(d)
    ok = ~np.isnan(d[..., 0])
    assert ok.mean() > 0.6
    assert np.abs(got - want)[ok].max() < QUANTIZATION + 1


def test_each_of_its_rows_was_run():
    rows = {row["kind"] for row in sm.conventions() if row["name"] == "ffmpeg"}
    assert rows == {"latlong", "sphere", *VIEWS}


@pytest.mark.parametrize(
    ("source", "name", "shape"),
    [
        ("e", "latlong:ffmpeg", (512, 1024)),
        ("c3x2", "cube:ffmpeg-c3x2", (512, 768)),
        ("c6x1", "cube:ffmpeg-c6x1", (256, 1536)),
        ("c1x6", "cube:ffmpeg-c1x6", (1536, 256)),
    ],
)
def test_what_it_reads(source, name, shape):
    image = scene(sm.directions(name, shape))
    size = (150, 300)
    d = sm.directions("latlong:ffmpeg-output", size)
    got, want = oracle.v360(image, source, "e", size), scene(d)
    # Between two faces it has rules of its own: leave out what lies within a texel of an edge.
    inside = np.ones(size, bool)
    if sm.projection(name).name == "cube":
        uv = sm.encode(d, "cube", axes="+x +y +z")[..., :2]
        inside = (np.abs(uv - 0.5) < 0.5 - 1 / 256).all(-1)
    assert inside.mean() > 0.9
    assert np.abs(got - want)[inside].max() < QUANTIZATION + 1


def test_reading_and_writing_a_panorama_differ_by_half_a_texel():
    # Its own e to e is no identity, and that is what the two rows say.
    image = scene(sm.directions("latlong:ffmpeg-output", 128))
    got = oracle.v360(image, "e", "e", image.shape)
    assert np.abs(got - image).max() > 5 * QUANTIZATION
    read = sm.sample(image, sm.directions("latlong:ffmpeg-output", 128), "latlong:ffmpeg")
    assert np.abs(got - read).max() < QUANTIZATION + 1
