"""What stands over images: in whose world it is, and what is refused."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
import spheremap as sm

PLAIN = np.ones((16, 32))


def scene(viewer: Any) -> dict[str, Any]:
    (found,) = re.findall(
        r'<script id="scene" type="application/json">(.*?)</script>', viewer.html(), re.S
    )
    made: dict[str, Any] = json.loads(found)
    return made


def test_lines_go_along_great_circles() -> None:
    v = sm.view(PLAIN, "latlong:blender").outline([[2, 0, 0], [0, 0, 5]], "rise", closed=False)
    (line,) = scene(v)["lines"]
    points = np.array(line["points"])
    assert line["text"] == "rise"
    # +z is up in Blender, +y on the page; ends are as given.
    assert points[0].tolist() == [1, 0, 0] and points[-1].tolist() == [0, 1, 0]
    unit = points / np.linalg.norm(points, axis=1, keepdims=True)
    steps = np.degrees(np.arccos(np.sum(unit[1:] * unit[:-1], axis=1)))
    assert (points[:, 2] == 0).all() and steps.max() < 3


def test_a_closed_line_comes_back() -> None:
    corners = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    (line,) = scene(sm.view(PLAIN, "latlong").outline(corners))["lines"]
    assert line["points"][0] == line["points"][-1] == [1, 0, 0]
    assert all(corner in line["points"] for corner in corners)


@pytest.mark.parametrize("name", ["latlong", "cube", "cube:ffmpeg-c3x2", "latlong:unreal"])
def test_a_box_is_the_border_of_its_pixels(name: str) -> None:
    p = sm.projection(name)
    shape = p.shape(32)
    face = 3 if p.faces > 1 else None
    v = sm.view(np.ones(shape), p).box((4, 6, 12, 9), "car", face=face)
    made = scene(v)
    points = np.array(made["lines"][0]["points"]) @ np.array(made["world"]).T
    places = p.directions_to_pixels(points, shape)
    x, y = places[:, 0], places[:, 1]
    # Pixels of some tens, in doubles.
    on = np.abs(np.stack([x - 4, x - 12, y - 6, y - 9])).min(axis=0)
    # The same.
    assert on.max() < 1e-9
    # Doubles again.
    assert np.allclose([np.ptp(x), np.ptp(y)], [8, 3], rtol=0, atol=1e-9)
    assert face is None or (places[:, 2] == 3).all()


def test_lights_are_as_large_as_they_are() -> None:
    sky = np.zeros((32, 64, 3))
    sky[8, 20], sky[20, 50] = (4, 0, 0), (0, 0, 1)
    found = sm.light.lights(sky, "latlong", count=2)
    red, blue = scene(sm.view(sky, "latlong").lights(found))["lights"]
    assert (red["color"], blue["color"]) == ("#ff0000", "#0000ff")
    assert red["size"] == 1 and not red["sun"]
    wanted = np.sqrt(found.irradiance @ [0.2126, 0.7152, 0.0722])
    # Areas are the ratio of BT.709 luminances of the two, in doubles.
    assert blue["size"] == pytest.approx(wanted[1] / wanted[0], rel=1e-12)
    # Unit vectors, normalized once more.
    assert np.allclose([red["direction"], blue["direction"]], found.directions, rtol=0, atol=1e-12)
    sun = sm.light.Sun(np.array([0, 2.0, 0]), 1e-4, np.ones(1), np.zeros(1), 0.01)
    (ring,) = scene(sm.view(sky, "latlong").lights(sun))["lights"]
    assert ring["sun"] and ring["direction"] == [0, 1, 0]


@pytest.mark.parametrize(
    "call, error, says",
    [
        (lambda v: v.outline([[1, 0, 0]]), ValueError, "(N, 3) of two or more, got (1, 3)"),
        (lambda v: v.outline([[1, 0, 0], [-1, 0, 0]]), ValueError, "no two `directions` in a row"),
        (lambda v: v.outline([[1, 0, 0], [0, 0, 0]]), ValueError, "to be a direction"),
        (lambda v: v.outline(np.eye(3), closed=1), TypeError, "`closed` to be a bool"),
        (lambda v: v.box((1, 2, 3)), ValueError, "left, top, right, bottom, got 3 numbers"),
        (lambda v: v.box((5, 2, 3, 4)), ValueError, "left < right and top < bottom"),
        (lambda v: v.box((1, 2, 3, np.nan)), ValueError, "left < right and top < bottom"),
        (lambda v: v.box((1, 2, 3, 4), face=2), ValueError, "`face` to be none"),
        (lambda v: v.lights(["lamp"]), TypeError, "of Light or Sun, got str"),
        (lambda v: v.mark(np.ones((2000, 3))), ValueError, "at most 1024 marks"),
    ],
)
def test_what_is_no_overlay(call: Any, error: type[Exception], says: str) -> None:
    v = sm.view(PLAIN, "latlong")
    with pytest.raises(error, match=re.escape(says)):
        call(v)
    made = scene(v)
    assert made["lines"] == made["lights"] == made["marks"] == []


def test_a_box_beside_the_sphere_is_refused() -> None:
    disk = sm.view(np.ones((64, 64)), "angular(fov=180)")
    with pytest.raises(ValueError, match="no sphere around the box"):
        disk.box((0, 0, 2, 2))
    with pytest.raises(ValueError, match=r"`face` to be one of 6 faces, got None"):
        sm.view(np.ones((6, 4, 4)), "cube").box((0, 0, 2, 2))
    with pytest.raises(ValueError, match=r"`face` to be from 0 to 5, got 6"):
        sm.view(np.ones((6, 4, 4)), "cube").box((0, 0, 2, 2), face=6)
