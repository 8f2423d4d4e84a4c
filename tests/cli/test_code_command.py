"""Maps and packings as source text, by the command."""

from __future__ import annotations

from pathlib import Path

import spheremap as sm
from test_cli import bad, good


def test_it_prints_what_the_functions_return(tmp_path: Path) -> None:
    assert good("code", "latlong", "c", "--double", "--verbs", "encode,taps") == sm.code(
        "latlong", "c", verbs=["encode", "taps"], dtype="float64"
    )
    assert good("code", "oct16", "glsl") == sm.packing.code("oct16", "glsl")
    out = tmp_path / "o.h"
    good(
        "code",
        "woct24-unorm",
        "c",
        "--rounding",
        "hex",
        "--verbs",
        "pack",
        "--name",
        "n",
        "-o",
        out,
    )
    wanted = sm.packing.code("woct24-unorm", "c", verbs=["pack"], rounding="hex", name="n")
    assert out.read_text() == wanted


def test_it_prints_effects(tmp_path: Path) -> None:
    assert good("code", "sphere_map", "hlsl", "--effect") == sm.effect("sphere_map", "hlsl")
    out = tmp_path / "m.glsl"
    good("code", "matcap", "glsl", "--effect", "--native", "--name", "clay", "-o", out)
    assert out.read_text() == sm.effect("matcap", "glsl", name="clay", precision="native")
    assert out.read_text() != good("code", "matcap", "glsl", "--name", "clay")
    bad("code", "gbufer", "glsl", "--effect", code=2, says="did you mean 'gbuffer'")
    bad("code", "gbuffer", "osl", "--effect", code=2, says="unknown language")
    for option in (["--verbs", "encode"], ["--double"], ["--rounding", "hex"]):
        bad("code", "gbuffer", "glsl", "--effect", *option, code=2, says=f"leave out {option[0]}")
    bad("code", "gbuffer", "glsl", "--effect", "--rotation", 1, 2, 3, code=2, says="--rotation")


def test_it_names_its_own_options() -> None:
    for name in ("latlong", "oct16"):
        bad("code", name, "wgsl", "--double", code=2, says="leave out --double")
    bad("code", "oct40", "c", code=2, says="ask for --double")
    bad("code", "oct16", "c", "--rotation", 1, 2, 3, code=2, says="leave out --rotation")
    bad("code", "latlong", "c", "--rounding", "hex", code=2, says="leave out --rounding")
    bad("code", "oct16", "c", "--verbs", "encode", code=2, says="unknown verb")
