"""The table of conventions: every row can be made, and each program's formula lands the same."""

from __future__ import annotations

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import NAMES, random_directions
from spheremap import _core

TABLE = _core.convention_table()
each_row = pytest.mark.parametrize("row", TABLE, ids=[f"{r['kind']}:{r['name']}" for r in TABLE])
D = random_directions(3000, 60)
X, Y, Z = D.T
TOWARD_MINUS_Z = np.array([0, 0, -1])
TOWARD_MINUS_Y = np.array([0, -1, 0])
PI = np.pi


def acos(x):
    return np.arccos(np.clip(x, -1, 1))


# Each program's formula in its own letters, (u, v) with v from the top.
LATLONG = {
    "mitsuba": (np.arctan2(X, -Z) / (2 * PI) % 1, acos(Y) / PI),
    "openimageio": (
        np.arctan2(-X, Z) / (2 * PI) + 0.5,
        0.5 - np.arctan2(Y, np.hypot(Z, X)) / PI,
    ),
    "openimageio-sampleborder": (
        np.arctan2(-X, Z) / (2 * PI) + 0.5,
        0.5 - np.arctan2(Y, np.hypot(Z, X)) / PI,
    ),
    "openimageio-z-up": (
        np.arctan2(Y, X) / (2 * PI) + 0.5,
        0.5 - np.arctan2(Z, np.hypot(X, Y)) / PI,
    ),
    "openexr": (0.5 - np.arctan2(X, Z) / (2 * PI), 0.5 - np.arcsin(Y) / PI),
    "pbrt": (np.arctan2(Y, X) / (2 * PI) % 1, acos(Z) / PI),
    "blender": (0.5 - np.arctan2(Y, X) / (2 * PI), acos(Z) / PI),
    "threejs": (np.arctan2(Z, X) / (2 * PI) + 0.5, 0.5 - np.arcsin(Y) / PI),
    "gltf": (np.arctan2(Z, X) / (2 * PI) + 0.5, 0.5 - np.arcsin(Y) / PI),
    "nvdiffrec": (np.arctan2(X, -Z) / (2 * PI) + 0.5, acos(Y) / PI),
    "skylibs": (np.arctan2(X, -Z) / (2 * PI) + 0.5, acos(Y) / PI),
    "ict": (np.arctan2(X, -Z) / (2 * PI) + 0.5, acos(Y) / PI),
    "filament": (np.arctan2(X, Z) / (2 * PI) + 0.5, 0.5 - np.arcsin(Y) / PI),
    "cmft": (np.arctan2(X, Z) / (2 * PI) + 0.5, acos(Y) / PI),
    "bimg": (np.arctan2(X, Z) / (2 * PI) + 0.5, acos(Y) / PI),
    "py360convert": (np.arctan2(X, Z) / (2 * PI) + 0.5, 0.5 - np.arcsin(Y) / PI),
    "ffmpeg": (np.arctan2(X, Z) / (2 * PI) + 0.5, 0.5 + np.arcsin(Y) / PI),
}
# pbrt, v4: azimuth runs from +x, its u = 0 is the row's first texel.
GRIDS = {
    "mitsuba": "corners-v",
    "openimageio": "centers",
    "openimageio-sampleborder": "corners",
    "openexr": "corners",
    "pbrt": "centers",
    "blender": "centers",
    "threejs": "centers",
    "gltf": "centers",
    "nvdiffrec": "centers",
    "skylibs": "centers",
    "filament": "corners",
    "cmft": "centers",
    "bimg": "corners",
    "py360convert": "centers",
    "ffmpeg": "corners",
}
AXES = {
    "mitsuba": "-x -y +z",
    "openimageio": "-x -y +z",
    "openimageio-sampleborder": "-x -y +z",
    "openimageio-z-up": "+y -z +x",
    "openexr": "-x -y +z",
    "pbrt": "-y -z -x",
    "blender": "-y -z +x",
    "threejs": "+z -y +x",
    "gltf": "+z -y +x",
    "nvdiffrec": "+x -y -z",
    "skylibs": "+x -y -z",
    "filament": "+x -y +z",
    "cmft": "+x -y +z",
    "bimg": "+x -y +z",
    "py360convert": "+x -y +z",
    "ffmpeg": "+x +y +z",
}


def ball(n: np.ndarray, u: int, v: int, su: float, sv: float) -> tuple[np.ndarray, np.ndarray]:
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    return su * n[:, u] / 2 + 0.5, sv * n[:, v] / 2 + 0.5


M = 2 * np.sqrt(X**2 + Y**2 + (Z + 1) ** 2)
SPHERE = {
    "opengl": (X / M + 0.5, 1 - (Y / M + 0.5)),
    "d3d": ball(D + TOWARD_MINUS_Z, 0, 1, 1, -1),
    "directxtk": (X / M + 0.5, Y / M + 0.5),
    "skylibs": (
        0.5 + X * np.sin(0.5 * acos(-Z)) / (2 * np.hypot(X, Y)),
        0.5 - Y * np.sin(0.5 * acos(-Z)) / (2 * np.hypot(X, Y)),
    ),
    # Blender's ball: d = 2(n·I)n - I with I = (0, -1, 0) gives n along d + I.
    "blender": ball(D + TOWARD_MINUS_Y, 0, 2, 1, -1),
}
R_DEBEVEC = acos(-Z) / (2 * PI * np.hypot(X, Y))
R_SECOND = acos(Z) / (2 * PI * np.hypot(X, Y))
ANGULAR = {
    "debevec": (0.5 + X * R_DEBEVEC, 0.5 - Y * R_DEBEVEC),
    "skylibs": (0.5 + X * R_DEBEVEC, 0.5 - Y * R_DEBEVEC),
    "openimageio": (0.5 + X * R_SECOND, 0.5 - Y * R_SECOND),
}
LITERAL = {"latlong": LATLONG, "sphere": SPHERE, "angular": ANGULAR}


@each_row
def test_row_is_complete_and_can_be_made(row):
    assert row["kind"] in NAMES
    assert {"kind", "name", "axes", "grid", "layout", "parameters", "note", "source"} <= set(row)
    assert {"version", "verified"} <= set(row) and isinstance(row["verified"], bool)
    assert row["source"]
    p = sm.projection(row["kind"], convention=row["name"])
    assert p.convention == row["name"] and p.name == row["kind"]
    assert p.axes == row["axes"] and p.grid == row["grid"]
    if row["layout"] is not None:
        assert p.layout == row["layout"]
    for key, value in row["parameters"].items():
        assert p.parameters[key] == value
    # A keyword on top of a convention wins.
    assert sm.projection(row["kind"], convention=row["name"], axes="+y +z +x").axes == "+y +z +x"


def test_rows_are_unique_and_listed():
    keys = [(row["kind"], row["name"]) for row in TABLE]
    assert len(set(keys)) == len(keys)
    assert [(r["kind"], r["name"]) for r in sm.conventions()] == keys
    for kind in NAMES:
        of_kind = [r["name"] for r in sm.conventions(kind)]
        assert of_kind == [name for k, name in keys if k == kind]
        entry = next(e for e in _core.registry() if e["name"] == kind)
        assert list(entry["conventions"]) == of_kind


@pytest.mark.parametrize(
    "qualified",
    [
        "sphere:opengl",
        "sphere:d3d",
        "sphere:skylibs",
        "cube:opengl",
        "cube:d3d",
        "cube:vulkan",
        "angular:debevec",
        "angular:skylibs",
        "angular:openimageio",
        "latlong:mitsuba",
        "latlong:openimageio",
        "latlong:skylibs",
        "latlong:blender",
    ],
)
def test_conventions_that_the_contract_names(qualified):
    kind, name = qualified.split(":")
    assert (kind, name) in {(row["kind"], row["name"]) for row in TABLE}


@each_row
def test_literal_formula_of_the_program(row):
    table = LITERAL.get(row["kind"], {})
    if row["name"] not in table:
        pytest.skip("no formula of this program is written here: its axes are tested")
    u, v = table[row["name"]]
    uv = sm.projection(row["kind"], convention=row["name"]).encode(D)
    du = np.abs(uv[:, 0] - u)
    if row["kind"] == "latlong":
        du = np.minimum(du, 1 - du)  # the seam, where 0 is 1
    # acos and asin lose half the digits near their ends: random directions come within 1e-3.
    assert du.max() < 1e-11 and np.abs(uv[:, 1] - v).max() < 1e-11


@each_row
def test_axes_and_grid_of_the_document(row):
    if row["kind"] != "latlong":
        pytest.skip("only latlong rows differ in grid")
    if row["name"] in AXES:
        assert row["axes"] == AXES[row["name"]]
    if row["name"] in GRIDS:
        assert row["grid"] == GRIDS[row["name"]]


@pytest.mark.parametrize("name", ["opengl", "d3d", "vulkan"])
def test_cube_tables_are_one(name):
    p = sm.projection("cube", convention=name)
    assert p.axes == "+x -y +z" and p.layout == "faces" and p.grid == "centers"
    faces = [np.eye(3)[i // 2] * (1 - 2 * (i % 2)) for i in range(6)]
    centres = p.decode(np.array([[0.5, 0.5, i] for i in range(6)], float))
    assert np.array_equal(centres, np.array(faces))


def test_direct3d_sphere_looks_the_other_way():
    p = sm.projection("sphere", convention="d3d")
    assert np.abs(p.decode(np.array([0.5, 0.5])) - [0, 0, -1]).max() == 0
    assert np.abs(sm.decode(np.array([0.5, 0.5]), "sphere") - [0, 0, 1]).max() == 0


def test_openimageio_probe_is_the_mirrored_reading():
    a = sm.projection("angular", convention="debevec")
    b = sm.projection("angular", convention="openimageio")
    assert a.axes == "+x -y -z" and not a.mirrored
    assert b.axes == "+x -y +z" and b.mirrored


def test_centre_and_up_of_the_defaults():
    eye = {"latlong": [0, 0, -1], "angular": [0, 0, -1], "sphere": [0, 0, 1], "matcap": [0, 0, 1]}
    for name, forward in eye.items():
        p = sm.projection(name)
        assert np.abs(p.decode(np.array([0.5, 0.5])) - forward).max() < 1e-15
        up, right = p.decode(np.array([[0.5, 0.4], [0.6, 0.5]]))
        assert up[1] > 0.1 and right[0] > 0.1


@each_row
def test_reference_agrees_with_the_row(row):
    p = sm.projection(row["kind"], convention=row["name"])
    r = reference.of(p)
    got, want = p.encode(D), r.encode(D)
    assert np.array_equal(np.isnan(got), np.isnan(want))
    ok = ~np.isnan(want[:, 0])
    assert np.abs(got - want)[ok].max() < 4e-15
