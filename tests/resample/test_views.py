"""Views into a panorama: cameras against other programs, and crops put back."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import reference
import spheremap as sm

TURN = sm.rotation(35, -20, 10)
CAMERA = sm.projection("perspective", fov=70, aspect=1.5)


def panorama(dtype=np.float32, size=128):
    image = reference.smooth_function(sm.directions("latlong", size))
    image = image * 40 + 60
    return image.astype(dtype)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
@pytest.mark.parametrize("into", ["latlong", "cube", "octahedral"])
def test_a_crop_put_back_changes_nothing(dtype, into):
    whole = sm.convert(panorama(np.float64), "latlong", into, size=64).astype(dtype)
    camera = CAMERA.turned(TURN)
    crop = sm.convert(whole, into, camera, size=128, antialias=False)
    back = sm.embed(crop, camera, whole, into, feather=3, antialias=False)
    assert back.dtype == dtype and back.shape == whole.shape
    away = np.abs(back.astype(np.float64) - whole.astype(np.float64))
    # Two interpolations: 2 · h²/8 · 40|f''|, h = π/64 and |f''| < 8; integers round twice.
    assert away.max() <= 2 * (np.pi / 64) ** 2 / 8 * 320 + (
        1 if np.dtype(dtype).kind == "u" else 0.1
    )


def test_only_what_the_view_covers_changes():
    whole = panorama()
    crop = np.full((60, 90, 3), 500, np.float32)
    got = sm.embed(crop, CAMERA, whole, "latlong", rotation=TURN)
    covered = sm.covers(sm.directions("latlong", 128), CAMERA, rotation=TURN)
    assert np.array_equal(np.any(got != whole, axis=-1), covered)
    assert np.all(got[covered] == 500)
    assert np.array_equal(whole, panorama())
    out = whole.copy()
    assert sm.embed(crop, CAMERA, out, "latlong", rotation=TURN, out=out) is out
    assert np.array_equal(out, got)


def test_feather_and_mask():
    black = np.zeros((128, 256), np.float32)
    crop = np.ones((80, 80), np.float32)
    camera = sm.projection("perspective", fov=90)
    hard = sm.embed(crop, camera, black, "latlong")
    soft = sm.embed(crop, camera, black, "latlong", feather=20)
    assert np.all(soft <= hard) and soft[64, 128] == 1
    row = soft[64, 96:128]  # from the left edge to the middle
    assert np.all(np.diff(row) >= -1e-6) and row[1] < 0.1
    mask = np.zeros((80, 80), bool)
    mask[:, 40:] = True
    half = sm.embed(crop, camera, black, "latlong", mask=mask)
    assert half[64, 120] == 0 and half[64, 136] == 1
    levels = (mask * 255).astype(np.uint8)
    assert np.array_equal(half, sm.embed(crop, camera, black, "latlong", mask=levels))
    disk = sm.embed(crop, sm.projection("equisolid", fov=120), black, "latlong", feather=10)
    assert 0 < disk[disk > 0].min() < 0.2 and disk.max() == 1


def test_nan_and_bright_texels_stay_where_they_are():
    whole = panorama()
    whole[0, 0] = np.nan
    crop = np.full((40, 60, 3), 1e30, np.float32)
    got = sm.embed(crop, CAMERA, whole, "latlong", rotation=TURN, feather=5)
    changed = np.any(got != whole, axis=-1)
    changed[0, 0] = False
    covered = sm.covers(sm.directions("latlong", 128), CAMERA, rotation=TURN)
    assert not np.any(changed & ~covered) and np.isnan(got[0, 0]).all()


def test_opacity_is_of_the_view_alone():
    whole = np.random.default_rng(3).random((64, 128, 4)).astype(np.float32)
    crop = np.ones((20, 30, 4), np.float32)
    # What is transparent is of another color, which does not bleed.
    crop[:, :12] = [0, 0, 0, 0]
    got = sm.embed(crop, CAMERA, whole, "latlong", alpha=-1)
    plain = sm.embed(crop, CAMERA, whole, "latlong")
    covered = sm.embed(np.ones_like(crop), CAMERA, whole, "latlong")[..., 3] > 0.999
    seen = covered & (plain[..., 3] > 0.01) & (plain[..., 3] < 0.99)
    assert seen.any() and np.array_equal(got[..., 3], plain[..., 3])
    # Ones, weighed and divided by their weights in float32.
    assert np.allclose(got[seen][:, :3], 1, atol=1e-6) and plain[seen][:, :3].min() < 0.9


@pytest.mark.parametrize("feather", [0, 3])
def test_what_has_no_weight_leaves_the_panorama(feather):
    whole, crop = panorama(), np.ones((40, 60, 3), np.float32)
    plain = sm.embed(crop, CAMERA, whole, "latlong", feather=feather)
    crop[10:30, 10:50, 0] = np.nan
    got = sm.embed(crop, CAMERA, whole, "latlong", feather=feather, skipna=True)
    kept = got[..., 0] == whole[..., 0]
    assert np.array_equal(got[..., 1:], plain[..., 1:]) and (kept & (plain[..., 0] == 1)).any()
    # Ones, weighed and divided by their weights in float32, beside numbers up to 100.
    assert np.allclose(got[~kept], plain[~kept], rtol=0, atol=1e-4)
    assert np.isnan(sm.embed(crop, CAMERA, whole, "latlong", feather=feather)).any()


def test_bad_views_are_refused():
    whole, crop = panorama(), np.zeros((20, 30, 3), np.float32)
    with pytest.raises(ValueError, match="channels"):
        sm.embed(crop[..., :2], CAMERA, whole, "latlong")
    with pytest.raises(TypeError, match="dtype"):
        sm.embed(crop.astype(np.uint8), CAMERA, whole, "latlong")
    with pytest.raises(ValueError, match="mask"):
        sm.embed(crop, CAMERA, whole, "latlong", mask=np.ones((3, 3)))
    with pytest.raises(ValueError, match="mask"):
        sm.embed(crop, CAMERA, whole, "latlong", mask=np.full((20, 30), 2.0))
    hidden = np.arange(600).reshape(20, 30) < 9
    with pytest.raises(TypeError, match="`mask` has masked elements"):
        sm.embed(crop, CAMERA, whole, "latlong", mask=np.ma.masked_array(hidden, hidden))
    with pytest.raises(ValueError, match="`mask` to have numbers from 0 to 1"):
        sm.embed(crop, CAMERA, whole, "latlong", mask=np.ma.masked_array(hidden * 1.0, hidden))
    with pytest.raises(ValueError, match="feather"):
        sm.embed(crop, CAMERA, whole, "latlong", feather=-1)
    for option in ("fill", "size", "window", "axes"):
        with pytest.raises(TypeError, match=f"`{option}` is no option of `embed`"):
            sm.embed(crop, CAMERA, whole, "latlong", **{option: 1})
    with pytest.raises(ValueError, match="out"):
        sm.embed(crop, CAMERA, whole, "latlong", out=np.zeros((4, 8, 3), np.float32))


def test_perspective_is_opencvs_pinhole():
    # OpenCV's camera looks along +z with y down: the view frame.
    p = sm.projection("perspective", fov=75, aspect=1.6, cx=0.1, cy=-0.05, axes="+x +y +z")
    width, height = 1600, 1000
    focal = width / 2 / np.tan(np.radians(75) / 2)
    k = np.array([[focal, 0, 0.6 * width], [0, focal, 0.45 * height], [0, 0, 1]])
    rng = np.random.default_rng(250)
    d = rng.normal(size=(500, 3)) * [0.3, 0.2, 0] + [0, 0, 1]
    theirs, _ = cv2.projectPoints(d, np.zeros(3), np.zeros(3), k, None)
    ours = p.encode(d) * [width, height]
    seen = p.covers(d)
    assert seen.sum() > 300
    # Pixels up to 1600 have units of 2e-13; OpenCV's products and ours err by some of them.
    assert np.abs(ours - theirs[:, 0])[seen].max() < 1e-9


def test_the_equidistant_fisheye_is_the_angular_map():
    p = sm.projection("angular", fov=190, axes="+x +y +z")
    width = 1000
    focal = width / np.radians(190)
    k = np.array([[focal, 0, 500], [0, focal, 500], [0, 0, 1.0]])
    rng = np.random.default_rng(251)
    d = rng.normal(size=(500, 3)) * [1, 1, 0] + [0, 0, 1]
    theirs, _ = cv2.fisheye.projectPoints(d[:, None], np.zeros(3), np.zeros(3), k, np.zeros(4))
    seen = p.covers(d)
    # Arctangents, square roots and pixels up to 1000, whose units are 1e-13; theirs and ours.
    assert np.abs(p.encode(d) * width - theirs[:, 0])[seen].max() < 1e-6


@pytest.mark.parametrize(
    ("name", "radius"),
    [
        ("equisolid", lambda t: 2 * np.sin(t / 2)),
        ("stereographic", lambda t: 2 * np.tan(t / 2)),
        ("orthographic", np.sin),
        ("angular", lambda t: t),
    ],
)
@pytest.mark.parametrize("fov", [20.0, 100.0, 180.0])
def test_fisheyes_as_lens_makers_state_them(name, radius, fov):
    p = sm.projection(name, fov=fov, axes="+x +y +z")
    theta = np.linspace(0, np.radians(fov) / 2 * 0.999, 50)
    d = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], -1)
    want = 0.5 + 0.5 * radius(theta) / radius(np.radians(fov) / 2)
    # Sine or tangent of at most 90°, and a quotient below 1: some ε.
    assert np.abs(p.encode(d)[:, 0] - want).max() < 1e-12


def test_special_cases_are_other_maps():
    d = np.random.default_rng(252).normal(size=(1000, 3))
    face = sm.projection("cube", axes="+x -y -z").encode(d)
    front = face[:, 2] == 4
    assert np.array_equal(sm.encode(d, "perspective")[front], face[front, :2])
    ball = sm.projection("sphere", axes="+x -y -z").encode(d)
    assert np.array_equal(sm.projection("equisolid", fov=360).encode(d), ball)
    lit = sm.projection("matcap", axes="+x -y -z").encode(d)
    assert np.array_equal(sm.encode(d, "orthographic"), lit, equal_nan=True)
    both = sm.projection("dual_paraboloid", axes="+x -y -z").encode(d)
    front = both[:, 2] == 0
    got = sm.encode(d, "stereographic")[front]
    # One formula, at the same place in either map: a unit or two of numbers below 1.
    assert np.abs(got - both[front, :2]).max() < 3e-16


@pytest.mark.parametrize("fov", [100.0, 220.0, 300.0, 358.0])
@pytest.mark.parametrize("n", [1, 2, 7, 32])
def test_solid_angles_of_wide_and_narrow_fisheyes(fov, n):
    p = sm.projection("stereographic", fov=fov)
    # Integrated along the azimuth: 1e-10 in bands that touch the rim.
    assert p.solid_angle(n).sum() == pytest.approx(p.covered_solid_angle, rel=1e-10)
    p = sm.projection("orthographic", fov=fov / 2 + 0.9)
    # Integrated along the azimuth: 1e-10 in bands that touch the rim.
    assert p.solid_angle(n).sum() == pytest.approx(p.covered_solid_angle, rel=1e-10)


@pytest.mark.parametrize("fov", [1e-3, 1.0, 120.0, 179.0])
@pytest.mark.parametrize("n", [1, 5, 64])
def test_solid_angles_of_pictures(fov, n):
    p = sm.projection("perspective", fov=fov, aspect=2, cx=0.3)
    # Closed forms, up to 8192 of them summed.
    assert p.solid_angle(n).sum() == pytest.approx(p.covered_solid_angle, rel=1e-12)
    p = sm.projection("cylindrical", fov=fov, aspect=0.5)
    # Closed forms, up to 2048 of them summed.
    assert p.solid_angle(n).sum() == pytest.approx(p.covered_solid_angle, rel=1e-12)


def test_sizes_follow_the_aspect():
    assert CAMERA.shape(100) == (100, 150)
    assert sm.projection("perspective", aspect=0.01).shape(3) == (3, 1)
    assert sm.projection("cylindrical", fov=120, aspect=16 / 9).shape(1080) == (1080, 1920)
