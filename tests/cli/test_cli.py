"""The command line as a person meets it: arguments, files, one line where it fails."""

from __future__ import annotations

import contextlib
import io as streams
import os
import subprocess
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import _core, cli, io

for needed in ("OpenImageIO", "typer", "rich"):
    pytest.importorskip(needed, reason="the command needs: pip install spheremap[cli]")

IS_ROOT = hasattr(os, "geteuid") and os.geteuid() == 0


@dataclass(frozen=True)
class Done:
    """What a command that has ended leaves behind."""

    returncode: int
    stdout: str
    stderr: str


def run(*arguments: object) -> Done:
    """Run the command in this process: starting another takes longer than most of them run."""
    out, errors = streams.StringIO(), streams.StringIO()
    with contextlib.ExitStack() as stack:
        stack.enter_context(contextlib.redirect_stdout(out))
        stack.enter_context(contextlib.redirect_stderr(errors))
        stack.enter_context(warnings.catch_warnings())
        warnings.simplefilter("error")
        end = stack.enter_context(pytest.raises(SystemExit))
        cli.main([str(argument) for argument in arguments])
    return Done(int(end.value.code or 0), out.getvalue(), errors.getvalue())


def process(*arguments: object) -> Done:
    """Run the command as a shell does."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "spheremap.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
        env={**os.environ, "NO_COLOR": "1"},
        check=False,
    )
    return Done(done.returncode, done.stdout, done.stderr)


def good(*arguments: object) -> str:
    done = run(*arguments)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout


def bad(*arguments: object, code: int, says: str) -> str:
    done = run(*arguments)
    assert done.returncode == code, (done.returncode, done.stderr)
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith("error: ")
    assert says in line, line
    return line


def smooth(d: np.ndarray) -> np.ndarray:
    """Light that differs in every direction, above 1 in places and negative in others."""
    x, y, z = np.nan_to_num(np.moveaxis(d, -1, 0))
    return np.stack([2 + x + y * z, 1 - y + x * z, 3 * z * z - 1], axis=-1).astype(np.float32)


@pytest.fixture
def probe(tmp_path: Path) -> Path:
    path = tmp_path / "probe.exr"
    io.write(path, smooth(sm.directions("angular", 192)))
    return path


def from_angular(to: str) -> tuple[str, ...]:
    return "--from", "angular", "--to", to


# --- convert ---------------------------------------------------------------------------------


@pytest.mark.parametrize("to", [*sm.projections(), "latlong:mitsuba"])
def test_convert_writes_the_light_of_every_direction(to: str, probe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    options = ["--size", 48, "--fill", -9, "--no-antialias", "--world", "literal"]
    good("convert", probe, out, *from_angular(to), *options)
    p = sm.projection(to)
    if p.faces > 1:
        own = next(x for x in _core.registry() if x["name"] == p.name)["layouts"]
        layout = "cross" if "cross" in own else "strip" if "strip" in own else own[-1]
        p = sm.projection(to, layout=layout)
    image = io.read(out)
    assert image.dtype == np.float32
    assert image.shape == (*p.shape(48), 3)
    d = p.directions(48)
    held = np.isfinite(d[..., 0])
    assert np.all(image[~held] == -9)
    # Off the probe's rim, where its texels are largest.
    clear = held & (np.nan_to_num(d[..., 2], nan=1) < 0.8)
    assert np.abs(image[clear] - smooth(d)[clear]).max() < 0.02


def test_a_shell_gets_what_a_caller_gets(probe: Path, tmp_path: Path) -> None:
    for arguments in (
        ("--version",),
        ("explain", "cube"),
        ("convert", probe, tmp_path / "a.exr", *from_angular("latlon")),
        ("info", tmp_path / "none.exr"),
    ):
        assert process(*arguments) == run(*arguments)
    out = tmp_path / "out.exr"
    assert process("convert", probe, out, *from_angular("cube"), "--size", 8).returncode == 0
    assert io.read(out).shape == (24, 32, 3)


def test_convert_and_the_library_give_the_same_bits(probe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    said = good(
        "convert", probe, out, *from_angular("octahedral"), "--height", 64,
        "--filter", "nearest",
    )  # fmt: skip
    expected = sm.convert(io.read(probe), "angular", "octahedral", size=64, filter="nearest")
    assert np.array_equal(io.read(out), expected)
    assert "octahedral, 64 x 64" in said


def test_the_default_size_keeps_the_texels_per_steradian(probe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    good("convert", probe, out, *from_angular("latlong"))
    height, width = io.read(out).shape[:2]
    assert width == 2 * height
    # A height of 120.3 rows becomes a whole one, and the width twice it: 2·0.5/120.
    assert height * width == pytest.approx(np.pi / 4 * 192**2, rel=0.02)


def test_rotation_turns_the_content(probe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    good(
        "convert", probe, out, *from_angular("latlong"), "--height", 64,
        "--rotation", -90, 20, "1e1",
    )  # fmt: skip
    turn = sm.rotation(-90, 20, 10)
    d = sm.directions("latlong", 64)
    looked_up = d @ turn  # what lies at d now came from the inverse turn of d
    clear = looked_up[..., 2] < 0.8
    assert np.abs(io.read(out)[clear] - smooth(looked_up)[clear]).max() < 0.02


@pytest.mark.parametrize("layout", ["strip", "column", "cross", "vertical_cross"])
def test_layouts_there_and_back(layout: str, probe: Path, tmp_path: Path) -> None:
    cube, pano = tmp_path / "cube.exr", tmp_path / "pano.exr"
    good(
        "convert", probe, cube, *from_angular("cube"), "--size", 64,
        "--layout", layout,
    )  # fmt: skip
    assert io.read(cube).shape[:2] == sm.projection("cube", layout=layout).shape(64)
    # The layout of the input is found from its size.
    good("convert", cube, pano, "--from", "cube", "--to", "latlong", "--height", 32)
    d = sm.directions("latlong", 32)
    clear = d[..., 2] < 0.8
    assert np.abs(io.read(pano)[clear] - smooth(d)[clear]).max() < 0.03


def test_the_height_of_a_cross_is_three_faces(probe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    good("convert", probe, out, *from_angular("cube"), "--height", 48)
    assert io.read(out).shape == (48, 64, 3)
    bad(
        "convert", probe, out, *from_angular("cube"), "--height", 50,
        code=2, says="a height that cube cross can have, as 48 or 51, got 50",
    )  # fmt: skip


def test_half_stays_half_and_channels_keep_their_names(tmp_path: Path) -> None:
    source, out = tmp_path / "a.exr", tmp_path / "b.exr"
    names = ("R", "G", "B", "A", "depth")
    image = np.linspace(0, 2000, 32 * 64 * 5).reshape(32, 64, 5).astype(np.float16)
    io.write(source, image, channels=names)
    good("convert", source, out, "--from", "latlong", "--to", "octahedral", "--size", 16)
    assert io.read(out).dtype == np.float16
    assert io.channel_names(out) == names
    assert np.array_equal(io.read(out), sm.convert(image, "latlong", "octahedral", size=16))


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_integers_keep_their_values(dtype: str, tmp_path: Path) -> None:
    source, out = tmp_path / "a.png", tmp_path / "b.png"
    image = np.full((16, 32, 3), np.iinfo(dtype).max - 3, dtype)
    io.write(source, image)
    good("convert", source, out, "--from", "latlong", "--to", "octahedral", "--size", 8)
    assert np.array_equal(io.read(out), image[:8, :8])
    assert io.read(out).dtype == dtype


def test_floats_are_tone_mapped_for_a_picture_and_a_preview(probe: Path, tmp_path: Path) -> None:
    exr, png, preview = (tmp_path / name for name in ("a.exr", "a.png", "p.png"))
    common = (*from_angular("latlong"), "--height", 32, "--exposure", -1)
    good("convert", probe, exr, *common, "--preview", preview)
    good("convert", probe, png, *common, "--tonemap", "reinhard")
    expected = io.tonemap(io.read(exr), exposure=-1)
    assert np.array_equal(io.read(preview), expected)
    assert np.array_equal(io.read(png), expected)
    assert np.ptp(expected) > 100


def test_any_aspect_is_taken_on_request(tmp_path: Path) -> None:
    source, out = tmp_path / "a.exr", tmp_path / "b.exr"
    io.write(source, np.full((30, 50, 3), 0.5, np.float32))
    convert = ("convert", source, out, "--from", "latlong", "--to", "octahedral", "--size", 8)
    line = bad(*convert, code=1, says="50 x 30")
    assert "60 x 30" in line
    assert not out.exists()
    good(*convert, "--any-aspect")
    assert np.all(io.read(out) == 0.5)


def test_an_existing_output_is_replaced(probe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    for size in (16, 24):
        good("convert", probe, out, *from_angular("latlong"), "--height", size)
        assert io.read(out).shape[0] == size
    assert sorted(os.listdir(tmp_path)) == ["out.exr", "probe.exr"]


def test_the_input_may_be_the_output(probe: Path) -> None:
    expected = sm.convert(io.read(probe), "angular", "latlong", size=16)
    good("convert", probe, probe, *from_angular("latlong"), "--height", 16)
    assert np.array_equal(io.read(probe), expected)


# --- what goes wrong -------------------------------------------------------------------------


def test_errors_are_one_line(probe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    sides = from_angular("latlong")
    bad("convert", tmp_path / "none.exr", out, *sides, code=1, says="no such file")
    bad("convert", probe, out, "--from", "angulr", "--to", "latlong", code=2, says="'angular'")
    bad("convert", probe, out, *from_angular("latlon"), code=2, says="'latlong'")
    bad("convert", probe, out, *from_angular("latlong:mitsuva"), code=2, says="mitsuba")
    bad("convert", probe, out, *sides, "--layout", "cros", code=2, says="cros")
    bad("convert", probe, out, *sides, "--from-layout", "cross", code=2, says="no layouts")
    cube = (*from_angular("cube"), "--layout", "faces")
    bad("convert", probe, out, *cube, code=2, says="one image")
    bad("convert", probe, out, *sides, "--height", 0, code=2, says="--height")
    bad("convert", probe, out, *sides, "--height", "x", code=2, says="--height")
    bad("convert", probe, out, *sides, "--height", 8, "--size", 8, code=2, says="not both")
    bad("convert", probe, out, *sides, "--filter", "cubik", code=2, says="bilinear")
    bad("convert", probe, out, *sides, "--rotation", 1, 2, code=2, says="--rotation")
    bad("convert", probe, out, *sides, "--rotation", "nan", 0, 0, code=1, says="")
    bad("convert", probe, out, *sides, "--preview", "p.exr", code=2, says="--preview")
    bad("convert", probe, out, "--to", "latlong", code=2, says="--from")
    bad("convert", probe, *sides, code=2, says="OUT")
    bad("convert", probe, tmp_path / "out.xyz", *sides, code=1, says="unknown format")
    bad("convert", probe, tmp_path / "no" / "out.exr", *sides, code=1, says="no folder")
    bad("convert", probe, tmp_path, *sides, code=1, says=str(tmp_path))
    bad("explain", "octahedrel", code=2, says="'octahedral'")
    bad("info", tmp_path / "none.exr", code=1, says="none.exr")
    bad("dance", code=2, says="dance")
    bad("info", "--loud", probe, code=2, says="--loud")
    bad("demo", probe, code=1, says="probe.exr")
    bad("demo", tmp_path / "d", "--input", tmp_path / "none.exr", code=1, says="none.exr")
    assert sorted(os.listdir(tmp_path))[-1] == "probe.exr"
    assert not out.exists()


def test_a_broken_input_leaves_the_old_output_alone(tmp_path: Path) -> None:
    source, out = tmp_path / "broken.exr", tmp_path / "out.exr"
    source.write_bytes(b"\x76\x2f\x31\x01 but no more than that")
    out.write_bytes(b"precious")
    bad("convert", source, out, *from_angular("latlong"), code=1, says="cannot read")
    assert out.read_bytes() == b"precious"
    assert sorted(os.listdir(tmp_path)) == ["broken.exr", "out.exr"]


def test_a_size_beyond_memory_is_one_line_too(probe: Path, tmp_path: Path) -> None:
    done = run(
        "convert", probe, tmp_path / "o.exr", *from_angular("latlong"),
        "--height", 10_000_000,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.startswith("error: ") and len(done.stderr.splitlines()) == 1
    assert os.listdir(tmp_path) == ["probe.exr"]


@pytest.mark.skipif(IS_ROOT, reason="root may write everywhere")
def test_a_folder_without_permission(probe: Path, tmp_path: Path) -> None:
    locked = tmp_path / "locked"
    locked.mkdir()
    (locked / "out.exr").write_bytes(b"precious")
    locked.chmod(0o555)
    try:
        bad(
            "convert", probe, locked / "out.exr", *from_angular("latlong"),
            code=1, says="permission",
        )  # fmt: skip
        assert (locked / "out.exr").read_bytes() == b"precious"
    finally:
        locked.chmod(0o755)


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a place that no one may write")
def test_a_place_that_no_one_may_write(probe: Path) -> None:
    sides = (*from_angular("latlong"), "--height", 8)
    bad("convert", probe, "/proc/out.exr", *sides, code=1, says="/proc/out.exr")


@pytest.mark.skipif(not hasattr(os, "pathconf"), reason="needs a limit on the size of a file")
def test_a_full_disk_leaves_the_old_output_alone(probe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    out.write_bytes(b"precious")
    script = (
        "import resource, signal, sys\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))\n"
        "from spheremap.cli import main\n"
        "main(sys.argv[1:])\n"
    )
    done = subprocess.run(
        [
            sys.executable, "-c", script, "convert", probe, out, *from_angular("latlong"),
            "--height", "256", "--compression", "none",
        ],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith(f"error: cannot write {str(out)!r}")
    assert "Traceback" not in done.stderr
    assert out.read_bytes() == b"precious"
    assert sorted(os.listdir(tmp_path)) == ["out.exr", "probe.exr"]


def test_without_typer_one_line_says_what_to_install() -> None:
    script = (
        "import sys; sys.modules['typer'] = None; from spheremap.cli import main; main(['info'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "error: the command line needs typer: pip install spheremap[cli]"
    ]


@pytest.mark.skipif(os.name != "posix", reason="needs a shell with pipes")
def test_a_reader_that_leaves_early_gets_no_traceback() -> None:
    done = subprocess.run(
        ["/bin/sh", "-c", '"$0" -m spheremap.cli projections | true', sys.executable],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stderr == ""


# --- info, projections, explain --------------------------------------------------------------


def test_info_counts(tmp_path: Path) -> None:
    image = np.ones((8, 16, 3), np.float32)
    image[0, 0] = [np.nan, np.inf, -2]
    image[1, :, 2] = -0.5
    io.write(tmp_path / "a.exr", image)
    said = good("info", tmp_path / "a.exr")
    assert "16 x 8" in said and "float32" in said and "R, G, B" in said
    fits = next(line for line in said.splitlines() if line.startswith("  fits"))
    assert "latlong" in fits and "octahedral" not in fits
    rows = {row[0]: row[1:] for row in map(str.split, said.splitlines()) if row}
    assert rows["R"] == ["1", "1", "1", "1", "0", "0"]
    assert rows["G"] == ["1", "1", "1", "0", "1", "0"]
    assert rows["B"][:2] == ["-2", "1"] and rows["B"][3:] == ["0", "0", "17"]


def test_info_of_nothing_finite(tmp_path: Path) -> None:
    io.write(tmp_path / "a.exr", np.full((9, 5, 1), np.nan, np.float32))
    said = good("info", tmp_path / "a.exr")
    assert "no projection as it is" in said
    assert "45" in said


def test_projections_lists_the_registry() -> None:
    said = good("projections")
    for entry in _core.registry():
        (line,) = (line for line in said.splitlines() if line.split()[:1] == [entry["name"]])
        assert entry["coverage"] in line
        assert all(word in line for word in (*entry["layouts"], entry["title"]))


@pytest.mark.parametrize("name", ["latlong", "latlong:mitsuba"])
def test_explain_prints_what_the_core_says(name: str) -> None:
    assert good("explain", name) == sm.projection(name).explanation().rstrip("\n") + "\n"


def test_version_and_help() -> None:
    assert good("--version") == f"spheremap {sm.__version__}\n"
    for command in ([], ["convert"], ["info"], ["projections"], ["explain"], ["demo"]):
        assert "Usage" in good(*command, "--help")
    assert "Usage" in run().stdout + run().stderr


# --- demo ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_demo_shows_the_sky_in_every_projection(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="the demonstration draws with matplotlib")
    from spheremap.cli import sky

    folder = tmp_path / "new" / "demo"
    said = good("demo", folder, "--size", 256)
    assert sorted(os.listdir(folder)) == sorted(
        ["contact_sheet.png", *(f"{name}.exr" for name in sm.projections())]
    )
    sheet = io.read(folder / "contact_sheet.png")
    assert sheet.dtype == np.uint8 and min(sheet.shape[:2]) > 1000
    assert "Mtexel/s" in said and "Mdirection/s" in said

    pano = io.read(folder / "latlong.exr")
    seen = sky.radiance(sm.directions("latlong", 256, dtype=np.float32))
    # A conversion to the same map and size shows each float32 texel as it is.
    assert pano == pytest.approx(seen, rel=1e-5, abs=1e-5)
    row, column = np.unravel_index(pano.sum(axis=-1).argmax(), pano.shape[:2])
    sun = sm.directions("latlong", 256)[row, column]
    assert np.degrees(np.arccos(sun @ sky.SUN)) < sky.SUN_RADIUS + 1

    for line in said.splitlines():
        if "Mtexel/s" in line:
            assert float(line.split()[-1].rstrip("%")) < 25, line  # matcap: its rim is coarse


def test_the_sun_is_round_and_the_labels_stand_upright() -> None:
    pytest.importorskip("matplotlib", reason="the labels are drawn with matplotlib")
    from spheremap.cli import sky

    # A small view toward each label, right and down on the screen, from inside.
    side = np.linspace(-0.5, 0.5, 201)
    for label in sky.LABELS:
        forward, up = np.array(label.forward, float), np.array(label.up, float)
        right = np.cross(forward, up)
        d = forward + side[:, None] * right - side[:, None, None] * up
        view = sky.radiance(d / np.linalg.norm(d, axis=-1, keepdims=True))
        tile = sky._tile(label.text, label.color)
        height, width = (round(200 * 2 * tangent) for tangent in reversed(sky._TILE))
        rows = np.linspace(0, tile.shape[0] - 1, height).astype(int)
        columns = np.linspace(0, tile.shape[1] - 1, width).astype(int)
        small = tile[rows][:, columns]
        trim = slice(max(0, (width - 201) // 2), max(0, (width - 201) // 2) + min(width, 201))
        small = small[:, trim]
        top, left = (201 - small.shape[0]) // 2, (201 - small.shape[1]) // 2
        patch = view[top : top + small.shape[0], left : left + small.shape[1]]
        on = small[..., 3] > 0.99

        def likeness(shown: np.ndarray, patch=patch, on=on) -> float:
            return float(np.corrcoef(shown[..., :3][on].ravel(), patch[on].ravel())[0, 1])

        upright = likeness(small)
        assert upright > 0.8, label
        assert upright > likeness(small[:, ::-1]) + 0.1, label
        assert upright > likeness(small[::-1, ::-1]) + 0.1, label

    # As many texels of solid angle as the cap of the sun has.
    d = sm.directions("octahedral", 512)
    lit = sky.radiance(d)[..., 0] > 300
    disk = sm.solid_angle("octahedral", 512)[lit].sum()
    # 25 of its 48 texels lie on the edge and count whole or not at all: 0.3·√25 of 48 is 3 %.
    assert disk == pytest.approx(2 * np.pi * (1 - np.cos(np.radians(sky.SUN_RADIUS))), rel=0.05)
    # A texel there is 0.5° wide: its center may lie half of that from the edge.
    assert np.degrees(np.arccos(np.min(d[lit] @ sky.SUN))) == pytest.approx(sky.SUN_RADIUS, abs=0.3)


# --- a real probe ----------------------------------------------------------------------------


def test_a_real_probe_becomes_an_upright_panorama(data_folder: Path, tmp_path: Path) -> None:
    source, out = data_folder / "grace_probe.hdr", tmp_path / "pano.exr"
    good("convert", source, out, *from_angular("latlong"), "--no-antialias")
    pano = io.read(out)
    assert pano.dtype == np.float32 and pano.shape[1] == 2 * pano.shape[0]
    # Every direction is in the probe, so nothing of the border outside its disk leaks in: what it
    # holds along a direction is what the panorama holds.
    probe = io.read(source)
    d = sm.directions("latlong", pano.shape[0])
    assert np.all(np.isfinite(pano)) and pano.max() <= probe.max()
    # In float64 to the bit; coordinates of float32 images are float32: 3·2⁻²³ of the image, which
    # is 1/2800 of a texel, times the contrast of texels side by side.
    want = sm.sample(probe, d, "angular")
    exact = sm.convert(
        probe.astype(np.float64), "angular", "latlong", size=pano.shape[0], antialias=False
    )
    assert np.array_equal(exact, sm.sample(probe.astype(np.float64), d, "angular"))
    assert np.abs(pano - want).max() < probe.max() / 2800
    # In the median, a texel's neighbors differ from it by a quarter at most: 1/2800 of that.
    assert np.median(np.abs(pano - want)) < 1e-4 * np.median(want)
    # Upright: the cathedral's windows and lamps are overhead, its dark floor below.
    light = np.log(pano.mean(axis=-1) + 1e-4)
    third = pano.shape[0] // 3
    assert light[:third].mean() > light[-third:].mean()


@pytest.mark.slow
def test_demo_with_a_real_probe(data_folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="the demonstration draws with matplotlib")
    source, folder = tmp_path / "grace.exr", tmp_path / "demo"
    probe = sm.convert(io.read(data_folder / "grace_probe.hdr"), "angular", "angular", size=250)
    io.write(source, probe)
    said = good("demo", folder, "--input", source, "--from", "angular")
    assert "grace.exr (angular)" in said
    assert len(os.listdir(folder)) == len(sm.projections()) + 1
    assert np.array_equal(
        io.read(folder / "octahedral.exr"), sm.convert(io.read(source), "angular", "octahedral")
    )


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "name"), [((64, 64), "angular"), ((32, 64), "latlong")])
def test_demo_takes_the_projection_from_the_aspect(tmp_path, shape, name):
    image = np.ones((*shape, 3), np.float32)
    # A sun beyond what a half holds, and a hole.
    image[7, 30], image[20, 21, 0] = np.inf, np.nan
    io.write(tmp_path / "in.exr", image)
    done = run("demo", tmp_path / "out", "--input", tmp_path / "in.exr")
    assert done.returncode == 0, done.stderr
    assert f"({name})" in done.stdout
    assert "Warning" not in done.stderr
