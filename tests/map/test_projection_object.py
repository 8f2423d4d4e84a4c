"""The Projection object: frozen, hashable, equal, picklable, printable, explained."""

from __future__ import annotations

import copy
import pickle
import re
from functools import cache

import numpy as np
import pytest
import spheremap as sm
from conftest import CASES, DEFAULTS, LAYOUTS, Case, each, random_directions

ATTRIBUTES = (
    "name",
    "convention",
    "axes",
    "grid",
    "layout",
    "faces",
    "parameters",
    "coverage",
    "covered_solid_angle",
    "equal_area",
    "conformal",
    "density_range",
    "title",
    "source",
    "summary",
    "singular",
    "mirrored",
)


@each(CASES)
def test_attributes_have_their_types(case):
    p = case.make()
    assert isinstance(p, sm.Projection)
    types = {
        "name": str,
        "axes": str,
        "grid": str,
        "faces": int,
        "parameters": dict,
        "coverage": str,
        "covered_solid_angle": float,
        "equal_area": bool,
        "conformal": bool,
        "density_range": tuple,
        "title": str,
        "source": str,
        "summary": str,
        "singular": str,
        "mirrored": bool,
    }
    for name, kind in types.items():
        assert isinstance(getattr(p, name), kind), name
    assert p.layout is None or isinstance(p.layout, str)
    assert p.convention is None or isinstance(p.convention, str)
    assert p.grid in ("centers", "corners", "corners-v")
    assert p.coverage in ("sphere", "hemisphere", "cap", "part")
    assert re.fullmatch(r"[+-][xyz] [+-][xyz] [+-][xyz]", p.axes)
    assert all(isinstance(v, float) for v in p.parameters.values())


@each(DEFAULTS)
def test_frozen(case):
    p = case.make()
    for name in ATTRIBUTES:
        with pytest.raises((AttributeError, TypeError)):
            setattr(p, name, getattr(p, name))
        with pytest.raises((AttributeError, TypeError)):
            delattr(p, name)
    with pytest.raises((AttributeError, TypeError)):
        p.something_new = 1
    p.parameters["fov"] = 1.0  # a copy: changing it changes nothing
    assert p == case.make() and p.parameters == case.make().parameters


@cache
def every_case() -> list[tuple[Case, sm.Projection]]:
    return [(c, c.make()) for c in CASES]


@each(CASES)
def test_equality_and_hash(case):
    p, q = case.make(), case.make()
    assert p == q and hash(p) == hash(q) and (p != q) is False
    assert len({p, q}) == 1
    for c, other in every_case():
        if c != case and p == other:
            # Two ways to say the same thing must hash alike and act alike.
            assert hash(p) == hash(other)
            d = random_directions(50, 150)
            assert np.array_equal(p.encode(d), other.encode(d), equal_nan=True)
    assert p != p.name and p is not None and p != 3
    assert {p: 1}[q] == 1


def test_different_things_are_different():
    base = sm.projection("angular")
    for options in ({"fov": 180}, {"axes": "+x +y +z"}, {"grid": "corners"}):
        assert base != sm.projection("angular", **options)
    assert sm.projection("cube") != sm.projection("cube", layout="cross")
    assert sm.projection("angular", fov=360) == base


@each(CASES)
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_pickle(case, protocol):
    p = case.make()
    q = pickle.loads(pickle.dumps(p, protocol))
    assert q == p and hash(q) == hash(p) and repr(q) == repr(p)
    for name in ATTRIBUTES:
        assert getattr(q, name) == getattr(p, name), name


@each(CASES)
def test_copy(case):
    p = case.make()
    assert copy.copy(p) == p and copy.deepcopy(p) == p


@each(CASES)
def test_repr_makes_it_again(case):
    p = case.make()
    text = repr(p)
    assert text.startswith(f'projection("{p.name}"') and text.endswith(")")
    again = eval(text, {"projection": sm.projection})
    assert again == p
    if p.convention:
        assert f'convention="{p.convention}"' in text


def test_repr_of_a_default_and_of_parameters():
    assert repr(sm.projection("latlong")) == 'projection("latlong")'
    p = sm.projection("latlong", convention="mitsuba")
    assert repr(p) == 'projection("latlong", convention="mitsuba")'


def test_the_class_is_not_what_makes_them():
    for given, said in (((), "latlong"), (("angular",), "angular"), ((3,), "latlong")):
        with pytest.raises(TypeError, match=rf'sm\.projection\("{said}"\)'):
            sm.Projection(*given, fov=180)
    p = sm.projection("angular", fov=180)
    made = (p, p.turned(sm.rotation(10, 0, 0)), p.in_world_of("latlong:blender"), copy.copy(p))
    assert {type(q) for q in (*made, pickle.loads(pickle.dumps(p)))} == {sm.Projection}


@each(CASES)
def test_explain(case, capsys):
    p = case.make()
    text = p.explanation()
    assert p.explain() is None
    assert capsys.readouterr().out.rstrip("\n") == text.rstrip("\n")
    right, down, forward = p.axes.split()
    assert p.name in text and p.grid in text
    assert re.search(
        rf"{re.escape(right)} right.*{re.escape(down)} down.*{re.escape(forward)} for", text
    )
    for axis in ("+x", "-x", "+y", "-y", "+z", "-z"):
        assert axis in text
    assert ("mirrored" in text) or not p.mirrored
    assert re.search(r"up", text) and re.search(r"coverage|covers", text, re.I)
    assert re.search(r"density", text, re.I)


@each(LAYOUTS)
def test_explanation_puts_the_axes_where_encode_does(case):
    p = case.make()
    text = p.explanation()
    axes = dict(zip(["+x", "+y", "+z"], np.eye(3), strict=True))
    axes |= dict(zip(["-x", "-y", "-z"], -np.eye(3), strict=True))
    lines = text.splitlines()
    found = 0
    for name, d in axes.items():
        uv = p.encode(d)
        if np.isnan(uv).any():
            continue
        # The numbers after the axis' name; a layout's face may be named, too.
        for line in lines:
            _, at, after = line.partition(name)
            numbers = [float(x) for x in re.findall(r"(?<![\w.+-])\d+\.?\d*", after)]
            # Printed to four decimals; three tell the axes' places from each other.
            near = all(any(abs(x - n) < 6e-4 for n in numbers) for x in uv.tolist())
            if at and near and not line.startswith("axes"):
                found += 1
                break
    covered = sum(not np.isnan(p.encode(d)).any() for d in axes.values())
    assert found == covered, text


def test_free_explain(capsys):
    sm.explain("latlong:mitsuba")
    out = capsys.readouterr().out
    assert out.rstrip("\n") == sm.projection("latlong", convention="mitsuba").explanation().rstrip(
        "\n"
    )


def test_free_functions_equal_methods():
    p = sm.projection("angular", fov=200)
    d = random_directions(100, 151)
    uv = p.encode(d)
    ok = ~np.isnan(uv[:, 0])
    pairs = [
        (sm.encode(d, p), uv),
        (sm.decode(uv, p), p.decode(uv)),
        (sm.jacobian(uv[ok], p), p.jacobian(uv[ok])),
        (sm.density(uv, p), p.density(uv)),
        (sm.valid(uv, p), p.valid(uv)),
        (sm.covers(d, p), p.covers(d)),
        (sm.solid_angle(p, 9), p.solid_angle(9)),
        (sm.directions(p, 9), p.directions(9)),
    ]
    for got, want in pairs:
        assert got.dtype == want.dtype and np.array_equal(got, want, equal_nan=True)


def test_projection_is_not_made_by_hand():
    assert sm.projection(sm.projections()[0]).name == sm.projections()[0]
    with pytest.raises(TypeError):
        sm.projection()
    with pytest.raises(TypeError):
        sm.projection(3)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("LATLONG", "unknown projection 'LATLONG'; did you mean 'latlong'?"),
        ("Cube:blender", "unknown projection 'Cube'; did you mean 'cube'?"),
        ("ANGULAR(fov=20)", "unknown projection 'ANGULAR'; did you mean 'angular'?"),
        ("eac", "unknown projection 'eac'; here it is 'cube_equiangular'"),
    ],
)
def test_an_unknown_name_is_one_error(name, says):
    for call in (lambda: sm.projection(name), lambda: sm.encode([0, 0, 1], name)):
        with pytest.raises(ValueError, match=f"^{re.escape(says)}") as caught:
            call()
        assert caught.value.__context__ is None


def test_a_filter_is_a_word():
    image = np.zeros((8, 16))
    for call in (
        lambda: sm.convert(image, "latlong", "cube", filter=1),
        lambda: sm.sample(image, [0, 0, 1], "latlong", filter=1),
    ):
        with pytest.raises(TypeError, match="`filter` to be a str, got int"):
            call()
