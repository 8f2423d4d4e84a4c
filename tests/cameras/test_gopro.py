"""Tracks of a GoPro MAX, made of a known scene, as one cube again."""

from __future__ import annotations

import numpy as np
import pytest
import reference.stitching as literal
import spheremap as sm

EAC = "cube_equiangular:ffmpeg-eac"
# A frame of 3K, a fourth as large.
HEIGHT, SIDE, OVERLAP = 184, 192, 8
WIDTH = 2 * SIDE + HEIGHT


def scene(d):
    """Colors without detail finer than an eighth of a turn, between 0.1 and 0.9."""
    waves = np.sin(np.asarray(d) @ np.array([[3, 1, 0], [0, 4, 2], [-2, 0, 4.0]]))
    return (0.5 + 0.4 * waves).astype(np.float32)


def tracks(lenses=(1.0, 1.0)):
    """Return what the camera stores of the scene, each lens as bright as it is."""
    columns = np.arange(SIDE) + 0.5
    # What is stored beyond the middle is there a second time, so far from where it was.
    once = np.where(columns < SIDE / 2, columns, columns - OVERLAP) / (SIDE - OVERLAP)
    middle = (np.arange(HEIGHT) + 0.5) / HEIGHT
    u = np.concatenate([once, 1 + middle, 2 + once]) / 3
    own = np.concatenate([columns > SIDE / 2, middle > 0, columns < SIDE / 2])
    found = []
    for row in (0, 1):
        v = (row + middle) / 2
        uv = np.stack(np.broadcast_arrays(u, v[:, None]), -1)
        gain = np.where(own, lenses[row], lenses[1 - row])[:, None]
        found.append((scene(sm.decode(uv, EAC)) * gain).astype(np.float32))
    return found


def test_a_known_scene_comes_back():
    eac = sm.cameras.gopro(*tracks(), overlap=OVERLAP)
    assert eac.shape == (2 * HEIGHT, 3 * HEIGHT, 3) and eac.dtype == np.float32
    want = scene(sm.projection(EAC).directions((2 * HEIGHT, 3 * HEIGHT)))
    # Between columns of half a degree: (h k)²/8 · 0.4 is 1e-4 with k up to 5.
    assert np.abs(eac - want).max() < 2e-4
    panorama = sm.convert(eac, EAC, "latlong", size=128)
    p = sm.projection("latlong").in_world_of(EAC)
    # Beside poles means of texels are not what their centers see.
    back = sm.convert(scene(p.directions(512)), p, p, size=128, filter="area")
    # Texels of 1.4 degrees, antialiased: (h k)²/8 · 0.4, and as much again.
    assert np.abs(panorama - back).max() < 2e-3


def test_columns_are_those_that_max2sphere_reads():
    rng = np.random.default_rng(530)
    pair = [rng.random((HEIGHT, WIDTH)) for _ in range(2)]
    eac = sm.cameras.gopro(*pair, overlap=OVERLAP)
    for face, start in ((0, 0), (2, SIDE + HEIGHT)):
        stored = pair[0][:, start : start + SIDE]
        for k in range(HEIGHT):
            left, right, alpha = literal.gopro_columns((k + 0.5) / HEIGHT, SIDE, OVERLAP // 2)
            want = np.zeros(HEIGHT)
            for x, part, share in (
                (left, stored[:, : SIDE // 2], 1 - alpha),
                (right - SIDE // 2, stored[:, SIDE // 2 :], alpha),
            ):
                if share > 0:
                    low = np.clip(np.floor(x - 0.5), 0, SIDE // 2 - 1)
                    high, part_of = min(low + 1, SIDE // 2 - 1), np.clip(x - 0.5 - low, 0, 1)
                    want += share * (
                        (1 - part_of) * part[:, int(low)] + part_of * part[:, int(high)]
                    )
            # A dozen roundings of numbers at most 1.
            assert np.abs(eac[:HEIGHT, face * HEIGHT + k] - want).max() < 1e-13
    middle = slice(HEIGHT, 2 * HEIGHT)
    assert np.array_equal(eac[:HEIGHT, middle], pair[0][:, SIDE : SIDE + HEIGHT])
    assert np.array_equal(eac[HEIGHT:, middle], pair[1][:, SIDE : SIDE + HEIGHT])


def test_exposures_are_matched():
    plain = sm.cameras.gopro(*tracks((1.0, 1.0)), overlap=OVERLAP)
    pair = tracks((0.8, 1.25))
    apart = sm.cameras.gopro(*pair, overlap=OVERLAP)
    matched = sm.cameras.gopro(*pair, overlap=OVERLAP, exposure="match")
    # The columns that are compared show the same directions, and 0.8 · 1.25 is 1.
    assert np.abs(matched - plain).max() < 1e-6
    assert np.abs(apart - plain).max() > 0.15
    # Codes are not light.
    codes = [np.rint(np.clip(255 * p / 2, 0, 255) ** 0.5 * 255**0.5).astype(np.uint8) for p in pair]
    steps = [
        np.abs(np.diff(sm.cameras.gopro(*codes, overlap=OVERLAP, **o).astype(int), axis=1)).max()
        for o in ({}, {"exposure": "match"})
    ]
    assert steps[1] < steps[0] < 100


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
@pytest.mark.parametrize("shape", [(HEIGHT, WIDTH), (HEIGHT, WIDTH, 3)])
def test_constants_stay_constant(dtype, shape):
    value = 201 if dtype.startswith("u") else 0.7
    pair = [np.full(shape, value, dtype)] * 2
    for exposure in (None, "match"):
        eac = sm.cameras.gopro(*pair, overlap=OVERLAP, exposure=exposure)
        assert eac.dtype == dtype and eac.shape == (2 * HEIGHT, 3 * HEIGHT, *shape[2:])
        # A few roundings of one number.
        assert np.abs(eac - pair[0].flat[0]).max() <= (0 if dtype.startswith("u") else 2e-7)


def test_frames_of_3k_are_known():
    eac = sm.cameras.gopro(*[np.full((736, 2272), 9, np.uint8)] * 2)
    assert eac.shape == (1472, 2208) and (eac == 9).all()


TRACK = np.zeros((HEIGHT, WIDTH), np.uint8)


@pytest.mark.parametrize(
    ("front", "rear", "options", "text"),
    [
        (TRACK, TRACK, {}, "Expected `overlap` for frames of 568 x 184"),
        (TRACK, TRACK, {"overlap": 7}, "even and in"),
        (TRACK, TRACK, {"overlap": 96}, "even and in"),
        (TRACK, TRACK[:, :-4], {"overlap": 8}, "one shape"),
        (TRACK, TRACK / 1.0, {"overlap": 8}, "one shape and dtype"),
        (TRACK[:, :400], TRACK[:, :400], {"overlap": 8}, "three times as wide"),
        (TRACK[0], TRACK[0], {"overlap": 8}, "three times as wide"),
        (TRACK, TRACK, {"overlap": 8, "exposure": "auto"}, "'match' or None"),
        (TRACK, TRACK, {"overlap": 8, "curve": "log"}, "'srgb' or 'linear'"),
    ],
)
def test_what_is_wrong_with_tracks_is_told(front, rear, options, text):
    with pytest.raises(ValueError, match=text):
        sm.cameras.gopro(front, rear, **options)
