"""A file appears whole or not at all, whatever the disk does and whoever is killed."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast
from spheremap import io

pytest.importorskip("OpenImageIO", reason="files need OpenImageIO: pip install spheremap[cli]")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of files")

# A limit of 4096 bytes stands for a full disk: what is beyond it is not written.
FULL = """
    import resource, signal, sys
    import numpy as np
    from spheremap import io

    image = np.random.default_rng(1).random((256, 256, 3)).astype(np.float32)
    small = (image * 255).astype(np.uint8)
    place = sys.argv[1]
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
    try:
        if place.endswith((".dds", ".ktx2")):
            write = io.write_dds if place.endswith(".dds") else io.write_ktx2
            write(place, [image])
        else:
            io.write(place, image if place.endswith((".exr", ".hdr", ".tif")) else small)
    except OSError as error:
        print("OSError", error)
    else:
        print("written")
"""


@some_fast("kept", [False, True], fast=(True,))
@pytest.mark.parametrize("extension", ["exr", "hdr", "tif", "png", "dds", "ktx2"])
def test_a_full_disk_leaves_what_was_there(tmp_path: Path, extension: str, kept: bool) -> None:
    place = tmp_path / f"out.{extension}"
    if kept:
        place.write_bytes(b"before")
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(FULL), str(place)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr[-300:]
    assert done.stdout.startswith("OSError"), done.stdout
    assert len(done.stdout.splitlines()) == 1
    assert os.listdir(tmp_path) == ([place.name] if kept else [])
    if kept:
        assert place.read_bytes() == b"before"


def test_a_full_disk_does_not_end_the_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # libjpeg ends the process that it cannot write for, so it writes to memory. A limit of files is
    # one of files in memory, too, and cannot stand for a full disk here.
    def full(*_: object) -> bytes:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "read", full)
    with pytest.raises(OSError, match=r"cannot write '.*out.jpg': No space left on device"):
        io.write(tmp_path / "out.jpg", np.full((30, 40, 3), 9, np.uint8))
    assert os.listdir(tmp_path) == []


def test_what_a_killed_process_left_goes(tmp_path: Path) -> None:
    gone = subprocess.run([sys.executable, "-c", ""], check=True)
    assert gone.returncode == 0
    # No process has the largest number, and this one is alive.
    left = tmp_path / f".out.spheremap-part-{2**22 + 7}-0123abcd.exr"
    mine = tmp_path / f".out.spheremap-part-{os.getpid()}-0123abcd.exr"
    other = tmp_path / ".out.126d96eb.exr"
    for file in (left, mine, other):
        file.write_bytes(b"half")
    io.write(tmp_path / "new.exr", np.ones((2, 2, 3), np.float32))
    assert sorted(os.listdir(tmp_path)) == sorted([mine.name, other.name, "new.exr"])


def test_a_killed_write_leaves_nothing_that_stays(tmp_path: Path) -> None:
    code = """
        import os, signal, sys
        from pathlib import Path
        from spheremap.io.whole import written_whole

        def write(place):
            place.write_bytes(b"half")
            os.kill(os.getpid(), signal.SIGKILL)

        written_whole(Path(sys.argv[1]) / "a.exr", write)
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code), str(tmp_path)], check=False)
    assert done.returncode == -9 and len(os.listdir(tmp_path)) == 1
    io.write_dds(tmp_path / "b.dds", [np.ones((2, 2, 4), np.float32)])
    assert os.listdir(tmp_path) == ["b.dds"]


def test_symbolic_links_stay(tmp_path: Path) -> None:
    (tmp_path / "real.png").write_bytes(b"")
    (tmp_path / "link.png").symlink_to("real.png")
    io.write(tmp_path / "link.png", np.full((3, 4), 9, np.uint8))
    assert (tmp_path / "link.png").is_symlink()
    assert (io.read(tmp_path / "real.png") == 9).all()


@some_fast("extension", ["png", "jpg", "exr", "tif", "hdr"], fast=("png",))
def test_a_broken_file_is_one_line(tmp_path: Path, extension: str) -> None:
    whole = tmp_path / f"a.{extension}"
    image = np.random.default_rng(2).random((64, 128, 3)).astype(np.float32)
    io.write(whole, image if extension in ("exr", "tif", "hdr") else sm.io.tonemap(image))
    data = bytearray(whole.read_bytes())
    data[len(data) // 3 : len(data) // 3 + 40] = bytes(40)
    for broken in (data[: len(data) // 2], data):
        whole.write_bytes(bytes(broken))
        done = subprocess.run(
            [sys.executable, "-m", "spheremap.cli", "info", str(whole)],
            capture_output=True,
            text=True,
            timeout=60,
        )
        # Some damage cannot be seen; what can is our error, and no library's besides.
        assert done.returncode in (0, 1)
        assert len(done.stderr.splitlines()) == done.returncode, done.stderr
