"""Plots: what is drawn lies where the projection says."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import spheremap as sm

matplotlib = pytest.importorskip("matplotlib", reason="plots need matplotlib: spheremap[plot]")
matplotlib.use("Agg")

from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from spheremap import plot  # noqa: E402

NAMES = sm.projections()


@pytest.fixture
def ax():
    figure = Figure()
    FigureCanvasAgg(figure)
    return figure.subplots()


def texts(ax) -> dict[str, tuple[float, float]]:
    return {text.get_text(): text.get_position() for text in ax.texts}


def shown(ax) -> np.ndarray:
    (image,) = ax.get_images()
    return np.asarray(image.get_array())


@pytest.mark.parametrize("name", NAMES)
def test_every_projection_can_be_drawn(name: str, ax) -> None:
    p = sm.projection(name)
    image = np.ones((*p.shape(16), 3), np.float32)
    for draw in (
        lambda: plot.show(image, name, ax=ax),
        lambda: plot.tissot(name, ax=ax, size=64),
        lambda: plot.density_map(name, ax=ax, size=32),
    ):
        ax.clear()
        assert draw() is ax
        ax.figure.canvas.draw()


def test_labels_stand_where_the_directions_land(ax) -> None:
    plot.show(np.zeros((100, 200, 3), np.float32), "latlong", ax=ax)
    found = texts(ax)
    assert set(found) == {"+x", "-x", "+y", "-y", "+z", "-z"}
    assert found["-z"] == (100, 50)
    assert found["+x"] == (150, 50)
    assert found["-x"] == (50, 50)
    assert found["+y"][1] < 10 and found["-y"][1] > 90


@pytest.mark.parametrize("flag", ["labels", "mask", "colorbar"])
def test_flags_are_bools(flag: str, ax) -> None:
    with pytest.raises(TypeError, match=f"Expected `{flag}` to be a bool, got int"):
        plot.show(np.zeros((8, 16)), "latlong", ax=ax, **{flag: 1})
    if flag == "labels":
        with pytest.raises(TypeError, match="Expected `labels` to be a bool, got int"):
            plot.footprints("latlong", "cube", size=2, ax=ax, labels=1)


def test_directions_that_are_not_covered_get_no_label(ax) -> None:
    plot.show(np.zeros((64, 64, 3), np.float32), "matcap", ax=ax)
    assert "-z" not in texts(ax) and "+z" in texts(ax)


def test_labels_of_faces_stand_in_their_face(ax) -> None:
    plot.show(np.zeros((6, 10, 10, 3), np.float32), "cube", ax=ax)
    for face, label in enumerate(("+x", "-x", "+y", "-y", "+z", "-z")):
        # Places of axes round by some ε of 60 pixels; `approx`'s own 1e-6 is a millionth of them.
        assert texts(ax)[label] == pytest.approx((10 * face + 5, 5))
    assert ax.get_xlim() == (0, 60) and ax.get_ylim() == (10, 0)


def test_the_mask_covers_what_holds_no_sphere_and_nothing_else(ax) -> None:
    image = np.full((32, 32, 3), 7, np.uint8)
    plot.show(image, "sphere", ax=ax)
    held = np.isfinite(sm.directions("sphere", 32)[..., 0])
    picture = shown(ax)
    assert np.all(picture[held] == 7)
    assert np.all(picture[~held] == 217)
    ax.clear()
    plot.show(image, "sphere", ax=ax, mask=False, labels=False)
    assert np.all(shown(ax) == 7)
    assert not ax.texts
    assert np.all(image == 7)


def test_floats_are_tone_mapped_and_integers_shown_as_they_are(ax) -> None:
    light = np.full((8, 16, 3), 0.18, np.float32)
    plot.show(light, "latlong", ax=ax)
    assert np.all(shown(ax) == 109)
    ax.clear()
    plot.show(light / 4, "latlong", ax=ax, exposure=2)
    assert np.all(shown(ax) == 109)
    ax.clear()
    plot.show(np.full((8, 16), 257 * 30, np.uint16), "latlong", ax=ax)
    assert np.all(shown(ax) == 30)


def test_masked_light_is_black_and_masked_pictures_are_refused(ax) -> None:
    light = np.ma.masked_array(np.full((8, 16, 3), 0.18), np.zeros((8, 16, 3), bool))
    light[2, 3] = np.ma.masked
    plot.show(light, "latlong", ax=ax)
    assert np.all(shown(ax)[2, 3] == 0) and np.all(shown(ax)[2, 4] == 109)
    picture = np.ma.masked_array(np.ones((8, 16, 3), np.uint8), light.mask)
    with pytest.raises(TypeError, match="`image` has masked elements"):
        plot.show(picture, "latlong", ax=ax)


def test_faces_stand_in_a_row_in_their_order(ax) -> None:
    image = np.arange(6, dtype=np.uint8)[:, None, None, None] * np.ones((1, 4, 4, 3), np.uint8)
    plot.show(image, "cube", ax=ax)
    assert np.array_equal(shown(ax)[0, ::4, 0], np.arange(6))


def test_an_image_of_the_wrong_rank_says_so(ax) -> None:
    with pytest.raises(ValueError, match="dimensions for 'cube'"):
        plot.show(np.zeros((8, 8), np.float32), "cube", ax=ax)


def ellipse_areas(ax) -> np.ndarray:
    (collection,) = ax.collections
    outlines = np.stack([path.vertices[:64] for path in collection.get_paths()])
    x, y = outlines[..., 0], outlines[..., 1]
    return np.abs(np.sum(x * np.roll(y, -1, -1) - y * np.roll(x, -1, -1), axis=-1)) / 2


def test_indicatrices_of_an_equal_area_map_have_one_area(ax) -> None:
    plot.tissot("sphere", ax=ax, size=256, radius=4)
    areas = ellipse_areas(ax)
    assert len(areas) > 20
    # Density 16: a disk of the sphere becomes the sixteenth part of its area, in units of 256².
    expected = np.pi * np.radians(4) ** 2 / 16 * 256**2
    # Polygons of 64 corners: sin(x)/x of the circle with x = 2π/64, which is 1.6e-3 less.
    assert areas == pytest.approx(expected, rel=3e-3)
    # All are that polygon of one density: what differs is the Jacobian's rounding at the rim.
    assert np.ptp(areas) < 1e-6 * expected


def test_indicatrices_of_a_conformal_map_are_round(ax) -> None:
    plot.tissot("dual_paraboloid", ax=ax, size=128)
    (collection,) = ax.collections
    outlines = np.stack([path.vertices[:64] for path in collection.get_paths()])
    radius = np.linalg.norm(outlines - outlines.mean(axis=1, keepdims=True), axis=-1)
    # Radii of some pixels from Jacobians that round by some ε.
    assert np.ptp(radius, axis=-1) == pytest.approx(np.zeros(len(radius)), abs=1e-6)


@pytest.mark.parametrize("wrong", [{"radius": 0.0}, {"step": -1.0}, {"step": 400.0}])
def test_indicatrices_need_sizes_in_range(ax, wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"`radius` above 0 and `step` in \(0, 180\]"):
        plot.tissot("latlong", ax=ax, **wrong)


@pytest.mark.parametrize("name", ["latlong", "octahedral", "cube"])
def test_the_density_map_holds_the_density(name: str, ax) -> None:
    p = sm.projection(name)
    plot.density_map(name, ax=ax, size=16)
    drawn = shown(ax)
    texels = np.concatenate(list(drawn), axis=0) if drawn.ndim == 3 else drawn
    cell = 1 / np.prod(p.shape(16)[-2:])
    # The midpoint rule over all texels: the whole sphere.
    assert texels.sum() * cell == pytest.approx(p.covered_solid_angle, rel=1e-2)


def test_the_density_map_masks_what_holds_no_sphere(ax) -> None:
    plot.density_map("angular", ax=ax, size=32)
    (image, *_) = ax.get_images()
    held = np.isfinite(sm.directions("angular", 32)[..., 0])
    assert np.array_equal(~np.ma.getmaskarray(image.get_array()), held)


def test_new_axes_are_made_where_none_are_given() -> None:
    import matplotlib.pyplot as plt

    ax = plot.show(np.zeros((8, 16, 3), np.float32), "latlong")
    assert len(ax.get_images()) == 1
    plt.close(ax.figure)


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match=r"pip install spheremap\[plot\]"):
        plot.show(np.zeros((8, 16, 3), np.float32), "latlong")


def bars(ax) -> list:
    return [other for other in ax.figure.axes if other is not ax]


def test_one_channel_of_floats_is_a_quantity_and_is_not_tone_mapped(ax) -> None:
    values = np.linspace(2, 9, 8 * 16).reshape(8, 16)
    plot.show(values, "latlong", ax=ax, exposure=5)
    (image,) = ax.get_images()
    assert np.array_equal(image.get_array(), values)
    assert image.get_clim() == (2, 9) and image.get_cmap().name == "viridis"
    assert len(bars(ax)) == 1
    ax.clear()
    plot.show(values[..., None] - 4, "latlong", ax=ax, colorbar=False)
    (image,) = ax.get_images()
    # White is 0: the limits are the larger of both either way.
    assert image.get_clim() == (-5, 5) and image.get_cmap().name == "RdBu_r"
    assert len(bars(ax)) == 1


def test_limits_and_color_maps_are_what_is_asked_for(ax) -> None:
    values = np.arange(8 * 16, dtype=np.int32).reshape(8, 16)
    plot.show(values, "latlong", ax=ax, cmap="magma", vmin=10, vmax=20)
    (image,) = ax.get_images()
    assert image.get_clim() == (10, 20) and image.get_cmap().name == "magma"
    # A gray picture, but that it is asked for as a quantity.
    ax.clear()
    plot.show(values.astype(np.uint8), "latlong", ax=ax, vmin=-3)
    (image,) = ax.get_images()
    assert image.get_clim() == (-3, 127) and image.get_cmap().name == "RdBu_r"
    with pytest.raises(ValueError, match="`vmin` must be less than `vmax`, got 5 and 5"):
        plot.show(values, "latlong", ax=ax, vmin=5, vmax=5)
    with pytest.raises(ValueError, match="no color map 'rainbows'"):
        plot.show(values, "latlong", ax=ax, cmap="rainbows")
    with pytest.raises(TypeError, match="real numbers, got dtype complex128"):
        plot.show(values * 1j, "latlong", ax=ax)


def test_what_is_missing_is_gray_and_what_is_outside_lighter(ax) -> None:
    values = np.ma.masked_array(np.ones((32, 32)), np.zeros((32, 32), bool))
    values[16, 10], values[16, 12] = np.ma.masked, np.nan
    plot.show(values, "sphere", ax=ax)
    image, cover = ax.get_images()
    held = np.isfinite(sm.directions("sphere", 32)[..., 0])
    assert np.array_equal(np.asarray(cover.get_array())[..., 3] == 1, ~held)
    shown = np.ma.getmaskarray(image.get_array()) & held
    assert np.argwhere(shown).tolist() == [[16, 10], [16, 12]]
    assert image.get_cmap().get_bad()[:3].tolist() == [0.55] * 3


@pytest.mark.parametrize("name", NAMES)
def test_every_projection_has_a_graticule(name: str, ax) -> None:
    shape = sm.projection(name).shape(32)
    plot.show(np.ones(shape), name, ax=ax, graticule=30, labels=False)
    (lines,) = [c for c in ax.collections if type(c).__name__ == "LineCollection"]
    width, height = ax.get_xlim()[1], ax.get_ylim()[0]
    for piece in lines.get_segments():
        # Places of axes round by some ε of the width.
        assert np.all((piece >= -1e-6) & (piece <= np.array([width, height]) + 1e-6))
        # Nothing jumps from one edge to the other.
        jumps = np.abs(np.diff(piece, axis=0)) / [width, height]
        assert jumps.max() <= 0.05


def test_longitude_grows_to_the_right_and_on_the_sky_to_the_left(ax) -> None:
    plot.show(np.zeros((90, 180)), "latlong", ax=ax, graticule=30, labels=False)
    places = {text.get_text(): text.xy for text in ax.texts}
    # Places of the image: texels of two degrees.
    assert places["60°"] == pytest.approx((120, 45)) and places["120°"] == pytest.approx((150, 45))
    ax.clear()
    plot.show(np.zeros((90, 180)), "mollweide:healpy", ax=ax, graticule=90, labels=False)
    places = {text.get_text(): text.xy for text in ax.texts}
    # Places of axes, again.
    assert places["90°"] == pytest.approx((45, 45))
    assert places["270°"] == pytest.approx((135, 45))
    with pytest.raises(ValueError, match=r"`graticule` must be in \(0, 90\], got 0"):
        plot.show(np.zeros((90, 180)), "latlong", ax=ax, graticule=0)
