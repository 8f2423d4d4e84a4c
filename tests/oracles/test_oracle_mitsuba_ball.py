"""Photos of a mirrored ball that mitsuba renders, unwrapped and merged."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from spheremap import io
from spheremap.ball.camera import View, view
from spheremap.ball.metals import METALS

from oracles import mitsuba_ball_oracle as oracle
from oracles import openimageio_oracle

ROWS = 40
PIXELS = 256
SKY = "latlong:mitsuba"


@pytest.fixture(scope="module")
def skies(data_folder):
    found = {
        name: np.maximum(openimageio_oracle.read(data_folder / f"{name}.exr")[..., :3], 0)
        for name in ("venice", "studio")
    }
    # Its lamps reach 3730: a thousandth of one, spread by a pixel, is white. Up to the white of the
    # tone curve, what is compared is places and not blur.
    found["studio to 4"] = np.minimum(found["studio"], 4)
    return found


def camera(fov: float, distance: float, center=(PIXELS / 2, PIXELS / 2)) -> View:
    return view((PIXELS, PIXELS), None, center=center, fov=fov, distance=distance)


def ball(v: View) -> sm.ball.Ball:
    return sm.ball.Ball(v.outline.center, (v.outline.along, v.outline.across), 0, 1)


@lru_cache
def _truth(raw: bytes, shape: tuple[int, ...]) -> np.ndarray:
    sky = np.frombuffer(raw, np.float32).reshape(shape)
    return sm.convert(sky, SKY, "latlong", size=ROWS, filter="area", world="literal")


def truth(sky: np.ndarray) -> np.ndarray:
    sky = np.ascontiguousarray(sky, np.float32)
    return _truth(sky.tobytes(), sky.shape)


def psnr(image: np.ndarray, wanted: np.ndarray, where: np.ndarray) -> float:
    """Peak signal to noise of the tone-mapped pictures, each texel by its solid angle."""
    a, b = (io.tonemap(np.nan_to_num(x)).astype(float) / 255 for x in (image, wanted))
    weight = sm.solid_angle("latlong", ROWS) * where
    error = (((a - b) ** 2).mean(axis=-1) * weight).sum() / weight.sum()
    return float(-10 * np.log10(error))


CASES = {
    "far": ("venice", camera(10, 13.5), (0, 0, 0)),
    "near": ("venice", camera(45, 3), (200, -10, 20)),
    "off axis": ("venice", camera(60, 3.2, (100, 132)), (60, 0, 0)),
    "studio": ("studio to 4", camera(20, 6.8), (30, 20, 0)),
}


@some_fast("case", CASES, ids=str, fast=("near", "off axis"))
def test_unwrapped(skies, case):
    name, v, turn = CASES[case]
    pose = sm.rotation(*turn)
    shot = oracle.photo(skies[name], v, pose)
    found = sm.ball.unwrap(
        shot, center=v.outline.center, radius=v.outline.mean, fov=v.fov, size=ROWS, pose=pose
    )
    # Angles are found by bisection down to rounding; 1/sin β is 14 at most: 1e-14.
    assert found.distance == pytest.approx(v.distance, rel=1e-9)
    texel = np.sqrt(sm.solid_angle("latlong", ROWS))
    # As finely as the target in its worst direction, not only in the mean of both.
    fine = found.spacing <= texel
    wanted = truth(skies[name])
    exact = psnr(found.image, wanted, fine)
    ideal = sm.ball.unwrap(
        shot, center=v.outline.center, radius=v.outline.mean, size=ROWS, pose=pose, distance=np.inf
    )
    wrong = psnr(ideal.image, wanted, fine)
    print(
        f"{case}: exact {exact:.1f} dB, ideal {wrong:.1f} dB over {fine.mean():.0%} of the texels"
    )
    assert fine.mean() > 0.5
    assert exact >= 40
    # At 13.5 radii the ideal formula is off by asin(1/13.5) = 4.2° at the rim; nearer by more.
    assert wrong < exact - 8


@some_fast(("filter", "least"), [("bilinear", 35.5), ("lanczos3", 40.0)], fast=[("lanczos3", 40.0)])
def test_small_lamps(skies, filter, least):
    """Lamps up to 3730, in a photo of 256 pixels: each spreads by what the filter adds."""
    v, pose = camera(20, 6.8), sm.rotation(30, 20, 0)
    shot = oracle.photo(skies["studio"], v, pose)
    found = sm.ball.unwrap(
        shot, center=v.outline.center, radius=v.outline.mean, fov=v.fov, size=ROWS, pose=pose,
        filter=filter,
    )  # fmt: skip
    fine = found.spacing <= np.sqrt(sm.solid_angle("latlong", ROWS))
    decibels = psnr(found.image, truth(skies["studio"]), fine)
    print(f"{filter}: {decibels:.1f} dB")
    assert decibels >= least


@pytest.mark.parametrize(("fov", "distance"), [(60.0, 2.5), (30.0, 6.0)])
def test_blind_cone(fov, distance):
    """What mitsuba reflects at the very rim is where the stated cone begins."""
    v = camera(fov, distance)
    # Brightness is the cosine from the direction behind the ball.
    sky = (1 - sm.directions(SKY, (128, 256))[..., 2:]).repeat(3, axis=-1) / 2
    scale = 1024  # pixels of a hundred thousandth of the radius
    rim = (v.outline.center[0] + v.outline.along) * scale
    first, middle = round(rim) - 400, PIXELS // 2 * scale
    strip = oracle.photo(
        sky, v, np.eye(3), scale=scale, crop=(first, middle, 396, 2), background=False
    )
    seen = np.degrees(np.arccos(2 * strip.mean(axis=(0, 2)) - 1))
    # Inside the rim the angle grows with the root of the distance from it.
    inside = rim - (first + np.arange(396) + 0.5)
    _, angle = np.polyfit(np.sqrt(inside), seen, 1)
    stated = sm.ball.unwrap(
        np.ones((PIXELS, PIXELS)), center=v.outline.center, radius=v.outline.mean, fov=fov, size=8
    ).blind_cone
    print(f"stated {stated:.3f}°, rendered {angle:.3f}°")
    # The sky's bilinear cosine is off by (π/128)²/8, or 0.03° of 19°; a line leaves as much again.
    assert angle == pytest.approx(stated, rel=0.01)


@some_fast("turn", [(90, 0, 0), (180, 0, 0)], ids=["90°", "180°"], fast=[(90, 0, 0)])
def test_two_shots(skies, turn):
    v, pose = camera(15, 9), sm.rotation(*turn)
    a, b = (oracle.photo(skies["venice"], v, p) for p in (np.eye(3), pose))
    found = sm.ball.merge([a, b * [0.5, 0.6, 0.7]], balls=[ball(v)] * 2, fov=v.fov, size=ROWS)
    turned = found.poses[1] @ pose.T
    error = np.degrees(np.arccos(np.clip((np.trace(turned) - 1) / 2, -1, 1)))
    wanted = truth(skies["venice"])
    whole = np.ones(wanted.shape[:2], np.bool_)
    one = dict(center=v.outline.center, radius=v.outline.mean, fov=v.fov, size=ROWS, fill=0)
    alone = [
        psnr(sm.ball.unwrap(shot, pose=p, **one).image, wanted, whole)
        for shot, p in ((a, np.eye(3)), (b, pose))
    ]
    both = psnr(found.image, wanted, whole)
    print(f"{turn}: {error:.4f}° off; {both:.1f} dB, alone {alone[0]:.1f} and {alone[1]:.1f}")
    assert error < 0.1
    assert found.correlations[1] > 0.95
    assert found.coverage == 1.0
    assert both > max(alone) + 3
    # Both shots show what they share from other sides, as sharp as each has it there: percents.
    np.testing.assert_allclose(found.exposures[1], 1 / np.array([0.5, 0.6, 0.7]), rtol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["venice", "night"])
def test_two_shots_whose_rims_are_found(data_folder, name):
    sky = np.maximum(openimageio_oracle.read(data_folder / f"{name}.exr")[..., :3], 0)
    pose = sm.rotation(97, 8, -5)
    places = ((250, 262), (262, 248))
    shots = [
        oracle.photo(sky, view((512, 512), None, center=c, fov=20, distance=8.0), p, samples=16)
        for c, p in zip(places, (np.eye(3), pose), strict=True)
    ]
    found = sm.ball.merge(shots, fov=20, size=ROWS)
    turned = found.poses[1] @ pose.T
    error = np.degrees(np.arccos(np.clip((np.trace(turned) - 1) / 2, -1, 1)))
    print(f"{name}: {error:.4f}° off, residual {found.residual:.3f} stops")
    assert error < 0.1


def test_the_ball_is_found(skies):
    v = camera(30, 5.2, (105, 120))
    shot = oracle.photo(skies["venice"], v, sm.rotation(40, 0, 0))
    found = sm.ball.find(shot)
    off = np.hypot(*np.subtract(found.center, v.outline.center))
    print(f"center {off:.2f} and radius {found.radius - v.outline.mean:+.2f} pixels off")
    # Before an environment that is infinitely far away the rim is no step in brightness.
    # 2 % of the radius is what is stated of surroundings with detail.
    assert max(off, abs(found.radius - v.outline.mean)) < 0.02 * v.outline.mean
    # Below 0.7 a user is told to look.
    assert found.confidence > 0.7


# Where the ball is, how large the photo, how far the camera: (x, y, pixels, distance, fov).
PLACES = [
    (0.44, 0.52, 320, 9.0, 18.0),
    (0.5, 0.47, 512, 4.5, 40.0),
    (0.55, 0.5, 768, 3.2, 60.0),
    (0.47, 0.45, 1024, 12.0, 16.0),
]


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES, ids=str)
@pytest.mark.parametrize("name", ["venice", "studio", "night"])
def test_rims_of_all_kinds(data_folder, name, place):
    """Before the environment and before a plain wall as bright as the ball's middle tone."""
    x, y, pixels, distance, fov = place
    sky = np.maximum(openimageio_oracle.read(data_folder / f"{name}.exr")[..., :3], 0)
    v = view((pixels, pixels), None, center=(x * pixels, y * pixels), fov=fov, distance=distance)
    pose = sm.rotation(37 * len(name), 10, 5)
    shot = oracle.photo(sky, v, pose, samples=16)
    alpha = sm.ball.render(
        np.ones((8, 16)), size=pixels, center=v.outline.center, fov=fov, distance=distance,
        background="alpha",
    )[..., 1:]  # fmt: skip
    wall = shot * alpha + np.median(shot, axis=(0, 1)) * (1 - alpha)
    for background, photo in (("environment", shot), ("wall", wall)):
        found = sm.ball.find(photo)
        relative = v.outline.relative(found.points(720))
        worst = np.abs(np.hypot(*relative.T) - 1).max()
        said = f"{background}: {worst:.2%} of the radius off, {found.confidence:.2f} sure"
        print(f"{name} {place} {said}")
        # What `Ball.confidence` promises.
        assert worst < 0.025 or found.confidence < 0.7, said


def test_our_own_photo(skies):
    """ball.render is mitsuba's picture, but for mitsuba's noise."""
    v, pose = camera(50, 3.4, (90, 130)), sm.rotation(-70, 15, 5)
    theirs = oracle.photo(skies["venice"], v, pose)
    # Worlds are matched: what is ahead lies along mitsuba's +z, and along -z of ours.
    turned = np.diag([-1.0, 1.0, -1.0]) @ pose
    ours = sm.ball.render(
        skies["venice"],
        SKY,
        size=PIXELS,
        center=v.outline.center,
        fov=50,
        distance=3.4,
        pose=turned,
    )
    a, b = (io.tonemap(x).astype(float) / 255 for x in (ours, theirs))
    assert -10 * np.log10(np.mean((a - b) ** 2)) > 38


@pytest.mark.parametrize("metal", sorted(METALS))
def test_metals(metal):
    """The reflectance at all angles: Fresnel's equations with our indices, in mitsuba."""
    v = view((16, 16), None, center=(8, 8), fov=40, distance=3.2)
    white = np.ones((16, 32, 3))
    n, k = METALS[metal]
    indices = {
        "type": "conductor",
        "eta": {"type": "rgb", "value": list(n)},
        "k": {"type": "rgb", "value": list(k)},
    }
    theirs = oracle.photo(white, v, np.eye(3), bsdf=indices, samples=256)
    ours = sm.ball.render(white, size=16, fov=40, distance=3.2, metal=metal)
    # Pixels across the rim differ by mitsuba's noise; inside, reflectance is smooth.
    inside = np.hypot(*(np.mgrid[:16, :16] + 0.5 - 8)) < v.outline.mean - 1
    # Where reflectance varies by 0.03 in a pixel, the mean of 256 samples is good to 0.03/16.
    assert np.abs(theirs - ours)[inside].max() < 2e-3
