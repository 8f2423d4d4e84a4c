"""docs/coming-from.md: both sides of each row are run and compared, or ours where theirs cannot."""

from __future__ import annotations

import re
import shlex
import subprocess
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions
from spheremap.cli import main

from oracles import ffmpeg_oracle, mitsuba_oracle, need, openimageio_oracle

PAGE = Path(__file__).resolve().parents[2] / "docs" / "coming-from.md"


def sections() -> dict[str, list[tuple[list[str], list[str]]]]:
    """Return the rows of each program: the code of both cells, line by line."""
    found: dict[str, list[tuple[list[str], list[str]]]] = {}
    for part in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        program = part.split(maxsplit=1)[0]
        rows = re.findall(r"^\| (.*) \| (.*) \|$", part, re.M)[2:]
        found[program] = [(code(a), code(b)) for a, b in rows]
    return found


def code(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


SECTIONS = sections()


def scene(d: np.ndarray) -> np.ndarray:
    """Return smooth colors in [0, 1] that no turn and no mirror keeps."""
    x, y, z = np.moveaxis(d, -1, 0)
    red = 0.5 + 0.2 * np.sin(3 * x + 1) + 0.2 * y
    green = 0.5 + 0.2 * np.sin(2 * z - 1) * y + 0.2 * x
    return np.stack([red, green, 0.5 + 0.4 * z * x + 0.05 * y], axis=-1)


def names() -> dict[str, Any]:
    panorama = scene(sm.directions("latlong", 256)).astype(np.float32)
    return {"np": np, "sm": sm, "panorama": panorama, "d": random_directions(300, 5)}


def of_py360convert(given: dict[str, Any]) -> None:
    given["py360convert"] = need("py360convert")
    made = scene(sm.directions("cube:py360convert-dice", 64))
    given["dice"] = np.nan_to_num(made).astype(np.float32)


def of_opencv(given: dict[str, Any]) -> None:
    given["cv2"] = need("cv2")
    d = given["d"]
    rng = np.random.default_rng(6)
    plan = sm.remap_plan(
        "latlong", "perspective", size=65, source_shape=(256, 512), antialias=False
    )
    x, y = (rng.uniform(0, n - 1, (20, 20)).astype(np.float32) for n in (64, 48))
    given |= {
        # Ahead, and within what a turn by 17 degrees leaves in the picture.
        "d": d[d[:, 2] > 0.85 * np.linalg.norm(d, axis=1)],
        "camera": sm.projection("perspective", fov=90, aspect=4 / 3, axes="+x +y +z"),
        "K": np.array([[32, 0, 31.5], [0, 32, 23.5], [0, 0, 1]]),
        "F": np.array([[64 / np.pi, 0, 31.5], [0, 64 / np.pi, 31.5], [0, 0, 1]]),
        "zero": np.zeros(3),
        "rvec": np.radians([4.0, 7.0, 15.0]),
        "pixels": rng.uniform(0, 47, (50, 2)),
        "plan": plan,
        "picture": rng.random((48, 64, 3)).astype(np.float32),
        "x": x,
        "y": y,
    }


def of_healpy(given: dict[str, Any]) -> None:
    given["healpy"] = need("healpy")
    d = given["d"]
    rng = np.random.default_rng(7)
    alm = given["healpy"].synalm(np.ones(9), lmax=8, new=True)
    given |= {
        "theta": np.arccos(d[:, 2] / np.linalg.norm(d, axis=1)),
        "phi": np.arctan2(d[:, 1], d[:, 0]),
        "lon": rng.uniform(0, 360, 300),
        "lat": rng.uniform(-90, 90, 300),
        "pix": rng.integers(0, 49152, 300),
        "alm": alm,
        "m": given["healpy"].alm2map(alm, 64),
    }


def of_pyshtools(given: dict[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        given["pyshtools"] = need("pyshtools")
    d = given["d"]
    c = sm.sh.convert(np.random.default_rng(8).normal(size=81), dst="pyshtools")
    lat, lon = np.radians([20.0, 50.0])
    given |= {
        "c": c,
        "lat": np.degrees(np.arctan2(d[:, 2], np.hypot(d[:, 0], d[:, 1]))),
        "lon": np.degrees(np.arctan2(d[:, 1], d[:, 0])),
        "toward": [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)],
    }


def of_ffmpeg(given: dict[str, Any]) -> None:
    given["ffmpeg"] = ffmpeg_oracle.program()
    given["pixels"] = np.rint(255 * given["panorama"]).astype(np.uint8)
    sm.io.write("panorama.png", given["pixels"])


def of_openimageio(given: dict[str, Any]) -> None:
    oiio = openimageio_oracle.openimageio()
    textures, options, config = oiio.TextureSystem(False), oiio.TextureOpt(), oiio.ImageSpec()
    textures.attribute("autotile", 64)
    options.mipmode, options.interpmode = oiio.MipMode.NoMIP, oiio.InterpMode.Bilinear
    config.attribute("maketx:nomipmap", 1)
    # Its lookups mix in what lies beyond the rim, which is the one direction -z.
    d = sm.directions("angular:openimageio", 128)
    probe = scene(np.where(np.isnan(d), [0.0, 0.0, -1.0], d)).astype(np.float32)
    openimageio_oracle.write(given["panorama"], Path("sky.tif"))
    openimageio_oracle.write(probe, Path("probe.tif"))
    given |= {
        "OpenImageIO": oiio,
        "textures": textures,
        "options": options,
        "config": config,
        "probe": probe,
        "zero": (0.0, 0.0, 0.0),
        "read": sm.io.read,
    }


def of_skylibs(given: dict[str, Any]) -> None:
    envmap: Any = need("envmap")
    given["e"] = envmap.EnvironmentMap(given["panorama"].copy(), "latlong")
    given["R"] = sm.rotation(30, 20, 10)


def of_mitsuba(given: dict[str, Any]) -> None:
    given["R"] = sm.rotation(30, 20, 10)
    given |= {"emitter": None, "turned": given["R"]}
    panorama = given["panorama"]
    given["radiance"] = lambda to_world, d: mitsuba_oracle.lookup(panorama, d, to_world)


PREPARE = {
    "py360convert": of_py360convert,
    "OpenCV": of_opencv,
    "healpy": of_healpy,
    "pyshtools": of_pyshtools,
    "ffmpeg": of_ffmpeg,
    "OpenImageIO": of_openimageio,
    "skylibs": of_skylibs,
    "mitsuba": of_mitsuba,
}
# What both sides may differ by, row by row.
TOLERANCES: dict[str, list[float]] = {
    # OpenCV's steps of 1/32 of a texel of 2π/512, halved, in colors whose slope is 0.8; its c2e is
    # off by a texel of π/128 at most.
    "py360convert": [2e-4, 2e-4, 2e-4, 0.02, 2e-4],
    # float64: a handful of roundings of up to 64 pixels; lookups in float32.
    "OpenCV": [1e-12, 1e-12, 1e-13, 1e-12, 1e-6, 1e-5],
    # float64, with 81 terms near 3 in the last two.
    "healpy": [
        *[0.5] * 3,
        *[1e-14] * 2,
        *[0.5] * 3,
        *[1e-13] * 2,
        1e-11,
        *[1e-14] * 2,
        1e-12,
        1e-11,
    ],
    # 81 terms near 1, a few roundings each.
    "pyshtools": [1e-12, 1e-12, 1e-12],
    # Of 255: it rounds its weights to 14 bits, and both round colors.
    "ffmpeg": [1.5, 1.5, 1.5, 1.5, 1.5],
    # float32, up to 1; beside the rim of a probe, π/64 a texel, each sees something else beyond.
    "OpenImageIO": [1e-5, 1e-3],
    # It clamps at the seam, half a texel of 2π/512 in colors whose slope is 0.8, and looks across
    # rims; its directions are float32 in part, and its solid angles sums of triangles.
    "skylibs": [5e-3, 1e-6, 5e-3, 1e-6, 1e-6, 1e-12, 0.5, 1e-8],
    # float32, up to 1.
    "mitsuba": [1e-6, 1e-6],
}


def run(lines: list[str], given: dict[str, Any]) -> Any:
    """Return what the last line gives, or the picture that a command writes."""
    if lines[-1].startswith("ffmpeg "):
        *words, out = shlex.split(lines[-1])[1:]
        subprocess.run([given["ffmpeg"], "-loglevel", "error", *words, out], check=True)
        return sm.io.read(out)
    if lines[-1].startswith("spheremap "):
        words = shlex.split(lines[-1])[1:]
        Path("out.png").unlink(missing_ok=True)
        with pytest.raises(SystemExit) as end:
            main(words)
        assert not end.value.code
        return sm.io.read("out.png") if "out.png" in words else None
    for line in lines[:-1]:
        exec(line, given)
    return eval(lines[-1], given)


ROWS = [(program, k) for program in PREPARE for k in range(len(SECTIONS[program]))]


def test_every_row_has_a_tolerance():
    assert {name: len(row) for name, row in TOLERANCES.items()} == {
        name: len(SECTIONS[name]) for name in PREPARE
    }


@pytest.mark.parametrize(("program", "k"), ROWS, ids=str)
def test_both_give_the_same(program, k, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = names()
    PREPARE[program](given)
    theirs, ours = SECTIONS[program][k]
    want, got = (np.asarray(run(lines, given)) for lines in (theirs, ours))
    assert want.shape == got.shape and np.isfinite(got).all()
    kind = np.complex128 if np.iscomplexobj(got) else np.float64
    want, got = want.astype(kind), got.astype(kind)
    # ffmpeg draws something outside of disks as well, which ours leave black.
    seen = got.any(axis=-1) if program == "ffmpeg" else np.ones(got.shape, bool)
    assert seen.mean() > 0.7
    assert np.abs(want - got)[seen].max() < TOLERANCES[program][k]
    if got.ndim and "solid_angle" not in ours[-1]:
        # It would notice another order, and an image that is mirrored or upside down.
        assert np.abs(want - got[::-1]).max() > 10 * TOLERANCES[program][k]
        if got.ndim == 3:
            assert np.abs(want - got[:, ::-1]).max() > 10 * TOLERANCES[program][k]


# What makes tables for renderers takes a second each.
OURS = [
    pytest.param(name, k, marks=[pytest.mark.slow] if name == "cmgen" else [])
    for name in sorted(set(SECTIONS) - set(PREPARE))
    for k in range(len(SECTIONS[name]))
]


@pytest.mark.parametrize(("program", "k"), OURS, ids=str)
def test_ours_runs(program, k, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = names()
    given["dice"] = np.zeros((192, 256, 3), np.float32)
    sm.io.write("sky.hdr", given["panorama"][::4, ::4])
    for line in SECTIONS[program][k][1]:
        if line.startswith("camera = "):
            exec(line, given)
            continue
        found = run([line], given)
        if isinstance(found, str):
            sm.projection(found)
