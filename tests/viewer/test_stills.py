"""What is drawn over stills is where the page has it."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import spheremap as sm
from spheremap.viewer import colors

SIZE = (180, 320)


def gray(name: str = "latlong") -> np.ndarray:
    p = sm.projection(name)
    return np.full(p.shape(32), 0.2140411, np.float32)  # 128 in sRGB


def camera(fov: float) -> sm.Projection:
    return sm.projection("perspective", fov=fov, aspect=SIZE[1] / SIZE[0])


def pixel(directions: object, fov: float) -> tuple[int, int]:
    column, row = sm.directions_to_pixels(directions, camera(fov), SIZE)
    return int(row), int(column)


def test_lights_and_lines_stand_where_they_are() -> None:
    pytest.importorskip("matplotlib", reason="figures need: pip install spheremap[plot]")
    light = sm.light.Light(np.array([0.3, 0.2, -1.0]), np.array([1.0, 0, 0]), 1.0)
    v = sm.view(gray(), "latlong", fov=80, curve="none").lights(light)
    v.outline([[-0.3, -0.1, -1], [0.4, -0.1, -1]], closed=False)
    still = v.snapshot(SIZE).astype(int)
    assert still[pixel(light.direction, 80)].tolist() == [255, 0, 0]
    row, column = pixel([0.1, -0.1, -1], 80)
    around = still[row - 1 : row + 2, column]
    # The color of the page's lines, on one of three pixels, or shared by two.
    assert np.abs(around - [64, 216, 255]).sum(axis=-1).min() < 90
    # Elsewhere nothing is drawn; a sky of sRGB, rounded.
    assert (np.abs(still[:40] - 128) <= 1).all()


@pytest.mark.parametrize("fov", [60.0, 250.0])
def test_a_graticule_is_on_its_meridians(fov: float) -> None:
    pytest.importorskip("matplotlib", reason="figures need: pip install spheremap[plot]")
    plain = sm.view(gray(), "latlong", fov=fov, curve="none", direction=[0, 0.3, -1])
    drawn = sm.view(gray(), "latlong", fov=fov, curve="none", direction=[0, 0.3, -1], graticule=10)
    still = drawn.snapshot(SIZE).astype(int)
    changed = (still != plain.snapshot(SIZE)).any(axis=-1)
    # Of pixels on the meridian ahead, which is the middle column, all; of all, some.
    middle = still[:, SIZE[1] // 2 - 1 : SIZE[1] // 2 + 1].max(axis=(1, 2))
    assert (middle > 150).mean() > 0.95 and 0.02 < changed.mean() < 0.6


def test_density_and_seams_are_those_of_the_map() -> None:
    black = np.zeros((6, 16, 16), np.float32)
    v = sm.view(black, "cube", fov=120, curve="none", density=True, seams=True)
    still = v.snapshot(SIZE).astype(int)
    p = sm.projection("cube")
    parts = np.log2(p.density(p.encode([0, 0, -1.0])) / (4 * np.pi / 6))
    wanted = 0.7 * 255 * colors.ramped(np.array(2 * parts))
    middle = still[SIZE[0] // 2, SIZE[1] // 2]
    # Half a pixel from the middle of a face, and rounded.
    assert np.abs(middle - wanted).max() <= 2
    row = still[SIZE[0] // 2]
    gold = np.flatnonzero((row == [255, 217, 26]).all(axis=-1))
    edge = SIZE[1] / 2 * (1 + np.array([-1, 1]) / np.tan(np.radians(60)))
    assert len(gold) == 4
    assert np.allclose([gold[:2].mean() + 0.5, gold[2:].mean() + 0.5], edge, atol=1.0)  # pixels


def test_stripes_mark_what_is_clipped_and_what_is_not_held() -> None:
    p = sm.projection("angular(fov=180)")
    light = np.where(np.arange(64)[:, None] < 32, 20.0, -1.0) * np.ones((64, 64))
    v = sm.view(light, p, curve="none", screen="latlong", clipping=True, valid=True)
    still = v.snapshot((180, 360))
    for at, color in (
        ((60, 170), (230, 0, 0)),
        ((120, 170), (0, 51, 230)),
        ((90, 20), (140, 26, 26)),
    ):
        around = still[at[0] - 6 : at[0] + 6, at[1] - 6 : at[1] + 6].reshape(-1, 3)
        share = (around == color).all(axis=-1).mean()
        # Every other stripe.
        assert share == pytest.approx(0.5, abs=0.02), color


def test_isolines_are_at_whole_stops() -> None:
    stops = np.linspace(-2.5, 1.5, 256, dtype=np.float32)
    light = np.broadcast_to(2.0 ** stops[:, None], (256, 512)).astype(np.float32)
    v = sm.view(light, "latlong", curve="none", screen="latlong", isolines=True)
    plain = sm.view(light, "latlong", curve="none", screen="latlong")
    darker = plain.snapshot((256, 512))[:, 100, 0] > v.snapshot((256, 512))[:, 100, 0]
    found = np.flatnonzero(darker & ~np.roll(darker, 1))
    # Rows where it is 1/4, 1/2, 1 and 2 of the whole; a line is 1.4 pixels wide.
    assert np.allclose(found, np.interp([-2, -1, 0, 1], stops, np.arange(256)), atol=2)


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.backends.backend_agg", None)
    assert sm.view(gray(), "latlong", density=True).snapshot((9, 16)).shape == (9, 16, 3)
    with pytest.raises(ImportError, match=r"pip install spheremap\[plot\]"):
        sm.view(gray(), "latlong", axes=True).snapshot((9, 16))
