"""What values say of themselves: records in lines, lists as tables, maps and lights as pictures."""

from __future__ import annotations

import base64
import copy
import json
import pickle
import re
import xml.etree.ElementTree as ElementTree
from functools import cache

import cv2
import numpy as np
import pytest
import spheremap as sm
from conftest import CASES, DEFAULTS, LAYOUTS, PARAMETERS, each
from spheremap._show import short


@cache
def shown() -> dict[str, object]:
    d = sm.directions("latlong", 64)
    scene = 1.5 + d[..., :1] * [1, 0.5, 0.2] + d[..., 1:2] * d[..., 2:]
    scene[12, 20] = 4e4
    ball = sm.ball.Ball((30.0, 30.0), (20.0, 20.0), 0.0, 1.0)
    photo = sm.ball.render(scene, size=60, center=(30, 30), radius=20)
    lights = sm.light.lights(scene, "latlong", count=40)
    return {
        "Projection": sm.projection("cube:openexr"),
        "Energy": sm.light.energy(scene, "latlong"),
        "Comparison": sm.align.compare("latlong:blender", "latlong:threejs"),
        "Bake": sm.light.bake(scene, "latlong", size=8, samples=8, diffuse_size=4),
        "Lights": lights,
        "Light": lights[0],
        "Sun": sm.light.sun(scene, "latlong"),
        "Distribution": sm.light.Distribution(scene, "latlong"),
        "Ball": ball,
        "UnwrappedBall": sm.ball.unwrap(photo, size=16, center=(30, 30), radius=20, fov=20),
        "RemapPlan": sm.remap_plan("latlong", "cube", size=8),
        "Identification": sm.align.identify(scene, scene[:, ::-1]),
        "Packing": sm.packing.packing("oct16x2"),
    }


@pytest.mark.parametrize("name", list(shown()))
def test_a_record_is_one_line(name):
    thing = shown()[name]
    text = repr(thing)
    # A projection's is the call of the function that makes it.
    begins = "projection(" if name == "Projection" else f"{name}("
    assert type(thing).__name__ == name and text.startswith(begins)
    assert "\n" not in text and len(text) < 500
    assert "array(" not in text and "np." not in text


def test_lines_say_what_is_there():
    energy, lights, bake = shown()["Energy"], shown()["Lights"], shown()["Bake"]
    assert "peak=40000, " in repr(energy) and "sun=Sun(direction=(" in repr(energy)
    assert repr(lights).startswith("Lights(directions=float64 (40, 3), ")
    assert "diffuse=float64 (6, 4, 4, 3), specular=[float64 (6, 8, 8, 3), " in repr(bake)
    assert "turned by 90° about -x" in repr(shown()["Comparison"])
    assert repr(sm.align.compare("cube", "cube")).endswith("the same, texel by texel)")
    assert "certain: " in repr(shown()["Identification"])
    blank = np.ones((8, 16))
    assert "cannot tell: " in repr(sm.align.identify(blank, blank))
    assert repr(shown()["Packing"]) == (
        'Packing("oct16x2", 32 bits as 2 of int16, off by 0.00247° at most)'
    )
    assert "no bound" in repr(sm.packing.packing("sphere16"))
    # A ball can be pasted.
    assert eval(repr(shown()["Ball"]), vars(sm.ball)) == shown()["Ball"]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (np.array([1.0, -0.0, 0.1234567]), "(1, 0, 0.123457)"),
        (np.float32(2), "2"),
        (np.array(3.5), "3.5"),
        (np.arange(5.0), "float64 (5,)"),
        (np.array([True]), "bool (1,)"),
        (np.array(["x"]), "<U1 (1,)"),
        (np.array([1j]), "complex128 (1,)"),
        ([np.ones((2, 2)), None], "[float64 (2, 2), None]"),
        (("a",), "('a',)"),
        ((), "()"),
        (tuple(range(9)), "(0, 1, 2, 3, ... 9)"),
        (True, "True"),
        (float("nan"), "nan"),
        (10**400, str(10**400)),
    ],
)
def test_values_in_a_line(value, text):
    assert short(value) == text


@each(
    [
        *DEFAULTS,
        *[c for c in LAYOUTS if c.options][::6],
        *[c for c in CASES if "axes" in c.options][::9],
    ]
)
def test_a_map_draws_itself(case):
    p = case.make()
    page = p._repr_html_()
    assert len(page) < 60_000
    assert p.axes.split()[0] in page
    root = ElementTree.fromstring(page)
    svg, *captions = root
    assert captions[0].text == repr(p)
    space = "{http://www.w3.org/2000/svg}"
    width, height = int(svg.get("width", "")), int(svg.get("height", ""))
    assert 64 <= max(width, height) <= 540 + 11 * 4
    image = svg.find(f"{space}image")
    assert image is not None
    data = base64.b64decode(image.get("href", "").partition(",")[2])
    png = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert png is not None and png.shape == (height, width, 4)

    named = {t.text: t for t in svg.findall(f"{space}text")}
    axes = {f"{sign}{axis}": (1 if sign == "+" else -1) * e
            for axis, e in zip("xyz", np.eye(3), strict=True) for sign in "+−"}  # fmt: skip
    assert set(named) == {name for name, d in axes.items() if p.covers(d)}
    shape = (height, width) if p.faces == 1 else p.shape(height)
    for name, text in named.items():
        x, y, *face = p.directions_to_pixels(axes[name], shape)
        x += sum(face) * (shape[-1] + 4)
        # Printed to a tenth; moved inside from an edge by 9 pixels, and 4 down to a base line.
        assert abs(float(text.get("x", "")) - x) < 9.1
        assert abs(float(text.get("y", "")) - 4 - y) < 7.1


def test_the_picture_shows_what_the_map_covers():
    page = sm.projection("matcap")._repr_html_()
    data = base64.b64decode(re.findall(r"base64,([^\"]+)", page)[0])
    alpha = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)[..., 3]
    assert np.array_equal(alpha == 255, sm.covers(sm.directions("matcap", alpha.shape), "matcap"))
    assert set(np.unique(alpha)) == {0, 255}


@each(PARAMETERS[::12])
def test_maps_of_all_parameters_draw_themselves(case):
    ElementTree.fromstring(case.make(axes="-x -y -z")._repr_html_())


@pytest.mark.parametrize("latitude", [1e-9, 1e-3])
def test_a_map_that_is_all_but_a_line_has_no_picture(latitude):
    p = sm.projection("mercator", latitude=latitude)
    root = ElementTree.fromstring(p._repr_html_())
    assert [child.tag for child in root] == ["div", "div"] and root[0].text == repr(p)


def test_lights_are_where_they_are():
    lights = sm.light.Lights(
        np.array([[0, 0, -1.0], [1, 0, 0]]), np.array([[4.0, 1, 0], [0, 0, 1]]), np.ones(2)
    )
    root = ElementTree.fromstring(lights._repr_html_())
    space = "{http://www.w3.org/2000/svg}"
    width, height = (int(root[0].get(key, "")) for key in ("width", "height"))
    dots = {
        c.get("fill"): (float(c.get("cx", "")), float(c.get("cy", "")), float(c.get("r", "")))
        for c in root[0].findall(f"{space}circle")
    }
    # The red one is straight ahead, twice as wide above the least; the blue one is at the right.
    assert set(dots) == {"#ff8800", "#0000ff"}
    assert dots["#ff8800"] == (width / 2, height / 2, 9.0)
    assert dots["#0000ff"] == (width * 3 / 4, height / 2, 5.5)
    for other in (shown()["Sun"], sm.light.Lights(*(np.empty(s) for s in ((0, 3), (0, 3), 0)))):
        ElementTree.fromstring(other._repr_html_())


TABLES = {
    "conventions": sm.conventions,
    "of a kind": lambda: sm.conventions("cube"),
    "of a program": lambda: sm.conventions("ffmpeg"),
    "harmonics": sm.sh.conventions,
}


@pytest.mark.parametrize("rows", [make() for make in TABLES.values()], ids=list(TABLES))
def test_conventions_are_a_list_that_prints_as_a_table(rows):
    plain = [dict(row) for row in rows]
    assert isinstance(rows, list) and rows == plain and plain == rows
    assert json.loads(json.dumps(rows)) == json.loads(json.dumps(plain))
    for again in (pickle.loads(pickle.dumps(rows)), copy.deepcopy(rows)):
        assert again == plain and repr(again) == repr(rows)
    assert type(rows[1:]) is list and rows[1:] == plain[1:] and [*rows] == plain
    head, *lines = repr(rows).splitlines()
    assert head.startswith("name  ") and len(lines) == len(rows)
    for row, text in zip(rows, lines, strict=True):
        assert text.startswith(f"{row['kind']}:{row['name']}" if "kind" in row else row["name"])
        assert text == text.rstrip()
    table = ElementTree.fromstring(rows._repr_html_())
    assert len(table[1]) == len(rows)


def test_a_list_of_conventions_may_hold_anything():
    rows = sm.conventions("cube")
    rows.append({"kind": "cube", "name": "mine<b>"})
    assert repr(rows).splitlines()[-1].startswith("cube:mine<b>")
    assert "cube:mine&lt;b&gt;" in rows._repr_html_()
    rows.append("no row")
    assert repr(rows) == repr(list(rows)) and "&lt;b&gt;" in rows._repr_html_()
    rows.clear()
    assert repr(rows) == "[]"


def test_packings_are_a_tuple_that_prints_as_a_table():
    names = sm.packing.packings()
    assert isinstance(names, tuple) and names == tuple(names) and hash(names) == hash(tuple(names))
    assert pickle.loads(pickle.dumps(names)) == names
    lines = repr(names).splitlines()
    assert len(lines) < 40 < len(names)
    assert lines[0].startswith("family ") and lines[1].startswith("oct ")
    assert re.search(r"8 to 64 +oct8 \.\.\. oct64 \(29\) +oct8x2, oct16x2, oct32x2$", lines[1])
    assert len(ElementTree.fromstring(names._repr_html_())[1]) == len(lines) - 1
    few = repr(sm.packing.packings(family="oct", bits=16))
    for name in sm.packing.packings(family="oct", bits=16):
        assert re.search(rf"\b{name}\b(?!-)", few)
    assert repr(sm.packing.packings(bits=99)) == "()"


def test_a_projection_says_how_to_make_it_again():
    p = sm.projection("angular:openimageio").turned(sm.rotation(10, 20, 30))
    assert eval(repr(p), vars(sm)) == p
