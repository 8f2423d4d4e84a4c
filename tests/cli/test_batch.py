"""`batch`: many files, what is done of them, and what becomes of what fails."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from terminals import needs_terminal, on_terminal
from test_cli import Done, bad, good, run, smooth

MANIFEST = "spheremap-batch.jsonl"
TO_CUBE = ("--from", "latlong", "--to", "cube", "--size", 16)


@pytest.fixture
def skies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three files in two folders, below the current one."""
    monkeypatch.chdir(tmp_path)
    for k, name in enumerate(("a.exr", "day/b.exr", "day/c.exr")):
        path = tmp_path / "in" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        io.write(path, np.abs(smooth(sm.directions("latlong", 32 + k))))
    return tmp_path


def mirror(*more: object) -> tuple[object, ...]:
    return ("in/**/*.exr", "-o", "out/{dir}/{stem}.exr", *TO_CUBE, "--jobs", 2, *more)


def entries(path: Path = Path("out") / MANIFEST) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def files(folder: str = "out") -> list[str]:
    return sorted(
        path.relative_to(folder).as_posix() for path in Path(folder).rglob("*") if path.is_file()
    )


def test_a_tree_is_mirrored_with_the_bits_of_convert(skies: Path) -> None:
    assert good("batch", *mirror()) == "3 of 3 images converted\n"
    assert files() == ["a.exr", "day/b.exr", "day/c.exr", MANIFEST]
    for name in ("a.exr", "day/b.exr"):
        good("convert", f"in/{name}", "one.exr", *TO_CUBE)
        assert np.array_equal(io.read("one.exr"), io.read(Path("out", name)))
    found = {entry["target"]: entry for entry in entries()}
    assert list(found) and set(found) == {"a.exr", "day/b.exr", "day/c.exr"}
    entry = found["day/b.exr"]
    assert entry["source"]["file"] == "../in/day/b.exr"
    assert entry["version"] == sm.__version__
    assert entry["arguments"] == {"to": "cube", "from_": "latlong", "size": "16"}
    (result,) = entry["results"]
    assert result["size"] == Path("out/day/b.exr").stat().st_size and len(result["sha256"]) == 64


def test_what_is_done_is_left_out_until_anything_of_it_changes(skies: Path) -> None:
    good("batch", *mirror())
    times = {name: Path("out", name).stat().st_mtime_ns for name in files()}
    assert good("batch", *mirror()) == "0 of 3 images converted, 3 were there\n"
    # As new, of the same bytes; of other bytes; a result that is gone, and one that is another.
    os.utime("in/a.exr")
    assert "3 were there" in good("batch", *mirror())
    assert {name: Path("out", name).stat().st_mtime_ns for name in files()} == times
    io.write("in/a.exr", np.ones((32, 64, 3), np.float32))
    Path("out/day/b.exr").unlink()
    Path("out/day/c.exr").write_bytes(b"x" * Path("out/day/c.exr").stat().st_size)
    assert "3 of 3" in good("batch", *mirror())
    assert np.all(io.read("out/a.exr")[16:32] == 1)
    assert "3 of 3" in good("batch", *mirror("--filter", "nearest"))
    # Each has one line again.
    assert len(entries()) == 6
    good("batch", *mirror("--filter", "nearest", "--memory", "256M"))
    assert len(entries()) == 3


def test_half_a_line_ends_nothing_and_another_file_is_none(skies: Path) -> None:
    good("batch", *mirror())
    manifest = Path("out") / MANIFEST
    lines = manifest.read_text().splitlines(keepends=True)
    manifest.write_text("".join(lines)[:-20])
    assert "1 of 3 images converted, 2 were there" in good("batch", *mirror())
    assert len(entries()) == 3
    bad("batch", *mirror("--manifest", "in/a.exr"), code=1, says="none of a batch's manifest")
    Path("notes.txt").write_text("a\nb\n")
    bad("batch", *mirror("--manifest", "notes.txt"), code=1, says="line 1 of 'notes.txt'")


def test_a_broken_file_keeps_no_other_from_it(skies: Path) -> None:
    Path("in/day/b.exr").write_bytes(b"no image")
    done = run("batch", *mirror("--retries", 1))
    assert done.returncode == 1 and done.stdout == ""
    line, summary = done.stderr.splitlines()
    assert line.startswith("error: in/day/b.exr: cannot read ")
    assert summary == "2 of 3 images converted"
    assert files() == ["a.exr", "day/c.exr", MANIFEST]
    assert "cannot read" in next(e for e in entries() if e["target"] == "day/b.exr")["error"]
    io.write("in/day/b.exr", np.ones((8, 16, 3), np.float32))
    assert good("batch", *mirror()) == "1 of 3 images converted, 2 were there\n"
    done = run("batch", "in/*.exr", "-o", "{stem}.png", *TO_CUBE, "--channels", "A")
    assert done.returncode == 1 and "no channel 'A'" in done.stderr


def test_results_that_would_meet_are_refused_before_anything_runs(skies: Path) -> None:
    io.write("in/day/a.exr", np.ones((8, 16, 3), np.float32))
    line = bad("batch", "in/**/*.exr", "-o", "out/{stem}.exr", *TO_CUBE, code=2, says="several")
    assert "out/a.exr" in line
    over = ("batch", "in/a.exr", "-o", "in/day/a.exr", "in/day/b.exr", *TO_CUBE)
    bad(*over, code=2, says="several")
    bad(
        "batch",
        "in/*.exr",
        "in/day/a.exr",
        "-o",
        "in/day/{stem}.exr",
        *TO_CUBE,
        code=2,
        says="an input",
    )
    assert not Path("out").exists()


def test_wrong_usage(skies: Path) -> None:
    bad("batch", "none/*.exr", "-o", "{stem}.exr", *TO_CUBE, code=1, says="no file is as")
    bad("batch", "in/*.exr", "-o", "{day}.exr", *TO_CUBE, code=2, says="{dir}")
    bad("batch", "in/*.exr", "-o", "-", *TO_CUBE, code=2, says="--output")
    bad("batch", "in/*.exr", "-o", "out/{stem}.xyz", *TO_CUBE, code=1, says=".xyz")
    bad("batch", "in/*.exr", "-o", "{stem}.exr", *TO_CUBE, "--mips", code=2, says="--mips")
    bad("batch", *mirror("--scheduler", "tcp://127.0.0.1:1"), code=2, says="--jobs")
    bad("batch", "in/a.exr", "-o", "{stem}.exr", *TO_CUBE, "--from", "x", code=2, says="'x'")
    assert files(".") == ["in/a.exr", "in/day/b.exr", "in/day/c.exr"]


def test_results_among_the_sources_are_no_sources(skies: Path) -> None:
    beside = ("in/**/*.exr", "-o", "in/{dir}/{stem}_cube.exr", *TO_CUBE)
    good("batch", *beside)
    assert good("batch", *beside) == "0 of 3 images converted, 3 were there\n"
    assert len(files("in")) == 7


def test_a_file_a_face(skies: Path) -> None:
    faces = ("in/*.exr", "-o", "{stem}_{face}.png", *TO_CUBE, "--layout", "faces")
    good("batch", *faces)
    assert io.read("a_nz.png").shape == (16, 16, 3)
    Path("a_py.png").unlink()
    assert "1 of 1" in good("batch", *faces)
    assert "1 were there" in good("batch", *faces)


def test_warnings_of_workers_are_said_once(skies: Path) -> None:
    programs = ("--from", "latlong:blender", "--to", "cube:opengl", "--size", 8)
    done = run("batch", "in/**/*.exr", "-o", "out/{stem}.exr", *programs)
    assert done.returncode == 0
    assert done.stderr.splitlines() == [
        "blender (+z up, +y ahead) → opengl (+y up, -z ahead): turned by 90° about -x"
    ]


def killed(arguments: tuple[object, ...]) -> Done:
    """Run a batch, and kill the first worker that there is."""
    over = threading.Event()

    def kill() -> None:
        while not over.is_set():
            for child in multiprocessing.active_children():
                child.kill()
                return
            time.sleep(0.01)

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        return run("batch", *arguments)
    finally:
        over.set()
        killer.join()


def test_a_killed_worker_costs_a_try(skies: Path) -> None:
    done = killed(mirror("--retries", 0))
    assert done.returncode == 1
    line, summary = done.stderr.splitlines()
    assert line.endswith("the worker that had it was killed")
    assert summary == "2 of 3 images converted"
    for path in Path("out").rglob("*.exr"):
        path.unlink()
    done = killed(mirror())
    assert (done.returncode, done.stdout, done.stderr) == (0, "3 of 3 images converted\n", "")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs a group of processes")
def test_ctrl_c_leaves_whole_files_and_what_is_left_is_done_later(skies: Path) -> None:
    sky = np.abs(smooth(sm.directions("latlong", 256)))
    for k in range(12):
        io.write(f"in/{k}.exr", sky)
    command = ("*.exr", "-o", "../out/{stem}.exr", *TO_CUBE[:4], "--size", 256, "--filter", "area")
    running = subprocess.Popen(
        [sys.executable, "-m", "spheremap", "batch", *map(str, command), "--jobs", "1"],
        cwd="in",
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    manifest = Path("out") / MANIFEST
    while running.poll() is None and not manifest.exists():
        time.sleep(0.01)
    os.killpg(running.pid, signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert running.returncode == 130 and "Traceback" not in said
    there = [name for name in files() if name != MANIFEST]
    assert 0 < len(there) < 13 and not any(name.startswith(".") for name in there)
    assert all(io.read(f"out/{name}").shape == (768, 1024, 3) for name in there)
    os.chdir("in")
    left = 13 - sum("results" in entry for entry in entries(Path("../out") / MANIFEST))
    assert f"{left} of 13 images converted" in good("batch", *command)


@needs_terminal
def test_a_terminal_sees_how_many_are_done(skies: Path) -> None:
    shown, said = on_terminal("batch", *mirror(), stream="stderr", columns=120)
    assert "3/3" in shown and said == "3 of 3 images converted\n"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # connections that are closed when they are collected
def test_a_cluster_gives_the_same_bits(skies: Path) -> None:
    distributed = pytest.importorskip("distributed")
    Path("in/broken.exr").write_bytes(b"no image")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=2, processes=True, dashboard_address=None
    ) as cluster:
        address = ("--scheduler", cluster.scheduler_address, "--retries", "0")
        again = ("in/**/*.exr", "-o", "far/{dir}/{stem}.exr", *TO_CUBE, *address)
        whole = ("batch", *(str(word) for word in again))
        done = subprocess.run(
            [sys.executable, "-m", "spheremap", *whole], capture_output=True, text=True, check=False
        )
    assert done.returncode == 1
    line, summary = done.stderr.splitlines()
    assert line.startswith("error: in/broken.exr: cannot read ")
    assert summary == "3 of 4 images converted"
    Path("in/broken.exr").unlink()
    good("batch", *mirror())
    for name in ("a.exr", "day/b.exr", "day/c.exr"):
        assert np.array_equal(io.read(Path("far", name)), io.read(Path("out", name)))
