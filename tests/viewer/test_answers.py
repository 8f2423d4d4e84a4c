"""What a kernel answers to the page of a widget."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import spheremap as sm
from spheremap.viewer.answers import Shown, picked, sharper

MAPS = ["latlong", "latlong:blender", "cube", "cube:ffmpeg-c3x2", "octahedral", "mollweide"]


@pytest.mark.parametrize("name", MAPS)
def test_what_is_picked_is_of_the_array_itself(name: str) -> None:
    p = sm.projection(name)
    shape = p.shape(24)
    image = np.arange(np.prod(shape) * 4, dtype=np.float64).reshape(*shape, 4)
    shown = Shown(image, p, "here")
    for at in np.random.default_rng(3).integers(0, shape, (40, len(shape))):
        d = p.directions(shape)[tuple(at)]
        if not np.isfinite(d).all():
            continue
        found = picked(shown, p, d.tolist())
        *face, row, column = at.tolist()
        assert found["texel"] == [column, row] and found.get("face", 0) == (face or [0])[0]
        assert found["value"] == image[tuple(at)].tolist()
        solid = p.solid_angle(shape)[tuple(at)]
        # The density in the middle of a texel, and its mean.
        assert found["solid_angle"] == pytest.approx(solid, rel=0.3)


def test_a_direction_is_of_the_world_of_the_first_image() -> None:
    blender, unity = sm.projection("latlong:blender"), sm.projection("latlong:unity")
    image = np.zeros((16, 32))
    image[0] = 7
    # Up is +z in Blender.
    assert picked(Shown(image, unity, "b"), blender, [0, 0.01, 1])["value"] == [7]


def test_what_is_no_number_is_none() -> None:
    p = sm.projection("angular(fov=180)")
    image = np.full((8, 8, 3), np.nan)
    found = picked(Shown(image, p, "a"), p, [0, 0, -1])
    assert found["value"] == [None, None, None]
    beyond = picked(Shown(image, p, "a"), p, [0, 0, 1])
    assert set(beyond) == {"image", "direction"}


def read(record: dict[str, Any], words: bytes) -> tuple[np.ndarray, np.ndarray]:
    texels = np.frombuffer(words, np.float16).reshape(record["height"], record["width"], 4)
    return texels[..., :3].astype(float) * record["scale"][2], texels[..., 3]


def test_a_sharper_picture_is_a_perspective_of_the_whole_image() -> None:
    p = sm.projection("latlong")
    image = np.random.default_rng(0).random((128, 256, 3)).astype(np.float32)
    made = sharper(Shown(image, p, "a"), {"yaw": 30, "pitch": 10, "fov": 60, "size": [90, 160]})
    assert made is not None
    record, words = made
    assert (record["height"], record["width"]) == (108, 192)
    light, states = read(record, words)
    # A fifth wider than the view.
    fov = np.degrees(2 * np.arctan(1.2 * np.tan(np.radians(30))))
    camera = sm.projection("perspective", fov=fov, aspect=192 / 108)
    wanted = sm.convert(image, p, camera.turned(sm.rotation(30, 10)), size=(108, 192))
    # Half floats.
    assert np.allclose(light, wanted, rtol=2**-10, atol=1e-4) and (states == 1).all()
    pose = np.array(record["pose"]).reshape(3, 3).T
    assert np.array_equal(pose, sm.rotation(30, 10))
    half = 1.2 * np.tan(np.radians(30)) / np.tan(np.radians(86))
    assert record["scale"][:2] == pytest.approx([half, half * 108 / 192], rel=1e-12)  # doubles


@pytest.mark.parametrize(
    ("screen", "fov", "zoom"),
    [
        ("stereographic", 100, 1),
        ("perspective", 250, 1),
        ("mollweide", 60, 7.3),
        ("latlong", 60, 64),
        ("octahedral", 60, 3),
    ],
)
def test_a_sharper_picture_of_a_screen_is_what_it_shows(
    screen: str, fov: float, zoom: float
) -> None:
    image = (1 + sm.directions("latlong", 512, dtype=np.float32)) / 2
    asked = {"yaw": 30, "pitch": 10, "fov": fov, "zoom": zoom, "size": [91, 160], "screen": screen}
    made = sharper(Shown(image, sm.projection("latlong"), "a"), asked, sm.projection(screen))
    assert made is not None
    light, states = read(*made)
    wide, high, _ = made[0]["scale"]
    part = np.stack(np.meshgrid(*((np.arange(n) + 0.5) / n for n in states.shape[::-1])), axis=-1)
    uv = 0.5 + (part - 0.5) * [wide, high]
    # A wide perspective is one as well.
    lens = "stereographic(fov=344)" if screen in ("stereographic", "perspective") else screen
    d = sm.projection(lens).decode(uv) @ sm.rotation(30, 10).T
    assert (states == 1).mean() > 0.5
    # What is seen is the direction itself: half floats, and means over the arc that a pixel sees.
    assert np.allclose(light[states == 1], (1 + d[states == 1]) / 2, atol=2e-3)


def test_states_say_what_is_missing() -> None:
    image = np.ones((64, 64), np.float32)
    image[31:33, 31:33] = np.nan
    shown = Shown(image, sm.projection("angular(fov=90)"), "a")
    made = sharper(shown, {"yaw": 0, "pitch": 0, "fov": 120, "size": [64, 64]})
    assert made is not None
    light, states = read(*made)
    middle = len(states) // 2
    assert states[middle, middle] == -1 and states[0, 0] == 0
    assert states[middle, middle + 8] == 1 and light[middle, middle + 8].tolist() == [1, 1, 1]


@pytest.mark.parametrize(
    "asked", [{"fov": 341}, {"fov": -3}, {"zoom": 0.5}, {"size": [1, 5]}, {"size": [5, np.nan]}]
)
def test_there_is_none_of_what_no_page_shows(asked: dict[str, Any]) -> None:
    shown = Shown(np.ones((8, 16)), sm.projection("latlong"), "a")
    given = {"yaw": 0, "pitch": 0, "fov": 60, "size": [64, 64]} | asked
    assert sharper(shown, given) is None


def test_a_widget_answers_and_takes_other_images() -> None:
    pytest.importorskip("anywidget", reason="widgets need: pip install spheremap[view]")
    image = np.random.default_rng(0).random((2048, 4096)).astype(np.float32)
    w = sm.view(image, "latlong").add(image[::64, ::64], "latlong", name="small").widget()
    assert [sent["reduced"] for sent in w.scene["images"]] == [True, False]
    assert w.scene["images"][0]["width"] == 1026 and w.scene["detail"]
    sent: list[Any] = []
    w.send = lambda content, buffers=None: sent.append((content, buffers))
    asked = {"kind": "see", "yaw": 0, "pitch": 0, "fov": 60, "size": [9, 16]}
    asked |= {"screen": "perspective", "images": [0, 7]}
    w._handle_custom_msg(asked, [])
    (detail, buffers), (seen, _) = sent
    assert (detail["kind"], detail["image"], seen) == ("detail", 0, {"kind": "seen"})
    assert len(buffers[0]) == detail["width"] * detail["height"] * 8
    w._handle_custom_msg({"kind": "pick", "image": 0, "direction": [0.1, 0.2, -1]}, [])
    column, row = w.picked["texel"]
    assert w.picked["value"] == [float(image[row, column])] and w.clicked == {}
    w._handle_custom_msg({"kind": "pick", "image": 0, "direction": [1, 0, 0], "clicked": True}, [])
    assert w.clicked["direction"] == [1, 0, 0]
    w._handle_custom_msg("something else", [])
    before = w.scene
    w.show(2 * image[:1024, :2048])
    assert w.scene["images"][0]["shape"] == (1, 1024, 2048) and w.scene is not before
    with pytest.raises(ValueError, match="twice as wide as high"):
        w.show(np.ones((5, 5)))
