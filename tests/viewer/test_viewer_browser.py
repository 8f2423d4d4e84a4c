"""The page in a real browser: it shows what `convert` gives, and picks the texels that it says.

`make test-browser`: playwright drives Chromium, which draws by WebGL 2 in software.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from browser import launched
from spheremap import io
from spheremap.viewer import answers, colors, still
from spheremap.viewer.page import page as page_of
from spheremap.viewer.page import source

pytestmark = pytest.mark.programs

# 8-bit pictures of the same light: the page looks up in half floats and float32, and both round.
# A tenth of a texel at the edge of something bright is worth more than all of that.
LEAST = 40.0
# Of light without such edges it is more: a shift by a third of a texel has 40 to 50 dB.
EXACT = 60.0
SIZE = {"width": 960, "height": 700}
# Whole and part, of one face and of several, of grids, layouts and left-handed worlds.
MAPS = (
    "latlong",
    "latlong:blender",
    "cube",
    "cube:unreal",
    "cube_equiangular",
    "octahedral",
    "equal_area",
    "angular",
    "healpix",
    "icosahedral",
    "tetrahedral",
    "dual_paraboloid",
    "lambert_cylindrical",
    "mercator",
    "perspective(fov=120)",
    "latlong(grid)",
)
DIRECTION = (0.4, 0.25, -0.6)


def peak_to_noise(a: np.ndarray, b: np.ndarray) -> float:
    error = np.mean((a.astype(np.float64) - b) ** 2)
    return float(10 * np.log10(255**2 / max(error, 1e-12)))


def scene(directions: np.ndarray) -> np.ndarray:
    """Return light from 1/16 to 60, without an edge sharper than a texel."""
    x, y, z = (np.nan_to_num(directions[..., k]) for k in range(3))
    sun = 50 * np.exp(30 * (0.6 * x + 0.36 * y - 0.714 * z - 1))
    waves = [1 + np.sin(9 * x + 2 * z), 1 + np.cos(11 * y - z), 1 + np.sin(8 * z + 3 * y)]
    return (np.stack(waves, axis=-1) * 0.5 + sun[..., None] + 0.0625).astype(np.float32)


def given(name: str) -> sm.Projection:
    return sm.projection("latlong", grid="corners") if "grid" in name else sm.projection(name)


def image(p: sm.Projection, size: int = 128) -> np.ndarray:
    return scene(p.in_world_of("latlong").directions(size))


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with launched() as browser:
        yield browser


@pytest.fixture
def opened(chromium: Any, tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Return what opens a page offline; nothing may be asked for, and nothing complained of."""
    said: list[str] = []
    contexts = []

    def open_page(viewer: Any, **options: Any) -> Any:
        path = tmp_path / "look.html"
        viewer.save(path)
        context = chromium.new_context(viewport=SIZE, offline=True, **options)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: _expect_own(request.url, said))
        page.goto(path.as_uri())
        page.wait_for_function("window.spheremap")
        page.evaluate("spheremap.ready.then(() => true)")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert said == []


def _expect_own(url: str, said: list[str]) -> None:
    if not url.startswith(("file:", "data:", "blob:")):
        said.append(f"asked for {url}")


def drawn(page: Any, tmp_path: Path, samples: int = 3) -> np.ndarray:
    """Return the canvas as it is now; one sample a pixel is what it has while it moves."""
    script = f"spheremap.draw({samples}), spheremap.canvas.toDataURL('image/png')"
    path = tmp_path / "canvas.png"
    path.write_bytes(base64.b64decode(page.evaluate(script).split(",")[1]))
    return io.read(path)[..., :3]


def size_of(page: Any) -> tuple[int, int]:
    height, width = page.evaluate("[spheremap.canvas.height, spheremap.canvas.width]")
    return height, width


@pytest.mark.parametrize("name", MAPS)
def test_a_perspective_is_what_convert_gives(
    name: str, opened: Callable[..., Any], tmp_path: Path
) -> None:
    p = given(name)
    direction = np.array(DIRECTION)
    viewer = sm.view(image(p), p, fov=75, exposure=-0.5)
    if sm.view(image(p), p).direction != (0.0, 0.0, -1.0):
        # In the world of that program.
        home = sm.projection("latlong")
        uv = home.encode(direction)
        direction = home.in_world_of(p).decode(uv)
    viewer.direction = direction
    page = opened(viewer)
    height, width = size_of(page)
    turn = sm.rotation(np.degrees(np.arctan2(-0.4, 0.6)), np.degrees(np.arctan2(0.25, 0.52**0.5)))
    camera = sm.projection("perspective", fov=75, aspect=width / height).turned(turn)
    wanted = sm.convert(image(p), p, camera, size=(height, width), fill=np.nan)
    held = np.isfinite(wanted).all(axis=-1)
    assert held.mean() > 0.3
    picture = io.tonemap(wanted, exposure=-0.5)
    ratio = peak_to_noise(drawn(page, tmp_path)[held], picture[held])
    print(f"{name}: {ratio:.1f} dB")
    assert ratio >= EXACT


@pytest.mark.parametrize(
    "look",
    [
        {"fov": 20.0, "direction": (0, 1, 0.01)},
        {"fov": 150.0},
        {"fov": 250.0, "direction": (0, -1, 0)},
        {"screen": "stereographic", "fov": 100.0},
        {"screen": "mollweide"},
        {"screen": "octahedral", "direction": (1, 0, 0)},
        {"screen": "latlong", "curve": "none"},
        {"false_color": True},
    ],
    ids=str,
)
def test_stills_are_what_is_seen(
    look: dict[str, Any], opened: Callable[..., Any], tmp_path: Path
) -> None:
    viewer = sm.view(image(sm.projection("cube")), "cube", **look)
    page = opened(viewer)
    seen, still = drawn(page, tmp_path), viewer.snapshot(size_of(page))
    top, left = ((a - b) // 2 for a, b in zip(seen.shape, still.shape[:2], strict=False))
    # A flat map has a rim, where half a pixel is a different thing.
    inside = (seen != 128).any(axis=-1)[top : top + still.shape[0], left : left + still.shape[1]]
    inside &= (still != 128).any(axis=-1)
    assert inside.mean() > 0.5
    part = seen[top : top + still.shape[0], left : left + still.shape[1]]
    ratio = peak_to_noise(part[inside], still[inside])
    print(f"{look}: {ratio:.1f} dB")
    assert ratio >= EXACT


@pytest.mark.parametrize("name", ["latlong", "cube", "angular", "healpix"])
@pytest.mark.parametrize("settings", [{}, {"false_color": True, "graticule": 15, "valid": True}])
def test_what_moves_is_what_rests(
    name: str, settings: dict[str, Any], opened: Callable[..., Any], tmp_path: Path
) -> None:
    p = sm.projection(name)
    page = opened(sm.view(image(p), p, fov=75, **settings))
    rests = drawn(page, tmp_path)
    moves = drawn(page, tmp_path, samples=1)
    assert moves.std() > 5
    # Weights of 8 bits, of a texture unit.
    assert peak_to_noise(moves, rests) >= LEAST


@pytest.mark.parametrize("name", ["latlong", "latlong(grid)", "cube:unity", "angular", "healpix"])
def test_picks_are_exact_to_the_texel(name: str, opened: Callable[..., Any]) -> None:
    p = given(name)
    light = image(p, 40)
    page = opened(sm.view(light, p, fov=100))
    height, width = size_of(page)
    solid = p.solid_angle(light.shape[: light.ndim - 1])
    count = 0
    for x, y in np.random.default_rng(0).integers(2, [width - 2, height - 2], (40, 2)).tolist():
        found = page.evaluate(f"spheremap.pick({x}.5, {y}.5)")
        if found["direction"] is None or "texel" not in found:
            continue
        uv = p.encode(found["direction"])
        if not np.allclose(uv[:2], found["uv"], atol=2e-6):
            # Where a seam is seen, either side is right.
            continue
        count += 1
        place = p.directions_to_pixels(np.array(found["direction"]), light.shape[: light.ndim - 1])
        column, row = np.floor(place[:2]).astype(int)
        # A pick closer to the edge of a texel than the page's float32 may be either.
        if np.abs(place[:2] - np.rint(place[:2])).min() < 1e-3:
            continue
        assert found["texel"] == [column, row]
        at = (row, column) if p.faces == 1 else (int(place[2]), row, column)
        # Half floats: 11 bits.
        assert np.allclose(found["value"], light[at], rtol=2**-11)
        # A place has the density of the texel around it, to a few parts in a texel's width.
        assert found["solid_angle"] == pytest.approx(solid[at], rel=0.25)
    assert count > 30


def test_directions_are_those_of_the_library(opened: Callable[..., Any]) -> None:
    viewer = sm.view(image(sm.projection("latlong:blender")), "latlong:blender", fov=60)
    viewer.direction = (0.3, -0.5, 0.2)
    page = opened(viewer)
    # Two roundings of angles in degrees, and a few of the page's doubles.
    assert np.allclose(page.evaluate("spheremap.direction()"), viewer.direction, atol=1e-12)
    height, width = size_of(page)
    found = page.evaluate(f"spheremap.pick({width / 2}, {height / 2})")
    # Float32 shaders.
    assert np.allclose(found["direction"], viewer.direction, atol=1e-6)


def test_marks_and_axes_stand_where_they_are(opened: Callable[..., Any]) -> None:
    viewer = sm.view(np.ones((8, 16)), "latlong:blender", axes=True).mark([0, 1, 0.5], "tree")
    viewer.direction = (0, 1, 0.5)
    page = opened(viewer)
    script = """[...document.querySelectorAll('.labels span')].map((e) =>
        [e.textContent, parseFloat(e.style.left), parseFloat(e.style.top)])"""
    found = {text: (left, top) for text, left, top in page.evaluate(script)}
    # Percents of the stage; float32 shaders.
    assert np.allclose(found["tree"], (50, 50), atol=1e-3)
    assert set(found) == {"tree", "+y"} and found["+y"][1] > 50


def test_lines_and_lights_stand_where_they_are(opened: Callable[..., Any]) -> None:
    light = sm.light.Light(np.array([0.3, 0.2, -1.0]), np.ones(3), 1.0)
    viewer = sm.view(np.zeros((64, 128)), "latlong", fov=80).lights(light)
    viewer.outline([[0, 0, -1], [0.3, 0, -1]], "way", closed=False)
    page = opened(viewer)
    height, width = size_of(page)
    camera = sm.projection("perspective", fov=80, aspect=width / height)
    script = "document.querySelector('.lines .stroke').getAttribute('d')"
    places = np.array([part.split() for part in page.evaluate(script)[1:].split("L")], float)
    wanted = camera.encode([[0, 0, -1.0], [0.3, 0, -1]]) * [width, height]
    # Tenths of a pixel are written.
    assert np.allclose(places[[0, -1]], wanted, atol=0.1)
    style = "document.querySelector('.labels .light').getAttribute('style')"
    left, top, across = re.findall(r"(?:left|top|width):([\d.]+)", page.evaluate(style))
    # Percents, of float32 shaders.
    assert np.allclose([float(left), float(top)], 100 * camera.encode(light.direction), atol=1e-3)
    assert float(across) == 20
    assert page.locator(".labels .name").inner_text() == "way"


@pytest.mark.parametrize("name", ["latlong", "cube", "octahedral", "cube:ffmpeg-c3x2"])
def test_density_has_the_colors_of_its_legend(
    name: str, opened: Callable[..., Any], tmp_path: Path
) -> None:
    p = sm.projection(name)
    viewer = sm.view(np.zeros(p.shape(16)), p, curve="none", density=True, screen="latlong")
    page = opened(viewer)
    seen = drawn(page, tmp_path)
    assert page.locator(".legend li").first.inner_text() == "× 16"
    height, width = size_of(page)
    rows, columns = sm.projection("latlong").shape(int(64 * min(height / 64, width / 128)))
    top, left = (height - rows) // 2, (width - columns) // 2
    d = sm.projection("latlong").in_world_of(p).directions((rows, columns), any_aspect=True)
    mean = p.covered_solid_angle / (p.used_part * p.faces)
    parts = 2 * np.log2(p.density(p.encode(d)) / mean) + 8
    ramp = np.array(colors.RAMP)
    wanted = np.stack([np.interp(parts, np.arange(17), ramp[:, k]) for k in range(3)], axis=-1)
    found = seen[top : top + rows, left : left + columns]
    # Black counts for three tenths. Half a pixel beside a seam is another texel.
    assert peak_to_noise(found, 0.7 * 255 * wanted) > LEAST


def test_circles_have_their_share_of_the_sphere(opened: Callable[..., Any], tmp_path: Path) -> None:
    black = np.zeros((16, 32))
    page = opened(sm.view(black, "latlong", curve="none", tissot=True, screen="equal_area"))
    seen = drawn(page, tmp_path)
    map_of = (seen != 128).any(axis=-1)
    counts = [max(3, round(12 * np.cos(np.radians(at)))) for at in range(-75, 90, 30)]
    wanted = sum(counts) * (1 - np.cos(np.radians(5))) / 2
    # Red of more than 50 reaches 0.85 pixels further than a circle, whose radius is 13 or so.
    radius = np.radians(5) * np.sqrt(map_of.sum() / (4 * np.pi))
    wanted *= (1 + 0.85 / radius) ** 2
    # Some hundred pixels at the rim of each of forty circles.
    assert (seen[..., 0] > 50)[map_of].mean() == pytest.approx(wanted, rel=0.02)


def test_seams_are_where_faces_end(opened: Callable[..., Any], tmp_path: Path) -> None:
    # The square of an octahedron ends where -z is, with a fold above it.
    for name, fov, lines in (("cube", 120.0, 2), ("latlong", 90.0, 0), ("octahedral", 90.0, 1)):
        p = sm.projection(name)
        seen = drawn(
            opened(sm.view(np.zeros(p.shape(16)), p, fov=fov, seams=True)), tmp_path
        ).astype(int)
        row = seen[seen.shape[0] // 2 - 40]
        gold = (row[:, 0] > 200) & (row[:, 1] > 150) & (row[:, 2] < 100)
        starts = np.flatnonzero(gold & ~np.roll(gold, 1))
        assert len(starts) == lines, name
        if lines == 2:
            width = seen.shape[1]
            edge = width / 2 * (1 + np.array([-1, 1]) / np.tan(np.radians(60)))
            assert np.allclose(starts, edge, atol=2.5)  # pixels: a line is two wide


def test_what_is_not_held_is_striped(opened: Callable[..., Any], tmp_path: Path) -> None:
    gray = np.full((32, 32), 0.2140411, np.float32)  # 128 in sRGB
    viewer = sm.view(gray, "angular(fov=120)", curve="none", screen="latlong")
    # The curve of sRGB in float32, rounded.
    assert (np.abs(drawn(opened(viewer), tmp_path).astype(int) - 128) <= 1).all()
    viewer.valid = True
    seen = drawn(opened(viewer), tmp_path)
    striped = (np.abs(seen.astype(int) - 128) > 1).any(axis=-1)
    middle = seen.shape[0] // 2
    assert striped[middle].sum() > 100 and not striped[middle, seen.shape[1] // 2]


def test_a_large_image_follows_an_overview(opened: Callable[..., Any], tmp_path: Path) -> None:
    light = image(sm.projection("latlong"), 1280)
    viewer = sm.view(light, "latlong", fov=30)
    page = opened(viewer)
    read = "(name) => JSON.parse(document.getElementById(name).textContent)"
    first, (whole,) = page.evaluate(read, "scene")["images"][0], page.evaluate(read, "whole")
    assert first["width"] <= 1026 and whole["width"] == 2562 and not whole["reduced"]
    found = page.evaluate("spheremap.pick(300.5, 200.5)")
    column, row = found["texel"]
    # Half floats, of the whole image.
    assert np.allclose(found["value"], light[row, column], rtol=2**-11)
    assert peak_to_noise(drawn(page, tmp_path), viewer.snapshot(size_of(page))) >= LEAST


@pytest.mark.parametrize(
    "look",
    [
        {"fov": 40},
        {"fov": 168},
        {"fov": 250},
        {"screen": "stereographic", "fov": 90},
        {"screen": "mollweide"},
        {"screen": "latlong", "zoom": 6.3},
        {"screen": "octahedral", "zoom": 11, "beside": "latlong"},
    ],
    ids=str,
)
def test_what_a_kernel_sends_is_seen(
    look: dict[str, Any], opened: Callable[..., Any], tmp_path: Path
) -> None:
    """The part of a widget that sharpens a picture, on every kind of screen."""
    d = sm.directions("latlong", 1024, dtype=np.float32)
    # A wave takes twelve texels, and a third of what is sent first.
    light = (0.5 + 0.4 * np.sin(500 * d)).astype(np.float32)
    settings = {name: value for name, value in look.items() if name in ("fov", "screen")}
    viewer = sm.view(light, "latlong", curve="none", direction=(0.4, 0.25, -0.6), **settings)
    page = opened(_Sent(viewer))
    page.evaluate("(look) => spheremap.set(look)", look)
    before = drawn(page, tmp_path)
    asked = page.evaluate("spheremap.seen()")
    images, screen = viewer._images, viewer._screen_named(asked["screen"])
    made = answers.sharper(images[0], asked, screen)
    assert made is not None
    record, words = made
    script = """([record, text]) => spheremap.sharpen(0, record,
        new Uint16Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer))"""
    page.evaluate(script, [record, base64.b64encode(words).decode()])
    seen = drawn(page, tmp_path)
    height, width = asked["size"]
    pose = sm.rotation(asked["yaw"], asked["pitch"])
    # A disk has as many pixels to each side of it.
    size = height, width - (width - height) % 2
    name = screen.name if "zoom" not in look and screen.name != "mollweide" else ""
    by = still.placed(screen, name, asked["fov"], pose, size, asked["zoom"])
    found, held = still.seen(light, images[0].projection, *by, still.sights(*by))
    wanted = io.tonemap(found, curve="none")
    top, left = ((a - b) // 2 for a, b in zip((height, width), held.shape, strict=True))
    parts = [
        picture[top : top + held.shape[0], left : left + held.shape[1]]
        for picture in (before, seen)
    ]
    blurred, sharp = (peak_to_noise(part[held], wanted[held]) for part in parts)
    print(f"{look}: {blurred:.1f} dB and then {sharp:.1f} dB")
    # A lookup between four more texels; of a planet half a pixel of a fast wave is all of it.
    assert sharp >= 30 and sharp > blurred + 3


class _Sent:
    """What a widget is sent first, as a page."""

    def __init__(self, viewer: Any) -> None:
        self.viewer = viewer

    def save(self, path: Path) -> None:
        path.write_text(page_of(self.viewer._shown_in_widget()), encoding="utf-8")


def test_a_notebooks_frame_draws(chromium: Any) -> None:
    page = chromium.new_page()
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.set_content(sm.view(image(sm.projection("latlong"), 32), "latlong")._repr_html_())
    frame = page.frames[1]
    frame.wait_for_function("window.spheremap")
    frame.evaluate("spheremap.ready.then(() => true)")
    assert len(frame.evaluate("spheremap.pick(100, 100).texel")) == 2
    page.close()
    assert said == []


MODEL = """async (scene) => {
    const handlers = {}, values = {
        scene, direction: [1, 0, 0], fov: 50, exposure: 1, curve: "none", false_color: false,
        isolines: false, clipping: false, graticule: 0, axes: true, picked: {},
        valid: false, density: false, tissot: false, seams: false,
    };
    window.saved = 0;
    window.model = {
        get: (name) => values[name],
        set: (name, value) => {
            values[name] = value;
            (handlers[`change:${name}`] ?? []).forEach((handler) => handler());
        },
        on: (name, handler) => (handlers[name] ??= []).push(handler),
        off: () => {},
        // As a kernel answers.
        send: (asked) => {
            if (asked.kind === "pick") window.model.set("picked", { ...asked, texel: [3, 4] });
        },
        save_changes: () => { window.saved++; },
    };
    const el = document.createElement("div");
    document.body.replaceChildren(el);
    window.loaded.default.render({ model: window.model, el });
}"""


def test_a_widget_and_its_model_tell_each_other(chromium: Any, tmp_path: Path) -> None:
    """The module as anywidget loads it, and a model as it hands in."""
    page = chromium.new_page(viewport=SIZE)
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.set_content(
        "<script type=module>window.loaded = await import(URL.createObjectURL("
        f"new Blob([{json.dumps(source('viewer.js'))}], {{type: 'text/javascript'}})))</script>"
    )
    page.wait_for_function("window.loaded")
    viewer = sm.view(image(sm.projection("latlong"), 32), "latlong")
    page.evaluate(MODEL, viewer._scene(64))
    page.add_style_tag(content=source("viewer.css"))
    page.wait_for_function("document.querySelector('canvas').width > 300")
    page.focus("canvas")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("]")
    page.wait_for_function("window.saved > 0")
    # From +x to the right, toward +z: 3 degrees of a view of 60.
    ahead = page.evaluate("model.get('direction')")
    turn = np.degrees(np.arctan2(ahead[2], ahead[0]))
    assert turn == pytest.approx(3 * 50 / 60, abs=1e-9)  # doubles, in degrees
    assert page.evaluate("[model.get('exposure'), model.get('fov')]") == [1.5, 50]
    page.evaluate("model.set('direction', [0, 0, 1])")
    page.mouse.move(200, 200)
    page.wait_for_function("model.get('picked').texel")
    found = page.evaluate("model.get('picked')")
    assert found["direction"][2] > 0.5 and found["image"] == 0
    page.evaluate("model.set('false_color', true)")
    assert page.locator(".legend").is_visible()
    page.close()
    assert said == []


def test_keys_and_pointers_look_around(opened: Callable[..., Any]) -> None:
    page = opened(sm.view(image(sm.projection("latlong")), "latlong"))
    page.focus("canvas")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("f")
    page.keyboard.press("]")
    look = page.evaluate("({...spheremap.look})")
    assert look["yaw"] == -3 and look["false_color"] and look["exposure"] == 0.5
    assert page.locator(".legend").is_visible()
    page.mouse.move(300, 200)
    page.mouse.down()
    page.mouse.move(348, 200)
    page.mouse.up()
    # 48 of 960 pixels of 90 degrees, to the left.
    assert page.evaluate("spheremap.look.yaw") == pytest.approx(-3 + 4.5)
    page.mouse.wheel(0, 4000)
    for _ in range(12):
        page.mouse.wheel(0, 120)
    assert page.evaluate("spheremap.look.fov") > 170
    page.mouse.move(310, 220)
    page.wait_for_function("document.querySelector('.readout').textContent.includes('texel')")
    page.keyboard.press("Home")
    assert page.evaluate("[spheremap.look.yaw, spheremap.look.fov]") == [0, 90]


def test_two_images_have_one_camera(opened: Callable[..., Any], tmp_path: Path) -> None:
    sky = image(sm.projection("latlong"))
    cube = sm.convert(2 * sky, "latlong", "cube:unity", size=64)
    viewer = sm.view(sky, "latlong").add(cube, "cube:unity", name="twice")
    page = opened(viewer)
    page.evaluate("spheremap.set({comparison: 'first'})")
    first = drawn(page, tmp_path)
    page.evaluate("spheremap.set({comparison: 'second', exposure: -1})")
    # Twice the light at half the exposure, converted once more.
    assert peak_to_noise(drawn(page, tmp_path), first) > 38
    page.evaluate("spheremap.set({comparison: 'split', exposure: 0, split: 0.5})")
    split = drawn(page, tmp_path)
    half = split.shape[1] // 2
    assert np.array_equal(split[:, : half - 2], first[:, : half - 2])
    assert split[:, half + 2 :].mean() > first[:, half + 2 :].mean() + 5
    page.evaluate("spheremap.set({comparison: 'difference'})")
    assert peak_to_noise(drawn(page, tmp_path), first) > 38
    page.evaluate("spheremap.set({comparison: 'signed', first: 0, second: 0})")
    assert np.abs(drawn(page, tmp_path).astype(int) - 128).max() <= 1


def test_memory_is_stable_while_images_are_swapped(opened: Callable[..., Any]) -> None:
    viewers = [sm.view(image(sm.projection("latlong"), 128) * k, "latlong") for k in (1, 2)]
    page = opened(viewers[0])
    devtools = page.context.new_cdp_session(page)
    scenes = [viewer._scene(4096) for viewer in viewers]
    page.evaluate("(scenes) => { window.scenes = scenes; }", scenes)
    swaps = """async (count) => {
        for (let k = 0; k < count; k++) {
            await spheremap.swap(structuredClone(window.scenes[k % 2]));
            spheremap.draw(1);
        }
    }"""

    def held() -> float:
        devtools.send("HeapProfiler.collectGarbage")
        usage = devtools.send("Runtime.getHeapUsage")
        # Arrays of numbers are no part of the heap itself.
        return float(usage["usedSize"] + usage["backingStorageSize"])

    page.evaluate(swaps, 20)
    # Textures are a graphics card's memory, which no heap shows.
    page.evaluate("""() => {
        window.alive = 0;
        const own = WebGL2RenderingContext.prototype, { createTexture, deleteTexture } = own;
        own.createTexture = function () { window.alive++; return createTexture.call(this); };
        own.deleteTexture = function (one) { window.alive--; deleteTexture.call(this, one); };
    }""")
    before = held()
    page.evaluate(swaps, 200)
    assert page.evaluate("window.alive") == 0
    # Less than what five of two hundred images take: 128 × 256 texels of eight bytes.
    assert held() - before < 5 * 128 * 256 * 8
    found = page.evaluate("spheremap.pick(300.5, 200.5)")
    column, row = found["texel"]
    # Half floats, of the second image.
    assert np.allclose(
        found["value"], 2 * image(sm.projection("latlong"), 128)[row, column], rtol=2**-10
    )


def test_nan_and_infinity_are_shown(opened: Callable[..., Any], tmp_path: Path) -> None:
    light = np.ones((32, 64), np.float32)
    light[14:18, 30:34] = np.nan
    light[8, 32] = np.inf
    page = opened(sm.view(light, "latlong", curve="none"))
    seen = drawn(page, tmp_path)
    middle = seen[seen.shape[0] // 2, seen.shape[1] // 2]
    assert tuple(middle) in {(255, 0, 255), (0, 0, 0)}
    found = page.evaluate(f"spheremap.pick({seen.shape[1] / 2}, {seen.shape[0] / 2})")
    assert all(np.isnan(found["value"]))
    assert (seen[4, 4] == 255).all()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_controls_have_names_and_a_theme(scheme: str, opened: Callable[..., Any]) -> None:
    page = opened(sm.view(np.ones((16, 32), np.float32), "latlong"), color_scheme=scheme)
    script = "getComputedStyle(document.querySelector('.spheremap')).backgroundColor"
    shade = sum(int(part) for part in page.evaluate(script)[4:-1].split(","))
    assert (shade > 384) is (scheme == "light")
    nameless = """[...document.querySelectorAll('canvas, select, input')].filter((e) =>
        !(e.getAttribute('aria-label') || e.closest('label')?.textContent.trim())).length"""
    assert page.evaluate(nameless) == 0


def test_every_screen_draws(opened: Callable[..., Any], tmp_path: Path) -> None:
    """Every map that is registered compiles as WebGL and shows something."""
    page = opened(sm.view(image(sm.projection("latlong"), 32), "latlong"))
    for name in page.evaluate("[...document.querySelector('select').options].map((o) => o.value)"):
        page.evaluate("(screen) => spheremap.set({screen})", name)
        seen = drawn(page, tmp_path)
        assert (seen != 128).any(axis=-1).mean() > 0.1, name


@pytest.mark.parametrize("name", list(sm.projections()))
def test_every_image_is_looked_up(name: str, opened: Callable[..., Any], tmp_path: Path) -> None:
    p = sm.projection(name)
    page = opened(sm.view(image(p, 32), p))
    assert (drawn(page, tmp_path) != 128).any(axis=-1).mean() > 0.3
