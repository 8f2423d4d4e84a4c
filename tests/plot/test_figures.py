"""Figures of what the library tells: conventions, chains, harmonics, lights, codes, footprints."""

from __future__ import annotations

import re

import numpy as np
import pytest
import spheremap as sm

matplotlib = pytest.importorskip("matplotlib", reason="plots need matplotlib: spheremap[plot]")
matplotlib.use("Agg")

from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from spheremap import plot  # noqa: E402

SKY = np.maximum(sm.directions("latlong", 32), 0).astype(np.float32)


@pytest.fixture
def figure():
    made = Figure(layout="constrained")
    FigureCanvasAgg(made)
    return made


@pytest.fixture
def ax(figure):
    return figure.subplots()


@pytest.mark.parametrize("world", ["match", "literal"])
def test_lines_join_one_direction_in_two_conventions(world, figure) -> None:
    first, second = plot.compare("latlong:blender", "cube:unity", world=world, figure=figure)
    figure.canvas.draw()
    lines = [each for each in figure.artists if type(each).__name__ == "ConnectionPatch"]
    assert len(lines) == 6
    width, height = first.get_xlim()[1], first.get_ylim()[0]
    columns, rows = second.get_xlim()[1], second.get_ylim()[0]
    a = sm.projection("latlong:blender")
    b = sm.projection("cube:unity")
    b = b.in_world_of(a) if world == "match" else b
    for line in lines:
        d = a.decode(np.array(line.xy1) / [width, height])
        face, u = np.divmod(line.xy2[0] / columns * 6, 1)
        there = b.decode([u, line.xy2[1] / rows, face])
        # Places of a figure, of a few hundred pixels, in doubles.
        assert np.allclose(d, there, rtol=0, atol=1e-9)
    words = figure.get_supxlabel()
    assert words == str(sm.align.compare("latlong:blender", "cube:unity"))


def test_a_pair_shows_the_picture_that_convert_makes(figure) -> None:
    cube = np.arange(6, dtype=np.uint8)[:, None, None, None] * np.full((1, 8, 8, 3), 40, np.uint8)
    first, second = plot.compare("cube", "cube:ffmpeg-c3x2", image=cube, figure=figure)
    assert first.get_title() == "cube:opengl" or first.get_title() == "cube"
    wanted = sm.convert(cube, "cube", "cube:ffmpeg-c3x2")
    assert np.array_equal(second.get_images()[0].get_array(), wanted)


def test_a_chain_has_one_scale(figure) -> None:
    levels = sm.mipmaps(SKY[..., 1] - 0.3, "latlong")
    axes = plot.chain(levels, "latlong", figure=figure)
    assert len(axes) == len(levels)
    limits = {ax.get_images()[0].get_clim() for ax in axes}
    assert limits == {(-levels[0].max(), levels[0].max())}
    assert [ax.get_images()[0].get_array().shape for ax in axes] == [x.shape for x in levels]
    figure.canvas.draw()
    with pytest.raises(ValueError, match="6 titles, one an image, got 1"):
        plot.chain(levels, "latlong", titles=["a"])
    with pytest.raises(ValueError, match="at least one image"):
        plot.chain([], "latlong")


def test_a_chain_of_light_has_one_exposure(figure) -> None:
    axes = plot.chain([SKY, SKY[::2, ::2]], "latlong", exposure=2, titles=["a", "b"], figure=figure)
    wanted = sm.io.tonemap(SKY, exposure=2)
    assert np.array_equal(axes[0].get_images()[0].get_array(), wanted)
    assert np.array_equal(axes[1].get_images()[0].get_array(), wanted[::2, ::2])


def test_glyphs_reach_as_far_as_the_function(ax) -> None:
    plot.sh([0, 0, 0, 2.0, 0, 0, 0, 0, -1.0], ax=ax)
    (collection,) = ax.collections
    points = np.concatenate([path.vertices for path in collection.get_paths()])
    # The glyph of degree 1, order 1 stands at (1, -1.2): its lobe reaches 0.42 of a cell.
    near = points[np.hypot(points[:, 0] - 1, points[:, 1] + 1.2) < 0.5] - [1, -1.2]
    turned = sm.rotation(0, 20) @ sm.rotation(30, 0) @ [1, 0, 0]
    for tip in (0.42 * turned[:2], -0.42 * turned[:2]):
        # Its peaks lie on vertices of the net; doubles.
        assert np.linalg.norm(near - tip, axis=-1).min() < 1e-9
    # The same.
    assert np.linalg.norm(near, axis=-1).max() < 0.42 + 1e-9
    assert len(ax.texts) == 10


@pytest.mark.parametrize(
    "coefficients, order, says",
    [
        (np.ones(5), None, r"\(\(order \+ 1\)², 3\), got \(5,\)"),
        (np.ones((4, 2)), None, r"got \(4, 2\)"),
        ([np.nan], None, "finite"),
        (np.ones(4), 2, "`order` from 0 to 1, got 2"),
    ],
)
def test_what_are_no_coefficients(coefficients, order, says, ax) -> None:
    with pytest.raises(ValueError, match=says):
        plot.sh(coefficients, order=order, ax=ax)


def test_zero_is_a_figure_too(ax) -> None:
    assert plot.sh(np.zeros(4), ax=ax) is ax
    ax.figure.canvas.draw()


def test_lights_stand_where_they_are(ax) -> None:
    found = sm.light.lights(SKY, "latlong", count=5)
    plot.lights(SKY, "latlong", lights=found, ax=ax)
    places = sm.projection("latlong").directions_to_pixels(found.directions, (32, 64))
    drawn = np.array([line.get_xydata()[0] for line in ax.lines])
    # Pixels of 64, in doubles.
    assert np.allclose(drawn, places, rtol=0, atol=1e-9)
    sizes = [line.get_markersize() for line in ax.lines]
    assert sizes[0] == 18 and sizes == sorted(sizes, reverse=True)
    with pytest.raises(TypeError, match="of Light or Sun, got str"):
        plot.lights(SKY, "latlong", lights=["sun"], ax=ax)


def test_the_sun_is_a_ring(ax) -> None:
    sky = np.full((32, 64), 0.2)
    sky[8, 20] = 500
    plot.lights(sky, "latlong", count=3, ax=ax)
    *dots, ring = ax.lines
    assert len(dots) == 3 and ring.get_markerfacecolor() == "none"
    # The middle of its texel.
    assert np.allclose(ring.get_xydata(), [[20.5, 8.5]], rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", ["oct16", "hemioct16", "fibonacci16", "sphere16"])
def test_the_error_of_a_packing_is_below_its_bound(name, ax) -> None:
    about = sm.packing.packing(name)
    plot.packing_error(name, "octahedral", size=64, ax=ax)
    values = ax.get_images()[0].get_array()
    d = sm.directions("octahedral", 64)
    assert np.array_equal(np.ma.getmaskarray(values), about.hemisphere & (d[..., 2] < 0))
    # float32, of which a scheme may compute, adds 5e-7 radians.
    assert np.radians(values.max()) <= about.bound + 5e-7
    title = ax.get_title()
    assert ("without a bound" in title) == np.isinf(about.bound)
    (largest,) = re.findall(r"largest ([\d.e-]+)°", title)
    # Three digits.
    assert float(largest) == pytest.approx(values.max(), rel=5e-3)


@pytest.mark.parametrize("src", ["latlong", "cube", "octahedral", "mollweide", "healpix"])
@pytest.mark.parametrize("dst", ["cube", "latlong", "perspective", "angular"])
def test_footprints_are_the_borders_of_texels(src, dst, ax) -> None:
    plot.footprints(src, dst, size=4, ax=ax, labels=False)
    p, q = sm.projection(src), sm.projection(dst)
    shape = q.shape(4)
    width, height = ax.get_xlim()[1], ax.get_ylim()[0]
    lines = [c for c in ax.collections if type(c).__name__ == "LineCollection"]
    assert len(lines) == q.faces
    for face, collection in enumerate(lines):
        for piece in collection.get_segments():
            at = piece[len(piece) // 2] / [width, height]
            column, u = np.divmod(at[0] * p.faces, 1)
            uv = q.encode(p.decode([u, at[1], column][: 3 if p.faces > 1 else 2]))
            if q.faces > 1 and uv[2] != face:
                # On the edge of a face that is another's.
                continue
            texels = uv[:2] * shape[:-3:-1]
            # A place on a border is at a whole number, to the rounding of singular maps.
            assert np.abs(texels - np.rint(texels)).min() < 1e-5
    ax.figure.canvas.draw()


def test_footprints_lie_on_an_image(ax) -> None:
    plot.footprints("latlong", "perspective", image=SKY, rotation=sm.rotation(40), ax=ax)
    assert len(ax.get_images()) == 1 and ax.get_xlim() == (0, 64)
    dots = next(c for c in ax.collections if type(c).__name__ == "PathCollection").get_offsets()
    # To the left by 40 degrees of the middle, 64 texels around.
    assert dots[:, 0].mean() == pytest.approx(32 + 64 * 40 / 360, abs=0.5)


def test_degrees_stand_beside_the_names_of_axes(ax) -> None:
    plot.show(np.zeros((90, 180)), "latlong", ax=ax, graticule=30)
    offsets = {text.get_text(): text.xyann for text in ax.texts if "°" in text.get_text()}
    assert offsets["60°"] == (3, 3) and offsets["90°"] == (12, 4) == offsets["0°"]


@pytest.mark.parametrize(
    ("draw", "name"),
    [
        (lambda: plot.show(np.ones((8, 8, 3)), "latlong"), "image"),
        (lambda: plot.show(np.ones((8, 8)), "latlong", mask=False), "image"),
        (lambda: plot.lights(np.ones((8, 8, 3)), "latlong"), "image"),
        (lambda: plot.chain([np.ones((8, 8))], "latlong"), "image"),
        (lambda: plot.compare("latlong", "cube", image=np.ones((8, 8, 3))), "image"),
        (lambda: plot.compare("latlong", "cube", size=(8, 8)), "size"),
        (lambda: plot.footprints("cube", "latlong", size=(8, 8)), "size"),
        (lambda: plot.tissot("latlong", size=(8, 8)), "size"),
        (lambda: plot.density_map("latlong", size=(8, 8)), "size"),
        (lambda: plot.packing_error("oct16", "latlong", size=(8, 8)), "size"),
    ],
)
def test_another_aspect_is_told_without_a_way_that_no_figure_has(draw, name) -> None:
    with pytest.raises(ValueError, match=rf"^Expected `{name}` of .* twice as wide") as caught:
        draw()
    assert "any_aspect" not in str(caught.value) and str(caught.value).endswith(").")


def test_channels_first_are_told() -> None:
    for image, projection in ((np.ones((3, 32, 64)), "latlong"), (np.ones((6, 3, 8, 8)), "cube")):
        with pytest.raises(ValueError, match="looks like channels first"):
            plot.show(image, projection)


def test_words_stand_below_the_pictures_in_a_figure_without_a_layout() -> None:
    bare = Figure(figsize=(12, 5))
    FigureCanvasAgg(bare)
    axes = plot.compare("latlong:blender", "cube:opengl", size=32, figure=bare)
    bare.canvas.draw()
    (words,) = [text for text in bare.texts if text.get_text().startswith("latlong:blender ->")]
    assert words.get_window_extent().y1 <= min(ax.get_window_extent().y0 for ax in axes)


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: plot.show(SKY, "latlong", ax=3), TypeError, "`ax`"),
        (lambda: plot.compare("latlong", "cube", figure="x"), TypeError, "`figure`"),
        (lambda: plot.chain([SKY, SKY], "latlong", titles="ab"), TypeError, "`titles`"),
        (lambda: plot.show(SKY, "latlong", cmap="x"), ValueError, "no color map 'x'"),
        (lambda: plot.show(SKY, "latlong", cmap=3), TypeError, "`cmap`"),
        (lambda: plot.show(SKY, "latlong", vmin="a"), TypeError, "`vmin`"),
        (lambda: plot.show(SKY, "latlong", vmin=np.nan), ValueError, "`vmin`"),
        (lambda: plot.show(SKY, "latlong", vmin=2, vmax=1), ValueError, "`vmin` must be less"),
    ],
)
def test_what_cannot_be_drawn(call, kind, words) -> None:
    with pytest.raises(kind, match=words):
        call()
