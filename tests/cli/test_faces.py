"""Six files for six faces, textures, and files that say what they are."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from spheremap.cli.files import noted, of_file
from spheremap.cli.targets import face_names
from spheremap.map.flat import layouts
from test_cli import bad, good, smooth


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    path = tmp_path / "sky.exr"
    io.write(path, smooth(sm.directions("latlong", 64)))
    return path


CUBE = ("--from", "latlong", "--to", "cube", "--size", 16)


@pytest.mark.parametrize("style", ["px", "posx", "0"])
def test_six_files_there_and_back(style: str, sky: Path, tmp_path: Path) -> None:
    names = {
        "px": ["px", "nx", "py", "ny", "pz", "nz"],
        "posx": ["posx", "negx", "posy", "negy", "posz", "negz"],
        "0": ["0", "1", "2", "3", "4", "5"],
    }[style]
    out = tmp_path / "faces" / "out_{face}.exr"
    out.parent.mkdir()
    good("convert", sky, out, *CUBE, "--layout", "faces", "--face-names", style)
    assert sorted(os.listdir(out.parent)) == sorted(f"out_{name}.exr" for name in names)
    cube = sm.convert(io.read(sky), "latlong", "cube", size=16)
    for k, name in enumerate(names):
        assert np.array_equal(io.read(out.parent / f"out_{name}.exr"), cube[k])
    back = tmp_path / "back.exr"
    good("convert", out, back, "--from", "cube", "--to", "latlong", "--size", 32)
    assert np.array_equal(io.read(back), sm.convert(cube, "cube", "latlong", size=32))


def test_faces_are_named_by_where_they_look(sky: Path, tmp_path: Path) -> None:
    good("convert", sky, tmp_path / "{face}.exr", *CUBE, "--layout", "faces")
    for axis, name in zip(
        np.vstack([np.eye(3), -np.eye(3)]), ["px", "py", "pz", "nx", "ny", "nz"], strict=True
    ):
        face = io.read(tmp_path / f"{name}.exr")
        # Four texels of 6 degrees meet at the center; the light changes by 2 in a radian.
        assert face[7:9, 7:9].mean((0, 1)) == pytest.approx(smooth(axis), abs=0.05)


def test_faces_that_are_asked_for_by_halves(sky: Path, tmp_path: Path) -> None:
    bad("convert", sky, tmp_path / "a.exr", *CUBE, "--layout", "faces", code=2, says="{face}")
    bad("convert", sky, tmp_path / "{face}.exr", *CUBE, code=2, says="--layout faces")
    missing = ("convert", tmp_path / "no_{face}.exr", tmp_path / "a.exr", "--to", "latlong")
    bad(*missing, "--from", "cube", code=1, says="no_px.exr")
    bad(*missing, code=2, says="--from is needed")
    bad("convert", sky, tmp_path / "a.exr", *CUBE, "--face-names", "0", code=2, says="does nothing")


@pytest.mark.parametrize("suffix", ["ktx2", "dds"])
def test_textures(suffix: str, sky: Path, tmp_path: Path) -> None:
    out, expected = tmp_path / f"out.{suffix}", tmp_path / f"expected.{suffix}"
    write = {"ktx2": io.write_ktx2, "dds": io.write_dds}[suffix]
    cube = sm.convert(io.read(sky), "latlong", "cube", size=16)
    good("convert", sky, out, *CUBE)
    write(expected, [cube])
    assert out.read_bytes() == expected.read_bytes()
    assert "5 mips" in good("convert", sky, out, *CUBE, "--mips")
    write(expected, sm.mipmaps(cube, "cube"))
    assert out.read_bytes() == expected.read_bytes()
    if suffix == "ktx2":
        assert struct.unpack_from("<2I", out.read_bytes(), 36) == (6, 5)


def test_options_that_textures_and_images_have_not(sky: Path, tmp_path: Path) -> None:
    bad("convert", sky, tmp_path / "a.exr", *CUBE, "--mips", code=2, says="--mips")
    bad("convert", sky, tmp_path / "a.dds", *CUBE, "--float", code=2, says="--float does nothing")
    tex = ("convert", sky, tmp_path / "a.dds", "--from", "latlong", "--to", "healpix")
    bad(*tex, code=2, says="12 faces")


def test_a_file_that_says_what_it_is_needs_no_from(sky: Path, tmp_path: Path) -> None:
    cube, back = tmp_path / "cube.exr", tmp_path / "back.exr"
    bad("convert", sky, cube, "--to", "cube", code=2, says="--from is needed")
    good("convert", sky, cube, *CUBE)
    said = good("convert", cube, back, "--to", "latlong", "--size", 16)
    assert f"{cube}: taken as cube, as it says" in said
    cross = sm.projection("cube", layout="cross")
    assert np.array_equal(io.read(back), sm.convert(io.read(cube), cross, "latlong", size=16))


def test_words_travel_from_format_to_format(sky: Path, tmp_path: Path) -> None:
    source, out = tmp_path / "a.exr", tmp_path / "b.jpg"
    words = {"Artist": "Ada", "Copyright": "© Ada", "ImageDescription": "a sky"}
    io.write(source, io.read(sky), metadata=words)
    good("convert", source, out, "--from", "latlong", "--to", "latlong", "--size", 16)
    head = io.header(out)
    assert {name: head.metadata[name] for name in words} == words
    assert head.projection == "latlong"


def test_a_profile_travels_while_values_are_what_it_says(tmp_path: Path) -> None:
    cms = pytest.importorskip("PIL.ImageCms", reason="makes a profile")
    profile = cms.ImageCmsProfile(cms.createProfile("sRGB")).tobytes()
    source, png, exr = (tmp_path / name for name in ("a.png", "b.png", "c.exr"))
    io.write(source, np.full((8, 16, 3), 99, np.uint8), metadata={"ICCProfile": profile})
    assert bytes(io.header(source).metadata["ICCProfile"]) == profile
    same = ("--from", "latlong", "--to", "latlong")
    good("convert", source, png, *same)
    assert bytes(io.header(png).metadata["ICCProfile"]) == profile
    # As light, values are no longer those that the profile is about.
    good("convert", source, exr, *same)
    assert "ICCProfile" not in io.header(exr).metadata


# What lies toward an axis, by the name of the file that the program loads for it.
EXCHANGED = {"threejs": ("px", "nx"), "playcanvas": ("px", "nx"), "bevy": ("pz", "nz")}


@pytest.mark.parametrize("row", [row["name"] for row in sm.conventions("cube")])
def test_faces_have_the_names_by_which_the_program_loads_them(row: str) -> None:
    p = sm.projection(f"cube:{row}", layout="faces")
    axes = {"px": (1, 0, 0), "py": (0, 1, 0), "pz": (0, 0, 1)}
    axes |= {f"n{name[1]}": tuple(-np.array(axis)) for name, axis in axes.items()}
    exchanged = EXCHANGED.get(row, ("px", "px"))
    swap = dict([exchanged, exchanged[::-1]])
    for k, name in enumerate(face_names(p, "px")):
        axis = axes[swap.get(name, name)]
        assert np.array_equal(np.round(p.decode([0.5, 0.5, k]), 12), axis)


@pytest.mark.parametrize("row", ["threejs", "bevy"])
def test_faces_of_other_names_come_back(row: str, sky: Path, tmp_path: Path) -> None:
    faces, back = tmp_path / "f_{face}.exr", tmp_path / "back.exr"
    name = f"cube:{row}"
    good("convert", sky, faces, "--from", "latlong", "--to", name, "--size", 16,
        "--layout", "faces", "--world", "literal")  # fmt: skip
    toward = {"threejs": ("px", (-1, 0, 0)), "bevy": ("pz", (0, 0, -1))}[row]
    face = io.read(tmp_path / f"f_{toward[0]}.exr")
    # Four texels of 6 degrees meet at the center; the light changes by 2 in a radian.
    assert face[7:9, 7:9].mean((0, 1)) == pytest.approx(smooth(np.array(toward[1])), abs=0.05)
    good("convert", faces, back, "--from", name, "--to", "latlong", "--size", 32,
        "--world", "literal")  # fmt: skip
    cube = sm.convert(io.read(sky), "latlong", name, size=16, world="literal")
    expected = sm.convert(cube, name, "latlong", size=32, world="literal")
    assert np.array_equal(io.read(back), expected)


@pytest.mark.parametrize("name", ["cube", "cube:opengl", "cube:directxtex-h-tee"])
@pytest.mark.parametrize("layout", layouts("cube"))
def test_a_file_is_read_in_the_layout_that_it_was_written_in(name: str, layout: str) -> None:
    p = sm.projection(name, layout=layout)
    said = noted(name, p)
    if said is not None:
        assert of_file(said, None, *p.shape(32)) == p
    is_first = layout in ("cross", "vertical_cross", "strip", "column", "3x2")
    assert (said is not None) == (layout == "tee" if name.endswith("tee") else is_first)


def test_a_tee_says_nothing_of_itself(sky: Path, tmp_path: Path) -> None:
    tee, back = tmp_path / "tee.exr", tmp_path / "back.exr"
    good("convert", sky, tee, *CUBE, "--layout", "tee")
    bad("convert", tee, back, "--to", "latlong", code=2, says="--from is needed")
    good("convert", tee, back, "--from", "cube", "--from-layout", "tee", "--to", "latlong")
