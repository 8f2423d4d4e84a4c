"""The drawing of explain: every letter stands where the map says, for every map and convention."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import NAMES, REGISTRY

SINGLE = [f"{r['kind']}:{r['name']}" for r in sm.conventions() if r["kind"] != "cube"]
CELLS = [f"{r['kind']}:{r['name']}" for r in sm.conventions() if r["kind"] == "cube"]
LAYOUTS = [(e["name"], layout) for e in REGISTRY for layout in e["layouts"]]
AXES = {sign + "xyz"[k]: np.eye(3)[k] * s for k in range(3) for sign, s in (("+", 1), ("-", -1))}


def drawing(p: sm.Projection) -> list[str]:
    head, text = p.explanation().split("o is texel (0, 0):\n\n")
    assert "As it is stored, row 0 at the top" in head
    return text.splitlines()


@pytest.mark.parametrize("name", [*(n for n in NAMES if sm.projection(n).layout is None), *SINGLE])
def test_letters_of_one_face(name):
    p = sm.projection(name)
    if p.layout is not None:
        pytest.skip("several faces")
    lines = drawing(p)
    assert lines[0][0] == "o"
    height, width = len(lines) - 2, len(lines[0]) - 2
    found = dict.fromkeys(AXES, 0)
    for j, line in enumerate(lines[1:-1]):
        for i in range(width - 1):
            label = line[i + 1 : i + 3]
            if label not in AXES:
                continue
            found[label] += 1
            # The letters cover two places: either is near the axis.
            u = (i + np.array([0.5, 1.0, 1.5])) / width
            d = p.decode(np.stack([u, np.full(3, (j + 0.5) / height)], -1))
            assert reference.angle(d[~np.isnan(d[:, 0])], AXES[label]).min() < 0.6, label
    for label, axis in AXES.items():
        assert (found[label] > 0) == bool(p.covers(axis)), label


# The faces of healpix look between the axes: no letter is right for their middles.
ALONG_AXES = [
    (name, layout)
    for name, layout in [*LAYOUTS, *((name, None) for name in CELLS)]
    if name not in ("healpix", "icosahedral")
]


@pytest.mark.parametrize(("name", "layout"), ALONG_AXES)
def test_letters_of_several_faces(name, layout):
    p = sm.projection(name, layout=layout)
    lines = drawing(p)
    rows, columns = (len(lines) - 1) // 4, (max(map(len, lines)) - 1) // 12
    lines = [line.ljust(12 * columns + 1) for line in lines]
    seen = 0
    for row in range(rows):
        for column in range(columns):
            top, left = 4 * row, 12 * column
            label = lines[top + 2][left + 5 : left + 7]
            places = np.array([[0.5, 0.5], [0.98, 0.5], [0.5, 0.98]])
            if p.faces > 1:
                uv = np.hstack([places, np.full((3, 1), column)])
            else:
                uv = (places + np.array([column, row])) / np.array([columns, rows])
            d = p.decode(uv)
            if label not in AXES:
                assert np.isnan(d).all()
                continue
            seen += 1
            middle, right, below = d
            assert reference.angle(middle, AXES[label]) < 1e-6
            assert (right - middle) @ AXES[lines[top + 2][left + 10 : left + 12]] > 0.5
            assert (below - middle) @ AXES[lines[top + 3][left + 5 : left + 7]] > 0.5
    assert seen == next(e["faces"] for e in REGISTRY if e["name"] == p.name)


def test_the_panorama_that_the_documents_show():
    lines = drawing(sm.projection("latlong:blender"))
    assert lines[1].startswith("|+z ") and lines[-2].startswith("|-z ")
    assert "".join(lines[6].split()) == "|-x+y+x-y-x|"


def test_a_convention_says_where_it_comes_from():
    text = sm.projection("latlong:unity").explanation()
    assert "left-handed" in text and "read from source" in text and "Skybox/Panoramic" in text
    text = sm.projection("latlong:mitsuba").explanation()
    assert "run against mitsuba" in text and "right-handed" in text
    assert "known from" not in sm.projection("latlong").explanation()
