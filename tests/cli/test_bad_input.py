"""What people give by mistake, and files that are stranger than they look."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from other_files import put
from spheremap import io
from test_cli import bad, good

SAME = ("--from", "latlong", "--to", "latlong", "--filter", "nearest")


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    path = tmp_path / "sky.exr"
    io.write(path, np.linspace(0, 2, 8 * 16 * 3, dtype=np.float32).reshape(8, 16, 3))
    return path


def test_a_folder_is_no_image(tmp_path: Path) -> None:
    folder = tmp_path / "a.exr"
    folder.mkdir()
    for command in (("info",), ("identify", folder), ("bake",)):
        more = (tmp_path / "out",) if command == ("bake",) else ()
        bad(*command, folder, *more, code=1, says="it is a folder")
    bad("convert", folder, tmp_path / "o.exr", *SAME, code=1, says="it is a folder")


def test_premultiplied_integers_keep_their_colors(tmp_path: Path) -> None:
    """A TIFF file of associated alpha: half covered by a color whose light is known."""
    source = tmp_path / "a.tif"
    image = np.full((8, 16, 4), (100, 50, 25, 128), np.uint8)
    image[0] = 0
    put(source, image)
    assert io.header(source).alpha == "premultiplied"
    good("convert", source, tmp_path / "a.png", *SAME)
    straight = io.read(tmp_path / "a.png")
    # 100·255/128 = 199.2, 50·255/128 = 99.6, 25·255/128 = 49.8
    assert straight[1, 0].tolist() == [199, 100, 50, 128] and not straight[0].any()
    good("convert", source, tmp_path / "a.exr", *SAME)
    light = io.to_linear(straight, alpha=3)
    light[..., :3] *= light[..., 3:]
    assert np.array_equal(io.read(tmp_path / "a.exr"), light)


@pytest.mark.parametrize("suffix", ["bmp", "png", "tga", "webp"])
def test_straight_alpha_is_known_for_what_it_is(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{suffix}"
    # Brighter than alpha: no premultiplied color is.
    image = np.full((8, 16, 4), (200, 100, 50, 128), np.uint8)
    more = {"compression": "lossless"} if suffix == "webp" else {}
    put(path, image, **{"oiio:UnassociatedAlpha": 1, **more})
    assert io.header(path).alpha == "straight"


def test_light_is_without_alpha_everywhere(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    image = np.full((8, 16, 4), (188, 188, 188, 128), np.uint8)
    io.write(path, image)
    said = good("info", path)
    (mean,) = (line.split() for line in said.splitlines() if line.startswith("  mean"))
    assert mean[0] == "mean" and mean[4] == "luminance"
    light = float(io.to_linear(image)[0, 0, 0]) * 128 / 255
    # Two factors and their product as half floats of 11 bits.
    assert float(mean[1]) == pytest.approx(light, rel=3 * 2**-12)
    io.write(path, image[..., [0, 3]])
    assert mean[1] in good("info", path)


def test_formats_without_alpha_say_so_and_gray_is_of_three_colors(tmp_path: Path) -> None:
    source = tmp_path / "a.png"
    io.write(source, np.full((8, 16, 2), (188, 128), np.uint8))
    for suffix in ("jpg", "hdr"):
        out = tmp_path / f"o.{suffix}"
        bad("convert", source, out, *SAME, code=1, says="no alpha: --drop-alpha")
        good("convert", source, out, *SAME, "--drop-alpha")
    light = io.read(tmp_path / "o.hdr")
    assert light.shape == (8, 16, 3) and np.ptp(light, axis=-1).max() == 0
    good("convert", source, tmp_path / "o.dds", *SAME)
    texels = np.frombuffer((tmp_path / "o.dds").read_bytes()[128:], np.float16).reshape(8, 16, 4)
    assert np.ptp(texels[..., :3], axis=-1).max() == 0
    # Half floats have 11 bits.
    assert texels[..., 3] == pytest.approx(128 / 255, rel=2**-11)


@pytest.mark.parametrize("stops", ["nan", "inf", "-inf"])
def test_an_exposure_is_a_number(stops: str, sky: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.png"
    bad("convert", sky, out, *SAME, "--exposure", stops, code=2, says="--exposure")
    ball = ("ball", sky, "-o", out, "--rim", "8,4,3")
    bad(*ball, "--exposure", stops, code=2, says="--exposure")
    bad(*ball[:-1], f"{stops},4,3", code=2, says="--rim is X,Y,R")
    assert os.listdir(tmp_path) == ["sky.exr"]


def test_far_too_much_exposure_is_white_and_black(sky: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.png"
    for stops, value in ((5000, 255), (-5000, 0)):
        for more in ((), ("--tonemap", "reinhard")):
            good("convert", sky, out, *SAME, "--exposure", stops, *more)
            lit = io.read(out)[io.read(sky) > 0]
            assert np.all(lit == value)


def test_a_compression_that_a_format_has_not_is_an_error(sky: Path, tmp_path: Path) -> None:
    for suffix, word in (("exr", "purple"), ("tif", "dwaa"), ("hdr", "zip"), ("exr", "jpeg:90")):
        out = tmp_path / f"o.{suffix}"
        bad("convert", sky, out, *SAME, "--compression", word, code=1, says="--compression")
        with pytest.raises(ValueError, match="`compression`"):
            io.write(out, np.ones((2, 4, 3), np.float32), compression=word)
    assert os.listdir(tmp_path) == ["sky.exr"]


@pytest.mark.parametrize("suffix", [".exr", ".tif", ".jpg"])
def test_each_compression_is_the_one_of_the_file(suffix: str, tmp_path: Path) -> None:
    oiio = pytest.importorskip("OpenImageIO", reason="files need OpenImageIO")
    image = np.ones((8, 16, 3), np.float32 if suffix == ".exr" else np.uint8)
    for word in sm.io.images._COMPRESSIONS[suffix]:
        io.write(tmp_path / f"a{suffix}", image, compression=word)
        file = oiio.ImageInput.open(str(tmp_path / f"a{suffix}"))
        # The reader of .jpg, which has but one, does not say.
        assert file.spec().getattribute("compression") == (None if suffix == ".jpg" else word)
        file.close()


def test_one_texel_is_an_image(tmp_path: Path) -> None:
    source, out = tmp_path / "a.png", tmp_path / "o.png"
    io.write(source, np.full((1, 1, 3), 99, np.uint8))
    good("convert", source, out, "--from", "octahedral", "--to", "latlong", "--size", 4)
    assert np.all(io.read(out) == 99)
    assert "1 x 1" in good("info", source)
    bad("bake", source, out.with_suffix(""), "--from", "octahedral", code=1, says="--order 2")
