"""The page without a browser: what it holds, what is refused, and stills."""

from __future__ import annotations

import base64
import json
import re
import subprocess
import sys
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from scenes import scene
from spheremap.viewer import Viewer, shaders, texels

SKY = scene(sm.directions("latlong", 32))


def record(page: str) -> dict[str, Any]:
    (found,) = re.findall(r'<script id="scene" type="application/json">(.*?)</script>', page, re.S)
    return json.loads(found)


def unpacked(text: str, shape: tuple[int, ...], dtype: type) -> np.ndarray:
    """Return what the page makes of packed words, by the same steps."""
    # A stream without a header.
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text), wbits=-15), np.uint8)
    planes = planes.reshape(np.dtype(dtype).itemsize, shape[-1], -1).astype(dtype)
    steps = planes[0] if len(planes) == 1 else planes[0] | planes[1] << 8
    return np.cumsum(steps, axis=1, dtype=dtype).T.reshape(shape)


def light_of(image: dict[str, Any]) -> np.ndarray:
    """Return the light that is sent, with its border."""
    shape = tuple(image[side] for side in ("faces", "height", "width", "channels"))
    if image["table"] is None:
        halves = unpacked(image["words"], shape, np.uint16)
    else:
        halves = np.array(image["table"], np.uint16)[unpacked(image["words"], shape, np.uint8)]
    return halves.view(np.float16).astype(np.float64) * image["gain"]


def test_a_page_is_complete_in_itself() -> None:
    page = sm.view(SKY, "latlong").html()
    assert not re.search(r"https?://|\ssrc=|@import|url\(|import\(|fetch\(", page)
    assert page.count("<script") == 3 == page.count("</script>")
    assert "export function mount" in page


def test_a_name_cannot_end_the_script() -> None:
    page = sm.view(SKY, "latlong", name="</script><b>").html()
    assert page.count("</script>") == 3 and "<b>" not in page
    assert record(page)["title"] == "</script><b>"


@pytest.mark.parametrize("name", list(sm.projections()))
def test_every_map_is_printed_as_image_and_as_screen(name: str) -> None:
    p = sm.projection(name)
    found = shaders.image(p)
    for text, verb in (("lookup", "imageN_encode"), ("own", "own_encode"), ("own", "own_density")):
        assert f" {verb}(" in found[text]
    screen = shaders.screens().get(name) or shaders.screen(p)
    assert all(f" screen_{verb}(" in screen["text"] for verb in ("encode", "decode", "valid"))
    # Flat: a screen is one image.
    assert "screen_decode(vec2 uv)" in screen["text"]


def test_directions_of_a_page_are_matched_to_a_program() -> None:
    d = np.random.default_rng(0).normal(size=(50, 3))
    for name in ("latlong:blender", "cube:unreal", "latlong:mitsuba", "angular"):
        p = sm.projection(name)
        world = np.array(record(sm.view(np.ones(p.shape(16)), p).html())["world"])
        there = p.in_world_of("latlong").encode(d)
        # The same numbers in another order.
        assert np.allclose(p.encode(d @ world.T), there, rtol=0, atol=1e-12, equal_nan=True)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.float16, np.uint8, np.uint16])
def test_light_comes_back(dtype: type) -> None:
    image = SKY if np.dtype(dtype).kind == "f" else np.clip(SKY, 0, 1) * np.iinfo(dtype).max
    image = image.astype(dtype)
    (sent,) = record(sm.view(image, "latlong").html())["images"]
    inner = light_of(sent)[0, 1:-1, 1:-1]
    wanted = texels.light(image)
    # Half floats have 11 bits; the darkest are 2^-30 of the brightest.
    assert np.allclose(inner, wanted, rtol=2**-11, atol=2.0**-30 * float(wanted.max()))


@pytest.mark.parametrize("scale", [1e-20, 1e-3, 1.0, 1e9, 1e30])
def test_the_range_of_light_is_kept(scale: float) -> None:
    image = (SKY.astype(np.float64) * scale).astype(np.float32)
    (sent,) = record(sm.view(image, "latlong").html())["images"]
    inner = light_of(sent)[0, 1:-1, 1:-1]
    # As above.
    assert np.allclose(inner, image, rtol=2**-11, atol=2.0**-30 * float(image.max()))


WHOLE = [n for n in sm.projections() if sm.projection(n).used_part == 1]


@pytest.mark.parametrize("name", [*WHOLE, "cube:unity", "latlong:filament", "cube:ffmpeg-c3x2"])
def test_four_texels_are_a_lookup_without_a_seam(name: str) -> None:
    p = sm.projection(name).in_world_of("latlong")
    image = sm.convert(SKY, "latlong", p, size=24)
    sent = texels.texels(texels.apart(image, p), p)
    halves = sent.words.view(np.float16).astype(np.float64) * sent.gain
    d = np.random.default_rng(1).normal(size=(20_000, 3))
    uv = texels.own_faces(p).encode(d)
    seen = np.isfinite(uv).all(axis=-1)
    uv, d = uv[seen], d[seen]
    face = uv[:, 2].astype(int) if p.faces > 1 or uv.shape[1] == 3 else np.zeros(len(uv), int)
    place = uv[:, :2] * sent.place()[:2] + sent.place()[2:]
    low = np.floor(place).astype(int)
    low = np.clip(low, 0, np.array(halves.shape[2:0:-1]) - 2)
    part = place - low
    found = np.zeros((len(uv), 3))
    for k in range(4):
        step = np.array([k & 1, k >> 1])
        weight = np.where(step, part, 1 - part).prod(axis=-1)
        column, row = (low + step).T
        found += weight[:, None] * halves[face, row, column]
    wanted = sm.sample(image, d, p)
    error = np.sqrt(np.mean((found - wanted) ** 2)) / np.abs(wanted).max()
    # Half floats; beside the corners of a cube `sample` mixes more than four.
    assert error < 2e-3


def test_what_is_no_value_is_said() -> None:
    image = np.ones((16, 16, 3), np.float32)
    image[8, 8, 1] = np.nan
    angular = sm.projection("angular")
    sent = texels.texels(texels.apart(image, angular), angular)
    assert sent.states is not None
    assert sent.states[0, 9, 9] == texels.MISSING
    assert sent.states[0, 1, 1] == texels.OUTSIDE
    assert sent.states[0, 5, 9] == texels.VALUE
    assert texels.texels(np.ones((1, 4, 8, 3)), sm.projection("latlong")).states is None


@pytest.mark.parametrize(
    "name, shape, wanted",
    [
        ("latlong", (64, 128), (32, 64)),
        ("cube", (6, 48, 48), (48, 48)),
        ("cube", (6, 96, 96), (64, 64)),
    ],
)
def test_no_more_than_max_size_is_sent(
    name: str, shape: tuple[int, ...], wanted: tuple[int, ...]
) -> None:
    image = np.full((*shape, 3), 7.0, np.float32)
    (sent,) = record(sm.view(image, name, max_size=64).html())["images"]
    assert (sent["height"] - 2, sent["width"] - 2) == wanted
    assert sent["shape"] == ([1, *shape] if len(shape) == 2 else list(shape))
    # A power of two times a small whole number is exact.
    assert (light_of(sent) == 7).all()


def test_a_notebook_shows_it_in_a_frame() -> None:
    v = sm.view(np.ones((6, 4, 4)), "cube")
    frame = v._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and frame.count('"') % 2 == 0
    assert "&lt;!doctype html&gt;" in frame
    large = sm.view(np.zeros((2050, 4100), np.uint8), "latlong")
    assert len(large._repr_html_()) < len(large.html())


def test_it_saves_what_it_is(tmp_path: Path) -> None:
    v = sm.view(SKY, "latlong", false_color=True).add(SKY, "latlong", name="again")
    v.save(tmp_path / "look.html")
    page = (tmp_path / "look.html").read_text(encoding="utf-8")
    assert page == v.html()
    assert [image["name"] for image in record(page)["images"]] == ["latlong", "again"]
    assert record(page)["look"]["false_color"] is True
    with pytest.raises(
        ValueError, match=r"`path` to be that of a page, .* got '\.PNG': .*snapshot"
    ):
        v.save(tmp_path / "look.PNG")
    assert [path.name for path in tmp_path.iterdir()] == ["look.html"]


@pytest.mark.parametrize("direction", [(0, 0, -1), (1, 2, 3), (0, 1, 0), (-5, -1e-3, 4)])
def test_a_camera_looks_where_it_is_told(direction: tuple[float, ...]) -> None:
    look = record(sm.view(SKY, "latlong", direction=direction).html())["look"]
    ahead = sm.rotation(look["yaw"], look["pitch"]) @ [0, 0, -1]
    # A few roundings of angles.
    assert np.allclose(ahead, direction / np.linalg.norm(direction), rtol=0, atol=1e-14)


def test_a_screen_of_ones_own_is_among_the_pages() -> None:
    look = record(sm.view(SKY, "latlong", screen="mollweide").html())
    assert look["look"]["screen"] == "mollweide"
    for screen in ("cube:unity", "angular(fov=180)", "camera_pinhole"):
        found = record(sm.view(SKY, "latlong", screen=screen).html())
        assert found["look"]["screen"] in found["screens"]
        assert len(found["screens"]) == len(look["screens"]) + 1


@pytest.mark.parametrize("name", list(sm.projections()))
def test_the_first_view_holds_something(name: str) -> None:
    p = sm.projection(name)
    assert p.covers(sm.view(np.ones(p.shape(16)), p).direction)


def test_marks_are_in_the_world_of_the_image() -> None:
    v = sm.view(np.ones((8, 16)), "latlong:blender").mark([0, 0, 2.0], "up")
    v.mark([[1, 0, 0], [0, -3, 0]])
    up, *dots = record(v.html())["marks"]
    # +z is up in Blender, +y on the page; a permutation is exact.
    assert up == {"text": "up", "direction": [0, 1, 0]}
    assert [dot["text"] for dot in dots] == ["•", "•"]
    for directions, names, says in (
        ([0, 0, 0], None, "to be a direction"),
        ([[1, 0, 0]], ["a", "b"], "1 names, one a direction, got 2"),
        (np.ones((2, 2)), None, "(N, 3), got (2, 2)"),
        (np.ones((2000, 3)), None, "at most 1024 marks"),
    ):
        with pytest.raises(ValueError, match=re.escape(says)):
            v.mark(directions, names)


def test_settings_are_checked_when_they_are_set() -> None:
    v = sm.view(SKY, "latlong")
    assert isinstance(v, Viewer) and v.curve == "reinhard" and v.direction == (0, 0, -1)
    v.direction = [0, 3, 4]
    assert np.allclose(v.direction, (0, 0.6, 0.8), rtol=0, atol=1e-15)  # two roundings
    for name, value, error, says in (
        ("direction", (0, 0, 0), ValueError, "`direction` to be a direction"),
        ("direction", (1, 2), ValueError, r"shape \(3,\), got \(2,\)"),
        ("direction", (np.nan, 0, 1), ValueError, "`direction` to be a direction"),
        ("fov", 400, ValueError, "`fov` to be from 15 to 340, got 400"),
        ("fov", "wide", TypeError, "`fov` to be a number, got str"),
        ("exposure", np.nan, ValueError, "`exposure` to be from -126 to 126"),
        ("curve", "filmic", ValueError, "unknown curve 'filmic'; there are none, reinhard"),
        ("screen", "nothing", ValueError, "unknown projection"),
        ("false_color", 1, TypeError, "`false_color` to be a bool"),
        ("graticule", -1, ValueError, "`graticule` to be from 0 to 90"),
        ("max_size", 1 << 20, ValueError, "`max_size` to be from 2 to 16384"),
        ("zoom", 1, AttributeError, "no 'zoom'; there are direction, fov"),
    ):
        before = getattr(v, name, None)
        with pytest.raises(error, match=says):
            setattr(v, name, value)
        assert getattr(v, name, None) == before


@pytest.mark.parametrize(
    "image, error, says",
    [
        (np.ones((32, 32)), ValueError, "twice as wide as high"),
        (np.ones((0, 0)), ValueError, "to have texels"),
        (np.ones(8), ValueError, "shape"),
        (np.ones((32, 64), complex), TypeError, "dtype"),
        (np.ones((32, 64), np.int32), TypeError, "dtype"),
    ],
)
def test_bad_images_are_refused(image: np.ndarray, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        sm.view(image, "latlong")


def test_stills_are_conversions() -> None:
    v = sm.view(SKY, "latlong", fov=70, direction=(1, 0.2, 0.5), exposure=-2)
    yaw, pitch = (record(v.html())["look"][angle] for angle in ("yaw", "pitch"))
    camera = sm.projection("perspective", fov=70, aspect=16 / 9).turned(sm.rotation(yaw, pitch))
    wanted = sm.convert(SKY, "latlong", camera, size=(36, 64))
    assert np.array_equal(v.snapshot((36, 64)), sm.io.tonemap(wanted, exposure=-2))
    v.screen = "mollweide"
    assert v.snapshot((36, 64)).shape == (32, 64, 3)
    v.screen, v.fov = "perspective", 300
    planet = v.snapshot((36, 64))
    assert planet.shape == (36, 64, 3)
    with pytest.raises(ValueError, match="both even or both odd"):
        v.snapshot((35, 64))
    with pytest.raises(ValueError, match="rows and columns, got 1"):
        v.snapshot((35,))


def test_stills_keep_pictures_and_mark_what_is_missing() -> None:
    picture = np.random.default_rng(2).integers(0, 256, (32, 64, 3), np.uint8)
    v = sm.view(picture, "latlong", screen="latlong")
    assert v.curve == "none"
    assert np.array_equal(v.snapshot((32, 64)), picture)
    cap = sm.view(np.full((32, 32), np.nan), "angular(fov=180)", screen="latlong")
    still = cap.snapshot((32, 64))
    assert (still[16, 32] == (255, 0, 255)).all() and (still[16, 2] == 128).all()


def test_a_widget_has_the_settings_as_traits() -> None:
    pytest.importorskip("anywidget", reason="widgets need: pip install spheremap[view]")
    w = sm.view(SKY, "latlong", direction=(0, 3, 4), fov=50, false_color=True).widget()
    assert np.allclose(w.direction, (0, 0.6, 0.8), rtol=0, atol=1e-15)  # two roundings
    assert (w.fov, w.false_color, w.curve, w.picked) == (50, True, "reinhard", {})
    assert {"direction", "fov", "exposure", "picked", "scene"} <= set(w.keys)
    w.direction = [0, 0, 2]
    assert w.direction == [0, 0, 1]
    for name, value in (("fov", 400.0), ("direction", [0.0, 0.0, 0.0]), ("curve", "filmic")):
        before = getattr(w, name)
        with pytest.raises(ValueError, match=f"`{name}`|{value}"):
            setattr(w, name, value)
        assert getattr(w, name) == before
    # Messages are JSON, which has no NaN.
    json.dumps(w.scene, allow_nan=False)


def test_a_widget_without_its_extra_says_what_to_install() -> None:
    code = (
        "import sys; sys.modules['anywidget'] = None; import spheremap as sm, numpy as np\n"
        "try: sm.view(np.zeros((4, 8)), 'latlong').widget()\n"
        "except ImportError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install spheremap[view]" in done.stdout


def test_the_package_is_imported_without_it() -> None:
    code = (
        "import sys, spheremap as sm; before = 'spheremap.viewer' in sys.modules; sm.view; "
        "print(before, 'spheremap.viewer' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False True"
