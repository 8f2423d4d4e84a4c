"""OpenImageIO's environment() and its light-probe conversion against sample and convert."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import random_directions

from oracles import openimageio_oracle as oracle

N = 12_000
CONVENTION = "latlong:openimageio"


def directions(seed: int) -> np.ndarray:
    """Random ones and many near the poles and the seam (x = 0, z < 0), all exact in float32."""
    rng = np.random.default_rng(seed + 1)
    pole = rng.normal(size=(500, 3)) * [0.02, 0, 0.02] + [0, 1, 0]
    pole[::2, 1] = -1
    seam = np.stack([rng.normal(size=500) * 1e-2, rng.uniform(-1, 1, 500), -np.ones(500)], -1)
    d = np.concatenate([random_directions(N, seed), pole, seam])
    return reference.unit(d).astype(np.float32).astype(np.float64)


@pytest.fixture(autouse=True)
def _say_the_version(record_property):
    record_property("oracle", oracle.version())
    print(f"ran against {oracle.version()}")


def off_the_poles(d: np.ndarray, rows: int) -> np.ndarray:
    """Leave out the last half texel before a pole.

    There OpenImageIO repeats the first or last row, and we go on over the pole.
    """
    theta = np.arctan2(np.hypot(d[:, 0], d[:, 2]), np.abs(d[:, 1]))
    return d[theta > 0.5 * np.pi / rows * (1 + 1e-5)]


def compare(image: np.ndarray, seed: int, folder) -> float:
    # A .tif: its grid is texel centers. An .exr would be read with oiio:sampleborder.
    path = oracle.write(image, folder / "environment.tif")
    d = off_the_poles(directions(seed), image.shape[0])
    assert len(d) >= 10_000 and min(image.shape[:2]) > 64
    want = oracle.lookup(path, d)
    got = sm.sample(image, d, CONVENTION)
    return float(np.abs(got - want).max() / np.ptp(image))


def test_smooth_content(tmp_path):
    image = reference.smooth_function(sm.directions(CONVENTION, 128)).astype(np.float32)
    # 1e-5 of the range: float32 coordinates cost 6e-7 of it.
    assert compare(image, 220, tmp_path) < 1e-5


@pytest.mark.parametrize("name", ["venice.exr", "studio.exr", "park.exr", "night.exr"])
def test_real_content(data_folder, tmp_path, name):
    image = oracle.read(data_folder / name)[..., :3]
    # Known to 3e-5 texel, as on white noise; no lookup meets a step of a third of the range.
    assert compare(image, 221, tmp_path) < 1e-5


def test_white_noise(tmp_path):
    image = np.random.default_rng(222).random((256, 512, 3)).astype(np.float32)
    # The oracle's float32 coordinate: x = s·512 - ½ is known to 512·2^-24 = 3e-5 texel, after an
    # arctangent of 2 ulp; a texel differs from its neighbor by 1 at most.
    assert compare(image, 223, tmp_path) < 2e-4


@pytest.mark.parametrize("content", ["smooth", "noise"])
def test_sampleborder(tmp_path, content):
    # Every .exr that maketx writes has its texels on corners.
    convention = f"{CONVENTION}-sampleborder"
    if content == "smooth":
        image = reference.smooth_function(sm.directions(convention, 128)).astype(np.float32)
    else:
        image = np.random.default_rng(227).random((128, 256, 3)).astype(np.float32)
    path, stored = oracle.environment_file(image, tmp_path, "environment.exr")
    assert stored.shape == image.shape and stored.dtype == np.float32
    d = directions(228)
    want = oracle.lookup(path, d)
    got = sm.sample(stored, d, convention)
    # As on smooth content and on white noise, above.
    limit = 1e-5 * np.ptp(stored) if content == "smooth" else 2e-4
    assert np.abs(got - want).max() < limit


def test_z_up(tmp_path):
    p = sm.projection("latlong", axes="+y -z +x")
    image = reference.smooth_function(p.directions(100)).astype(np.float32)
    path = oracle.write(image, tmp_path / "z_up.tif")
    d = directions(224)[::4]
    d = off_the_poles(d[:, [0, 2, 1]], 100)[:, [0, 2, 1]]  # z is up
    want = oracle.lookup(path, d, z_up=True)
    # As on smooth content: float32 coordinates cost 6e-7 of the range.
    assert np.abs(sm.sample(image, d, p) - want).max() < 1e-5 * np.ptp(image)


def taps_inside(shape: tuple[int, int], d: np.ndarray, margin: float = 2.0) -> np.ndarray:
    """Lookups whose four taps lie inside the disk: OpenImageIO reads what lies outside it, too."""
    uv = sm.encode(d, "angular:openimageio")
    radius = np.linalg.norm(2 * uv - 1, axis=-1)
    return radius < 1 - 2 * margin / min(shape)


def test_light_probe_conversion_on_smooth_content(tmp_path):
    image = reference.smooth_function(sm.directions("angular:openimageio", 256))
    image = np.nan_to_num(image).astype(np.float32)
    path = oracle.write(image, tmp_path / "probe.tif")
    want = oracle.light_probe_to_latlong(path, tmp_path / "pano.tif")
    got = sm.convert(image, "angular:openimageio", CONVENTION, size=want.shape[:2], antialias=False)
    ok = taps_inside(image.shape[:2], sm.directions(CONVENTION, want.shape[:2]))
    assert ok.sum() >= 10_000
    # As on smooth content: float32 coordinates cost 6e-7 of the range.
    assert np.abs(got - want)[ok].max() < 1e-5 * np.ptp(image)


def test_light_probe_conversion_on_a_real_probe(data_folder, tmp_path):
    path = data_folder / "grace_probe.hdr"
    image = oracle.read(path)[..., :3]
    want = oracle.light_probe_to_latlong(path, tmp_path / "pano.tif")
    got = sm.convert(image, "angular:openimageio", CONVENTION, size=want.shape[:2], antialias=False)
    d = sm.directions(CONVENTION, want.shape[:2])
    ok = taps_inside(image.shape[:2], d)
    assert ok.sum() >= 10_000
    error = np.abs(got - want).max(-1)[ok] / np.ptp(image)
    # 1e-5 of the range wherever the image allows it. Where one texel is 600 above its neighbor
    # (the windows' edges), the oracle's own float32 coordinate shows: u is known to a few times
    # 2^-24, so x = 1000·u - ½ to 2e-4 texel.
    uv = sm.encode(d[ok], "angular:openimageio")
    x = np.clip((uv * image.shape[0] - 0.5).astype(int), 0, image.shape[0] - 2)
    i, j = x[:, 0], x[:, 1]
    taps = np.stack([image[j, i], image[j, i + 1], image[j + 1, i], image[j + 1, i + 1]])
    contrast = np.ptp(taps, axis=0).max(-1) / np.ptp(image)
    # 2e-4 texel of what four texels differ by; all but one lookup in ten thousand need none of it.
    assert np.all(error < 1e-5 + 2e-4 * contrast)
    assert np.mean(error < 1e-5) > 0.9999


def test_light_probe_of_openimageio_is_mirrored(data_folder, tmp_path):
    # The trap: against the right reading of a real probe, its panorama is left-right reversed.
    path = data_folder / "grace_probe.hdr"
    image = oracle.read(path)[..., :3]
    theirs = oracle.light_probe_to_latlong(path, tmp_path / "pano.tif")
    ours = sm.convert(image, "angular:debevec", CONVENTION, size=theirs.shape[:2], antialias=False)
    a, b, c = (
        np.log1p(x[60:440, 60:-60].mean(-1)).ravel() for x in (ours, theirs, theirs[:, ::-1])
    )
    assert np.corrcoef(a, b)[0, 1] < 0.5
    # Mirrored, theirs looks along the other half of z: half a turn apart.
    best = max(
        np.corrcoef(
            np.log1p(ours.mean(-1)).ravel(),
            np.log1p(np.roll(theirs[:, ::-1], shift, axis=1).mean(-1)).ravel(),
        )[0, 1]
        for shift in (0, theirs.shape[1] // 2)
    )
    assert best > 0.99
    assert len(c)


def test_the_oracle_would_notice_a_wrong_convention(tmp_path):
    image = reference.smooth_function(sm.directions(CONVENTION, 128)).astype(np.float32)
    path = oracle.write(image, tmp_path / "environment.tif")
    d = directions(226)[::10]
    want = oracle.lookup(path, d)
    for wrong in ("latlong:mitsuba", "latlong"):
        # Far above the 2e-5, 1e-5 of the range, that the right one is held to.
        assert np.abs(sm.sample(image, d, wrong) - want).max() > 1e-3
