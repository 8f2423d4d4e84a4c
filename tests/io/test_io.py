"""Files: what goes in comes out, floats stay floats, and a failure leaves nothing behind."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from spheremap import io
from spheremap.io import images

pytest.importorskip("OpenImageIO", reason="files need OpenImageIO: pip install spheremap[cli]")


def noise(dtype: str, channels: int = 3, shape: tuple[int, int] = (5, 7)) -> np.ndarray:
    rng = np.random.default_rng(7)
    if dtype.startswith("uint"):
        return rng.integers(0, np.iinfo(dtype).max, (*shape, channels), dtype, endpoint=True)
    return (rng.standard_normal((*shape, channels)) * 100).astype(dtype)


@pytest.mark.parametrize(
    ("extension", "dtype"),
    [
        ("exr", "float16"),
        ("exr", "float32"),
        ("tif", "float32"),
        ("tif", "uint8"),
        ("tif", "uint16"),
        ("png", "uint8"),
        ("png", "uint16"),
    ],
)
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_what_goes_in_comes_out(tmp_path: Path, extension: str, dtype: str, channels: int) -> None:
    image = noise(dtype, channels)
    path = tmp_path / f"a.{extension}"
    io.write(path, image)
    back = io.read(path)
    assert back.dtype == image.dtype
    assert np.array_equal(back, image)
    assert os.listdir(tmp_path) == [path.name]


def test_exr_keeps_infinity_nan_and_negative_values(tmp_path: Path) -> None:
    image = np.array([[[np.nan, np.inf, -np.inf], [-3894.0, 0.0, 65504.0]]], np.float32)
    io.write(tmp_path / "a.exr", image)
    assert np.array_equal(io.read(tmp_path / "a.exr"), image, equal_nan=True)


def test_exr_keeps_extra_channels_and_their_names(tmp_path: Path) -> None:
    image = noise("float32", 5)
    names = ("R", "G", "B", "A", "depth")
    io.write(tmp_path / "a.exr", image, channels=names)
    assert io.channel_names(tmp_path / "a.exr") == names
    assert np.array_equal(io.read(tmp_path / "a.exr"), image)


def test_hdr_holds_light_to_its_own_precision(tmp_path: Path) -> None:
    image = np.abs(noise("float32"))
    io.write(tmp_path / "a.hdr", image)
    back = io.read(tmp_path / "a.hdr")
    assert back.dtype == np.float32
    # A shared exponent: a step of 1/128 of the largest channel at most.
    assert np.all(np.abs(back - image) <= image.max(axis=-1, keepdims=True) / 128)


def test_float64_goes_to_float32_and_integers_to_fractions(tmp_path: Path) -> None:
    image = noise("float64")
    io.write(tmp_path / "a.exr", image)
    assert np.array_equal(io.read(tmp_path / "a.exr"), image.astype(np.float32))
    io.write(tmp_path / "b.exr", np.array([[[0, 51, 255]]], np.uint8))
    assert np.array_equal(io.read(tmp_path / "b.exr"), np.array([[[0, 0.2, 1]]], np.float32))


def test_jpg_takes_the_upper_bits_rounded(tmp_path: Path) -> None:
    image = np.full((16, 16, 3), 257 * 100 + 120, np.uint16)
    io.write(tmp_path / "a.jpg", image, compression="jpeg:100")
    back = io.read(tmp_path / "a.jpg").astype(int)
    assert np.all(np.abs(back - 100) <= 1)


def test_alpha_is_not_multiplied_in(tmp_path: Path) -> None:
    image = np.array([[[200, 100, 50, 0], [200, 100, 50, 128]]], np.uint8)
    io.write(tmp_path / "a.png", image)
    assert np.array_equal(io.read(tmp_path / "a.png"), image)


def test_a_flat_array_is_one_channel(tmp_path: Path) -> None:
    image = noise("float32")[..., 0]
    io.write(tmp_path / "a.exr", image[:, ::-1])
    assert np.array_equal(io.read(tmp_path / "a.exr")[..., 0], image[:, ::-1])


def test_compression_is_passed_on(tmp_path: Path) -> None:
    flat = np.ones((64, 64, 3), np.float32)
    io.write(tmp_path / "none.exr", flat, compression="none")
    io.write(tmp_path / "zip.exr", flat, compression="zip")
    assert (tmp_path / "none.exr").stat().st_size > 5 * (tmp_path / "zip.exr").stat().st_size


@pytest.mark.parametrize("extension", ["png", "jpg"])
def test_floats_do_not_pass_for_eight_bits(tmp_path: Path, extension: str) -> None:
    with pytest.raises(ValueError, match=r"spheremap\.io\.tonemap"):
        io.write(tmp_path / f"a.{extension}", noise("float32"))
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("name", "channels", "message"),
    [
        ("a.xyz", 3, "unknown format '.xyz'"),
        ("a", 3, "unknown format ''"),
        ("a.hdr", 4, "holds 3 channels, the image has 4"),
        ("a.hdr", 1, "holds 3 channels, the image has 1"),
        ("missing/a.exr", 3, "no folder"),
    ],
)
def test_what_cannot_be_written_says_why(
    tmp_path: Path, name: str, channels: int, message: str
) -> None:
    with pytest.raises(OSError, match=message) as caught:
        io.write(tmp_path / name, noise("float32", channels))
    assert "\n" not in str(caught.value)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("shape", [(3,), (2, 0, 3), (2, 2, 2, 2)])
def test_a_shape_that_is_no_image(tmp_path: Path, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"`image` to have shape \(H, W\)"):
        io.write(tmp_path / "a.exr", np.zeros(shape, np.float32))


@pytest.mark.parametrize("dtype", ["bool", "int64", "complex64"])
def test_a_dtype_that_is_no_image(tmp_path: Path, dtype: str) -> None:
    with pytest.raises(ValueError, match=f"got {dtype}"):
        io.write(tmp_path / "a.exr", np.zeros((2, 2, 3), dtype))


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "a.exr").mkdir()
    with pytest.raises(OSError, match="it is a folder"):
        io.write(tmp_path / "a.exr", noise("float32"))
    with pytest.raises(OSError, match="cannot read"):
        io.read(tmp_path / "a.exr")


def test_missing_and_broken_files(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"no such file: .*nothing\.exr"):
        io.read(tmp_path / "nothing.exr")
    (tmp_path / "broken.exr").write_bytes(b"this is no image")
    with pytest.raises(OSError, match="cannot read") as caught:
        io.read(tmp_path / "broken.exr")
    assert "\n" not in str(caught.value)


def test_a_file_cut_short_is_an_error(tmp_path: Path) -> None:
    whole = tmp_path / "whole.exr"
    io.write(whole, noise("float32", 3, (64, 64)))
    (tmp_path / "cut.exr").write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    with pytest.raises(OSError, match="cannot read"):
        io.read(tmp_path / "cut.exr")


def test_a_failure_in_the_middle_leaves_the_old_file_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.exr"
    io.write(path, noise("float32"))
    before = path.read_bytes()

    def half(_oiio: object, place: Path, *_rest: object) -> None:
        place.write_bytes(b"half")
        raise OSError("the disk is full")

    monkeypatch.setattr(images, "_write_pixels", half)
    with pytest.raises(OSError, match="the disk is full"):
        io.write(path, noise("float32") + 1)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.exr"]


def test_the_file_appears_complete_under_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.exr"
    seen: list[tuple[bool, bool]] = []
    plain = os.replace

    def watched(source: Path, target: Path) -> None:
        seen.append((path.exists(), Path(source).suffix == ".exr"))
        plain(source, target)

    monkeypatch.setattr(os, "replace", watched)
    io.write(path, noise("float32"))
    assert seen == [(False, True)]
    assert io.read(path).shape == (5, 7, 3)


@pytest.mark.skipif(sys.platform == "win32", reason="symbolic links need rights on Windows")
def test_a_link_stays_a_link_and_permissions_follow_the_umask(tmp_path: Path) -> None:
    real, link = tmp_path / "real.exr", tmp_path / "link.exr"
    io.write(real, noise("float32"))
    link.symlink_to(real)
    io.write(link, noise("float32") * 2)
    assert link.is_symlink()
    assert np.array_equal(io.read(real), noise("float32") * 2)
    mask = os.umask(0)
    os.umask(mask)
    assert real.stat().st_mode & 0o777 == 0o666 & ~mask


def test_without_openimageio_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "OpenImageIO", None)
    with pytest.raises(ImportError, match=r"pip install spheremap\[cli\]"):
        io.read("a.exr")


def test_tonemap_is_monotonic_and_meets_its_ends() -> None:
    ramp = np.concatenate([[0.0], np.logspace(-6, 8, 500), [np.inf]]).astype(np.float32)
    picture = io.tonemap(ramp[np.newaxis])[0]
    assert picture.dtype == np.uint8
    assert np.all(np.diff(picture.astype(int)) >= 0)
    assert picture[0] == 0 and picture[-1] == 255
    # The stated curve in its own letters, at its white point and at mid gray.
    assert io.tonemap(np.array([[4.0, 3.9]]))[0, 0] == 255
    gray = 0.18 * (1 + 0.18 / 16) / 1.18
    assert io.tonemap(np.array([[0.18]]))[0, 0] == round(255 * (1.055 * gray ** (1 / 2.4) - 0.055))


def test_tonemap_of_the_unfit() -> None:
    assert io.tonemap(np.array([[np.nan, -1.0, -np.inf]])).tolist() == [[0, 0, 0]]
    assert io.tonemap(np.zeros((4, 4, 3)), exposure=None).max() == 0
    for dtype in ("uint8", "uint16", ">u2"):
        with pytest.raises(TypeError, match=r"linear light, got .*: `io.to_linear` makes it"):
            io.tonemap(np.zeros((4, 4, 3), dtype))
    # Other integers are light.
    assert np.array_equal(io.tonemap(np.eye(4, dtype=int)), io.tonemap(np.eye(4)))


def test_exposure_is_in_stops_and_automatic_exposure_ignores_the_scale() -> None:
    light = np.abs(noise("float32", 3, (16, 16)))
    assert np.array_equal(io.tonemap(light, exposure=2), io.tonemap(light * 4))
    dark, bright = (io.tonemap(light * k, exposure=None).astype(int) for k in (1e-3, 1e3))
    assert np.abs(dark - bright).max() <= 1


@pytest.mark.parametrize(("channels", "shown"), [(1, 1), (2, 1), (3, 3), (4, 3), (6, 3)])
def test_tonemap_takes_the_colors(channels: int, shown: int) -> None:
    light = np.abs(noise("float32", channels)) / 100
    assert np.array_equal(io.tonemap(light), io.tonemap(light[..., :shown]))
    assert io.tonemap(light).shape == (5, 7, shown)


def test_a_real_probe_is_read_as_light(data_folder: Path) -> None:
    probe = io.read(data_folder / "grace_probe.hdr")
    assert probe.shape == (1000, 1000, 3) and probe.dtype == np.float32
    assert probe.max() > 100 and probe.min() >= 0
    assert io.read(data_folder / "park.exr").dtype == np.float16
