"""Colors and alpha from file to file: light where they are floats, as they were at the end."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from spheremap import io
from test_cli import bad, good

SAME = ("--from", "latlong", "--to", "latlong", "--filter", "nearest")


def ramps(dtype: str = "uint8") -> np.ndarray:
    rows = np.linspace(0, np.iinfo(dtype).max, 64 * 128).reshape(64, 128)
    return np.stack([rows, rows[:, ::-1], rows[::-1]], -1).astype(dtype)


def srgb_to_linear(x: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1."""
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("suffix", ["jpg", "png", "tif"])
def test_there_and_back_is_within_one_code_value(suffix: str, tmp_path: Path) -> None:
    source, light, back = (tmp_path / name for name in (f"a.{suffix}", "l.exr", f"b.{suffix}"))
    io.write(source, ramps(), compression="jpeg:98" if suffix == "jpg" else None)
    good("convert", source, light, *SAME)
    values = io.read(source)
    # The library's curve is OpenColorIO's, in float32 and by a fast power: 2.5e-4 of a value.
    assert io.read(light) == pytest.approx(srgb_to_linear(values / 255), rel=3e-4, abs=1e-6)
    quality = ("--compression", "jpeg:100") if suffix == "jpg" else ()
    good("convert", light, back, *SAME, "--bits", 8, *quality)
    # A second JPEG rounds its own coefficients and subsamples colors: what it does to the same
    # values when it is given them directly is not ours.
    expected = values
    if suffix == "jpg":
        io.write(tmp_path / "c.jpg", values, compression="jpeg:100")
        expected = io.read(tmp_path / "c.jpg")
    assert np.abs(io.read(back).astype(int) - expected).max() <= 1


def test_16_bits_come_back(tmp_path: Path) -> None:
    source, light, back = (tmp_path / name for name in ("a.png", "l.exr", "b.png"))
    io.write(source, ramps("uint16"))
    good("convert", source, light, *SAME)
    good("convert", light, back, *SAME, "--bits", 16)
    # 2.5e-4 of the curve, there and back, of 65535 near white; it mostly cancels.
    assert np.abs(io.read(back).astype(int) - io.read(source)).max() <= 16


def test_a_color_space_may_be_said(tmp_path: Path) -> None:
    source, out = tmp_path / "a.png", tmp_path / "a.exr"
    io.write(source, ramps())
    good("convert", source, out, *SAME, "--colorspace", "linear")
    assert io.read(out) == pytest.approx(io.read(source) / 255, rel=1e-6)  # a rounding of float32
    bad("convert", source, out, *SAME, "--colorspace", "purple", code=1, says="purple")


def test_white_is_cut_or_tone_mapped(tmp_path: Path) -> None:
    source, out = tmp_path / "a.exr", tmp_path / "a.png"
    image = np.full((8, 16, 3), 2.0, np.float32)
    image[0, 0] = [np.nan, np.inf, -1]
    io.write(source, image)
    good("convert", source, out, *SAME)
    assert np.all(io.read(out)[1:] == 255) and io.read(out)[0, 0].tolist() == [0, 255, 0]
    good("convert", source, out, *SAME, "--exposure", -1)
    assert np.all(io.read(out)[1:] == 255)
    good("convert", source, out, *SAME, "--tonemap", "reinhard")
    assert np.array_equal(io.read(out), io.tonemap(image))
    bad("convert", source, out, *SAME, "--tonemap", "filmic", code=2, says="reinhard")
    other = tmp_path / "b.png"
    bad("convert", out, other, *SAME, "--tonemap", "reinhard", code=2, says="integers stay")
    bad("convert", out, other, *SAME, "--exposure", 1, code=2, says="integers stay")


def test_alpha_is_straight_in_png_and_premultiplied_in_exr(tmp_path: Path) -> None:
    source, light, back = (tmp_path / name for name in ("a.png", "l.exr", "b.png"))
    image = np.empty((16, 32, 4), np.uint8)
    image[...] = (200, 100, 50, 128)
    image[:, 16:] = (10, 250, 30, 0)
    io.write(source, image)
    good("convert", source, light, *SAME)
    values = io.read(light)
    cover = 128 / 255
    expected = [*(srgb_to_linear(np.array([200, 100, 50]) / 255) * cover), cover]
    assert values[3, 3] == pytest.approx(expected, rel=3e-4)  # as above
    assert np.all(values[:, 16:] == 0)
    good("convert", light, back, *SAME)
    assert np.abs(io.read(back)[:, :16].astype(int) - image[:, :16]).max() <= 1
    assert "straight" in good("info", source) and "premultiplied" in good("info", light)


def test_hidden_colors_do_not_bleed(tmp_path: Path) -> None:
    source, out = tmp_path / "a.png", tmp_path / "b.png"
    image = np.zeros((16, 32, 4), np.uint8)
    image[:, :16] = (200, 100, 50, 255)
    image[:, 16:] = (0, 255, 0, 0)
    io.write(source, image)
    good("convert", source, out, "--from", "latlong", "--to", "octahedral", "--size", 32)
    result = io.read(out)
    seen = result[result[..., 3] > 0]
    assert np.abs(seen[:, :3].astype(int) - (200, 100, 50)).max() <= 1


def test_info_sums_light_of_what_is_encoded(tmp_path: Path) -> None:
    io.write(tmp_path / "a.png", np.full((8, 16, 3), 188, np.uint8))
    said = good("info", tmp_path / "a.png")
    assert "colors    srgb_rec709_scene" in said
    mean = float(next(x for x in said.splitlines() if x.startswith("  mean")).split()[-1])
    assert mean == pytest.approx(float(srgb_to_linear(np.array(188 / 255))), rel=1e-3)  # 4 digits


def test_alpha_of_floats_is_straight_in_tif(tmp_path: Path) -> None:
    source, out = tmp_path / "a.exr", tmp_path / "a.tif"
    image = np.empty((8, 16, 4), np.float32)
    image[...] = (0.5, 1, 2, 0.5)
    io.write(source, image, channels=("R", "G", "B", "A"))
    good("convert", source, out, *SAME)
    assert io.read(out)[0, 0].tolist() == [1, 2, 4, 0.5]
    good("convert", out, source, *SAME)
    assert np.array_equal(io.read(source), image)


def test_other_primaries_stay_among_floats_and_are_turned_for_a_picture(tmp_path: Path) -> None:
    source, out, png = (tmp_path / name for name in ("a.exr", "b.exr", "c.png"))
    image = np.full((8, 16, 3), 0.25, np.float32)
    image[..., 0] = 0.5
    io.write(source, image)
    good("convert", source, out, *SAME, "--colorspace", "ACEScg")
    assert np.array_equal(io.read(out), image)
    good("convert", source, png, *SAME, "--colorspace", "ACEScg")
    # AP1 to Rec. 709 (D60 to D65, Bradford), as published by the Academy: its first row.
    red = 1.705051 * 0.5 - 0.621792 * 0.25 - 0.083259 * 0.25
    encoded = 1.055 * red ** (1 / 2.4) - 0.055
    assert abs(int(io.read(png)[0, 0, 0]) - 255 * encoded) <= 1
