"""The table of conventions: every row can be made, and each program's formula lands the same."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from importlib.metadata import version as installed
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import NAMES, random_directions
from oracles import ffmpeg_oracle
from spheremap import _core

TABLE = _core.convention_table()


def each(wanted: Callable[[dict[str, Any]], bool]) -> pytest.MarkDecorator:
    rows = [row for row in TABLE if wanted(row)]
    return pytest.mark.parametrize("row", rows, ids=[f"{r['kind']}:{r['name']}" for r in rows])


each_row = each(lambda row: True)
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
    "ffmpeg-output": (np.arctan2(X, Z) / (2 * PI) + 0.5, 0.5 + np.arcsin(Y) / PI),
    "equilib": ((np.arctan2(Y, X) / (2 * PI) - 0.5) % 1, 0.5 - np.arcsin(Z) / PI),
    # Texture coordinates (0.5, 1) - (longitude, latitude), t up.
    "unity": (0.5 - np.arctan2(Z, X) / (2 * PI), 1 - (1 - acos(Y) / PI)),
    # Looked up with y and z exchanged: atan2(d.x, -d.z) of (x, z, y).
    "unreal": ((1 + np.arctan2(X, -Y) / PI) / 2, acos(Z) / PI),
    # Storm's ProjectToLatLong; the texture repeats.
    "usd": ((np.arctan2(Z, X) + PI / 2) / (2 * PI) % 1, acos(Y) / PI),
    # OpenEXR's longitude and latitude of a dome whose +y went to +z, and whose +z to -y.
    "usd-z-up": (0.5 - np.arctan2(X, -Y) / (2 * PI), 0.5 - np.arcsin(Z) / PI),
    "godot": (np.arctan2(X, -Z) / (2 * PI) % 1, acos(Y) / PI),
    # Its corners of faces are (z, -y, x) of the world; rows are counted from the last.
    "babylonjs": (np.arctan2(X, Z) / PI * 0.5 + 0.5, 1 - acos(-Y) / PI),
    # dir * (-1, 1, 1), then toSphericalUv.
    "playcanvas": (np.arctan2(-X, Z) / (2 * PI) + 0.5, 1 - (np.arcsin(Y) / PI + 0.5)),
    "healpy": (0.5 - np.arctan2(Y, X) / (2 * PI), 0.5 - np.arcsin(Z) / PI),
    # v = (sin theta sin phi, cos theta, sin theta cos phi), with theta = pi/2 - y/distance.
    "hugin": (0.5 + np.arctan2(X, Z) / (2 * PI), 0.5 + (PI / 2 - acos(Y)) / PI),
    "colmap": (np.arctan2(X, Z) / (2 * PI) + 0.5, np.arctan2(Y, np.hypot(X, Z)) / PI + 0.5),
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
    "ffmpeg-output": "centers",
    "equilib": "centers",
    "unity": "centers",
    "unreal": "centers",
    "usd": "centers",
    "usd-z-up": "centers",
    "godot": "centers",
    "babylonjs": "centers",
    "playcanvas": "centers",
    "hugin": "centers",
    "colmap": "centers",
    "healpy": "corners",
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
    "usd": "-x -y +z",
    "usd-z-up": "-x -z -y",
    "godot": "-x -y +z",
    "babylonjs": "+x -y +z",
    "playcanvas": "-x -y +z",
    "hugin": "+x +y +z",
    "colmap": "+x +y +z",
    "healpy": "-y -z +x",
}


def zenith_up(x, y, z):
    """Give skylibs' sky: azimuth from +z, distance from the zenith."""
    r = np.arctan2(np.hypot(x, z), y) / (PI / 2)
    azimuth = np.arctan2(x, z)
    u, v = 0.5 + r * np.sin(azimuth) / 2, 0.5 - r * np.cos(azimuth) / 2
    return np.where(r <= 1, u, np.nan), np.where(r <= 1, v, np.nan)


def fisheye(x, y, z):
    """Give Panorama Tools' fisheye of 180 degrees, theta * distance from the middle, y down."""
    theta = np.arctan2(np.hypot(x, y), z)
    r = np.where(theta <= PI / 2, theta / PI, np.nan) / np.hypot(x, y)
    return 0.5 + r * x, 0.5 + r * y


def octahedron(x, y, z, keep):
    """Fold a point of the octahedron with z as its pole where `keep` is false."""
    n = np.abs(x) + np.abs(y) + np.abs(z)
    p, q = x / n, y / n
    a, b = (1 - np.abs(q)) * np.where(p >= 0, 1, -1), (1 - np.abs(p)) * np.where(q >= 0, 1, -1)
    return np.where(keep, p, a) / 2 + 0.5, np.where(keep, q, b) / 2 + 0.5


def draco(x, y, z):
    """Give (s, t) of Draco's tool box on a grid from 0 to 1: the right half has x >= 0."""
    n = np.abs(x) + np.abs(y) + np.abs(z)
    x, y, z = x / n, y / n, z / n
    s = np.where(x >= 0, (1 + y) / 2, np.where(y < 0, np.abs(z) / 2, 1 - np.abs(z) / 2))
    t = np.where(x >= 0, (1 + z) / 2, np.where(z < 0, np.abs(y) / 2, 1 - np.abs(y) / 2))
    return s, t


def hemisphere(x, y, z):
    n = np.abs(x) + np.abs(y) + np.abs(z)
    u, v = (x + y) / n / 2 + 0.5, (x - y) / n / 2 + 0.5
    return np.where(z >= 0, u, np.nan), np.where(z >= 0, v, np.nan)


OCTAHEDRAL = {
    "unreal": octahedron(X, Y, Z, Z > 0),
    "meshoptimizer": octahedron(X, Y, Z, Z >= 0),
    "draco": draco(X, Y, Z),
}
HEMIOCTAHEDRAL = {"unreal": hemisphere(X, Y, Z)}
DUAL = {"directxtk": (X / (2 * (1 + np.abs(Z))) + 0.5, Y / (2 * (1 + np.abs(Z))) + 0.5)}


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
    # ffmpeg's ball, y down: d = (2√(1 - l²) x, 2√(1 - l²) y, 1 - 2l²).
    "ffmpeg": (
        0.5 + X * np.sqrt((1 - Z) / 2) / np.hypot(X, Y) / 2,
        0.5 + Y * np.sqrt((1 - Z) / 2) / np.hypot(X, Y) / 2,
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
    "skylibs-skyangular": zenith_up(X, Y, Z),
    "hugin": fisheye(X, Y, Z),
}


def pbrt_square(x, y, z):
    """pbrt-v4's EqualAreaSphereToSquare with a true arctangent."""
    r = np.sqrt(1 - np.abs(z))
    b = np.arctan2(np.abs(y), np.abs(x)) * 2 / np.pi * r
    a = r - b
    a, b = np.where(z < 0, 1 - b, a), np.where(z < 0, 1 - a, b)
    return (np.copysign(a, x) + 1) / 2, (np.copysign(b, y) + 1) / 2


def mollview(x, y, z):
    """Longitude to the left; 2 theta + sin 2 theta = pi sin latitude, by halving."""
    low, high = np.full(len(z), -PI / 2), np.full(len(z), PI / 2)
    for _ in range(60):
        theta = (low + high) / 2
        above = 2 * theta + np.sin(2 * theta) > PI * z
        low, high = np.where(above, low, theta), np.where(above, theta, high)
    theta = (low + high) / 2
    return 0.5 - np.arctan2(y, x) / (2 * PI) * np.cos(theta), 0.5 - np.sin(theta) / 2


LITERAL = {
    "mollweide": {"healpy": mollview(X, Y, Z)},
    "healpix": {"healpy": reference.make("healpix").encode(D)[:, :2].T},
    "equal_area": {"pbrt": pbrt_square(X, Y, Z)},
    "latlong": LATLONG,
    "sphere": SPHERE,
    "angular": ANGULAR,
    "octahedral": OCTAHEDRAL,
    "hemioctahedral": HEMIOCTAHEDRAL,
    "dual_paraboloid": DUAL,
}


@each_row
def test_row_is_complete_and_can_be_made(row):
    assert row["kind"] in NAMES
    assert {"kind", "name", "axes", "grid", "layout", "parameters", "note", "source"} <= set(row)
    assert row["source"] and row["version"] and row["note"]
    assert row["verified"] in ("read from source", f"run against {row['version']}")
    assert row["up"][0] in "+-" and row["up"][1] in "xyz" and isinstance(row["left_handed"], bool)
    p = sm.projection(row["kind"], convention=row["name"])
    assert p.convention == row["name"] and p.name == row["kind"]
    assert p.axes == row["axes"] and p.grid == row["grid"]
    if row["layout"] is not None:
        assert p.layout == row["layout"]
    for key, value in row["parameters"].items():
        assert p.parameters[key] == value
    assert pickle.loads(pickle.dumps(p)) == p and eval(f"sm.{repr(p).lower()}") == p
    # A keyword on top of a convention wins.
    assert sm.projection(row["kind"], convention=row["name"], axes="+y +z +x").axes == "+y +z +x"


def test_rows_that_were_run_name_a_version_that_an_oracle_runs():
    folder = Path(__file__).parents[1] / "oracles"
    tests = "".join(path.read_text(encoding="utf-8") for path in folder.glob("*.py"))
    for row in TABLE:
        program = row["version"].split()[0]
        if row["verified"] == "read from source":
            continue
        name = re.escape(row["name"].split("-")[0])
        assert re.search(rf"{row['kind']}:{name}|{name}_oracle", tests), row["name"]
        assert program.lower() in tests.lower(), program


@pytest.mark.parametrize("program", ["skylibs", "py360convert", "meshoptimizer"])
def test_pinned_programs_are_in_the_version_that_their_rows_name(program):
    versions = {row["version"] for row in TABLE if row["version"].split()[0] == program}
    assert versions == {f"{program} {installed(program)}"}


def test_ffmpeg_is_in_the_version_that_its_rows_name():
    versions = {row["version"] for row in TABLE if row["name"].startswith("ffmpeg")}
    assert versions == {ffmpeg_oracle.version()}


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
def test_well_known_conventions(qualified):
    kind, name = qualified.split(":")
    assert (kind, name) in {(row["kind"], row["name"]) for row in TABLE}


# For cubes see test_faces_of_the_program and test_oracle_atlas; ffmpeg's views are run, texel by
# texel, in test_oracle_ffmpeg, which says that none is left out.
@each(
    lambda row: (
        row["kind"] not in reference.CUBES
        and (row["name"] != "ffmpeg" or row["name"] in LITERAL.get(row["kind"], ()))
    )
)
def test_literal_formula_of_the_program(row):
    u, v = LITERAL[row["kind"]][row["name"]]
    uv = sm.projection(row["kind"], convention=row["name"]).encode(D)
    assert np.array_equal(np.isnan(uv[:, 0]), np.isnan(u))
    uv, u, v = uv[~np.isnan(u)], u[~np.isnan(u)], v[~np.isnan(u)]
    du = np.abs(uv[:, 0] - u)
    if row["kind"] == "latlong":
        du = np.minimum(du, 1 - du)  # the seam, where 0 is 1
    # acos and asin lose half the digits near their ends: random directions come within 1e-3.
    assert du.max() < 1e-11 and np.abs(uv[:, 1] - v).max() < 1e-11


@each(lambda row: row["kind"] == "latlong")
def test_axes_and_grid_of_programs(row):
    if row["name"] in AXES:
        assert row["axes"] == AXES[row["name"]]
    if row["name"] in GRIDS:
        assert row["grid"] == GRIDS[row["name"]]


# Each stored face: what its center, its right edge and its lower edge look toward, in the world.
GL_FACES = (
    ("+x", "-z", "-y"),
    ("-x", "+z", "-y"),
    ("+y", "+x", "+z"),
    ("-y", "+x", "-z"),
    ("+z", "+x", "-y"),
    ("-z", "-x", "-y"),
)
# F R B L U D of a viewer who looks along +z with +x to the right and +y up.
PY360_FACES = (
    ("+z", "+x", "-y"),
    ("+x", "-z", "-y"),
    ("-z", "-x", "-y"),
    ("-x", "+z", "-y"),
    ("+y", "+x", "+z"),
    ("-y", "+x", "-z"),
)
# The same with F toward +x, +y to the right and +z up.
EQUILIB_FACES = (
    ("+x", "+y", "-z"),
    ("+y", "-x", "-z"),
    ("-x", "-y", "-z"),
    ("-y", "+x", "-z"),
    ("+z", "+y", "+x"),
    ("-z", "+y", "-x"),
)
# Right, left, up, down, front, back of a viewer along +z with +x right and +y down.
FFMPEG_FACES = (
    ("+x", "-z", "+y"),
    ("-x", "+z", "+y"),
    ("-y", "+x", "+z"),
    ("+y", "+x", "-z"),
    ("+z", "+x", "+y"),
    ("-z", "-x", "+y"),
)
OPENEXR_FACES = (
    ("+x", "+z", "-y"),
    ("-x", "-z", "-y"),
    ("+y", "+x", "-z"),
    ("-y", "+x", "+z"),
    ("+z", "-x", "-y"),
    ("-z", "+x", "-y"),
)
# What the px image shows lies toward -x, and so on: x is negated before the look-up.
THREE_FACES = (
    ("-x", "-z", "-y"),
    ("+x", "+z", "-y"),
    ("+y", "-x", "+z"),
    ("-y", "-x", "-z"),
    ("+z", "-x", "-y"),
    ("-z", "+x", "-y"),
)

# The hardware's table looked up with (x, y, -z).
BEVY_FACES = (
    ("+x", "+z", "-y"),
    ("-x", "-z", "-y"),
    ("+y", "+x", "-z"),
    ("-y", "+x", "+z"),
    ("-z", "+x", "-y"),
    ("+z", "-x", "-y"),
)


def cells(*rows: str) -> dict[str, tuple[int, int]]:
    """Where each digit or letter stands in a picture made of words."""
    return {mark: (i, j) for j, row in enumerate(rows) for i, mark in enumerate(row) if mark != "."}


STRIP, COLUMN = cells("012345"), cells(*"012345")
CROSS = cells(".2..", "1405", ".3..")
PANORAMA = cells(".4..", "3012", ".5..")
# (faces, where each lies: None for a stack; the faces that lie turned by half a turn)
CUBES = {
    **dict.fromkeys(["opengl", "d3d", "vulkan", "nvdiffrast", "cmft", "bimg"], (GL_FACES, None)),
    **dict.fromkeys(["unity", "unreal", "ktx", "babylonjs"], (GL_FACES, None)),
    **dict.fromkeys(["threejs", "playcanvas"], (THREE_FACES, None)),
    "bevy": (BEVY_FACES, None),
    "openexr": (OPENEXR_FACES, COLUMN),
    "filament": (GL_FACES, CROSS),
    "filament-vertical-cross": (GL_FACES, cells(".2.", "140", ".3.", ".5."), "5"),
    # up; left, forward, right; down; backward, upside down: in OpenEXR's numbers.
    "skylibs": (OPENEXR_FACES, cells(".2.", "150", ".3.", ".4."), "4"),
    "py360convert-horizon": (PY360_FACES, STRIP),
    "py360convert-dice": (PY360_FACES, PANORAMA),
    "py360convert-list": (PY360_FACES, None),
    "equilib-horizon": (EQUILIB_FACES, STRIP),
    "equilib-dice": (EQUILIB_FACES, PANORAMA),
    "equilib-list": (EQUILIB_FACES, None),
    "ffmpeg-c3x2": (FFMPEG_FACES, cells("012", "345")),
    "ffmpeg-c6x1": (FFMPEG_FACES, STRIP),
    "ffmpeg-c1x6": (FFMPEG_FACES, COLUMN),
    "directxtex-h-cross": (GL_FACES, CROSS),
    "directxtex-v-cross": (GL_FACES, cells(".2.", "140", ".3.", ".5.")),
    "directxtex-v-cross-fnz": (GL_FACES, cells(".2.", "140", ".3.", ".5."), "5"),
    "directxtex-h-tee": (GL_FACES, cells("2...", "4051", "3...")),
    "directxtex-h-strip": (GL_FACES, STRIP),
    "directxtex-v-strip": (GL_FACES, COLUMN),
}


def vector(word: str) -> np.ndarray:
    return np.eye(3)["xyz".index(word[1])] * (1 if word[0] == "+" else -1)


@pytest.mark.parametrize("name", [row["name"] for row in sm.conventions("cube")])
def test_faces_of_the_program(name):
    faces, where, *turned = CUBES[name]
    p = sm.projection("cube", convention=name)
    rng = np.random.default_rng(61)
    for number, words in enumerate(faces):
        center, right, down = map(vector, words)
        a, b = rng.random((2, 200))
        want = center + (2 * a - 1)[:, None] * right + (2 * b - 1)[:, None] * down
        want /= np.linalg.norm(want, axis=-1, keepdims=True)
        if str(number) in "".join(turned):
            a, b = 1 - a, 1 - b
        if where is None:
            uv = np.stack([a, b, np.full_like(a, number)], -1)
        else:
            column, row = where[str(number)]
            columns = max(i for i, _ in where.values()) + 1
            rows = max(j for _, j in where.values()) + 1
            uv = np.stack([(column + a) / columns, (row + b) / rows], -1)
        # In a row of six cells uv rounds by ε/2, a face's coordinate by 12 times that: 6 ε of 18.
        assert np.abs(p.decode(uv) - want).max() < 4e-15


@pytest.mark.parametrize("name", ["opengl", "d3d", "vulkan"])
def test_cube_tables_are_one(name):
    p = sm.projection("cube", convention=name)
    assert p.axes == "+x -y +z" and p.layout == "faces" and p.grid == "centers"
    faces = [np.eye(3)[i // 2] * (1 - 2 * (i % 2)) for i in range(6)]
    centers = p.decode(np.array([[0.5, 0.5, i] for i in range(6)], float))
    assert np.array_equal(centers, np.array(faces))


def test_direct3d_sphere_looks_the_other_way():
    p = sm.projection("sphere", convention="d3d")
    assert np.abs(p.decode(np.array([0.5, 0.5])) - [0, 0, -1]).max() == 0
    assert np.abs(sm.decode(np.array([0.5, 0.5]), "sphere") - [0, 0, 1]).max() == 0


def test_openimageio_probe_is_the_mirrored_reading():
    a = sm.projection("angular", convention="debevec")
    b = sm.projection("angular", convention="openimageio")
    assert a.axes == "+x -y -z" and not a.mirrored
    assert b.axes == "+x -y +z" and b.mirrored


def test_center_and_up_of_the_defaults():
    eye = {"latlong": [0, 0, -1], "angular": [0, 0, -1], "sphere": [0, 0, 1], "matcap": [0, 0, 1]}
    for name, forward in eye.items():
        p = sm.projection(name)
        # A sine or a root of zero, and products: the center is exact but for a few ε of 1.
        assert np.abs(p.decode(np.array([0.5, 0.5])) - forward).max() < 1e-15
        up, right = p.decode(np.array([[0.5, 0.4], [0.6, 0.5]]))
        assert up[1] > 0.1 and right[0] > 0.1


@each_row
def test_reference_agrees_with_the_row(row):
    if (row["kind"], row["name"]) in reference.TURNED:
        return  # test_oracle_atlas has faces that lie on their sides
    p = sm.projection(row["kind"], convention=row["name"])
    r = reference.of(p)
    got, want = p.encode(D), r.encode(D)
    assert np.array_equal(np.isnan(got), np.isnan(want))
    ok = ~np.isnan(want[:, 0])
    # Two encoders in float64, each good to 4 ε (test_hard_directions), and as much for cells.
    assert np.abs(got - want)[ok].max() < 4e-15


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("perspective(fov=60)", sm.projection("perspective", fov=60)),
        ("perspective(fov=75, aspect=16/9)", sm.projection("perspective", fov=75, aspect=16 / 9)),
        ("dual_fisheye(fov=200)", sm.projection("dual_fisheye", fov=200)),
        (
            "angular(fov=180):openimageio",
            sm.projection("angular", convention="openimageio", fov=180),
        ),
    ],
)
def test_a_string_says_parameters_as_well(text, same):
    assert sm.projection(text) == same
    assert np.array_equal(sm.encode(D, text), same.encode(D), equal_nan=True)
    image = np.random.default_rng(62).random((16, 32))
    assert np.array_equal(
        sm.convert(image, "latlong", text, size=8), sm.convert(image, "latlong", same, size=8)
    )


def test_rows_of_a_program():
    def names(of: str) -> set[str]:
        return {f"{row['kind']}:{row['name']}" for row in sm.conventions(of)}

    assert names("unity") == names("Unity") == {"cube:unity", "latlong:unity"}
    assert {"cube:ffmpeg-c3x2", "latlong:ffmpeg", "cube_equiangular:ffmpeg-eac"} <= names("ffmpeg")
    assert names("ffmpeg-c3x2") == {"cube:ffmpeg-c3x2"}
    for name, says in (
        ("unitty", "did you mean 'unity'"),
        ("latlon", "did you mean 'latlong'"),
        ("erp", "here it is 'latlong'"),
    ):
        with pytest.raises(ValueError, match=says):
            sm.conventions(name)
