"""Colors and alpha from file to file: light where they are floats, as they were at the end."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from spheremap import io
from spheremap.cli.picture import straightened
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


AP0 = (0.7347, 0.2653, 0, 1, 0.0001, -0.077, 0.32168, 0.33767)


def test_a_picture_heeds_the_primaries_that_a_file_says(tmp_path: Path) -> None:
    source, out, png, shown = (tmp_path / name for name in ("a.exr", "b.exr", "c.png", "d.png"))
    image = np.full((8, 16, 3), 0.25, np.float32)
    image[..., 0] = 0.5
    io.write(source, image, metadata={"chromaticities": AP0})
    good("convert", source, out, *SAME)
    assert np.array_equal(io.read(out), image)
    # The file has them in float32.
    assert io.header(out).metadata["chromaticities"] == pytest.approx(AP0, rel=1e-6)
    # AP0 to Rec. 709 (D60 to D65, Bradford), as published by the Academy: its first row.
    red = 2.521686 * 0.5 - 1.134131 * 0.25 - 0.387555 * 0.25
    for place in (source, out):
        good("convert", place, png, *SAME, "--preview", shown)
        assert abs(int(io.read(png)[0, 0, 0]) - 255 * (1.055 * red ** (1 / 2.4) - 0.055)) <= 1
        expected = io.tonemap(np.full((1, 1, 3), red, np.float32))
        assert abs(int(io.read(shown)[0, 0, 0]) - int(expected[0, 0, 0])) <= 1
    assert "chromaticities" not in io.header(png).metadata
    good("convert", source, png, *SAME, "--colorspace", "lin_rec709_scene")
    assert io.read(png)[0, 0].tolist() == [188, 137, 137]


def test_a_preview_heeds_the_color_space(tmp_path: Path) -> None:
    source, out, shown = (tmp_path / name for name in ("a.exr", "b.exr", "c.png"))
    image = np.full((8, 16, 3), (0.5, 0.25, 0.125), np.float32)
    io.write(source, image)
    good("convert", source, out, *SAME, "--colorspace", "ACEScg", "--preview", shown)
    expected = io.tonemap(io.to_linear(image, color_space="ACEScg"))
    assert np.array_equal(io.read(shown), expected)
    assert not np.array_equal(expected, io.tonemap(image))
    picture = tmp_path / "d.png"
    io.write(picture, np.full((8, 16, 3), 128, np.uint8))
    out = tmp_path / "e.png"
    good("convert", picture, out, *SAME, "--colorspace", "lin_rec709_scene", "--preview", shown)
    # Linear 128/255 as sRGB: 187.6.
    assert np.all(io.read(shown) == 188) and np.all(io.read(out) == 128)


def test_a_preview_of_integers_heeds_the_exposure(tmp_path: Path) -> None:
    source, out, shown = (tmp_path / name for name in ("a.png", "b.png", "c.png"))
    io.write(source, np.full((8, 16, 3), 100, np.uint8))
    good("convert", source, out, *SAME, "--preview", shown)
    assert np.array_equal(io.read(shown), io.read(source))
    good("convert", source, out, *SAME, "--preview", shown, "--exposure", 1)
    light = 2 * float(srgb_to_linear(np.array(100 / 255)))
    assert np.all(np.abs(io.read(shown) - 255 * (1.055 * light ** (1 / 2.4) - 0.055)) <= 1)
    assert np.all(io.read(out) == 100)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("suffix", ["png", "jpg"])
def test_any_image_has_a_preview(count: int, suffix: str, tmp_path: Path) -> None:
    source, out, shown = (tmp_path / name for name in ("a.png", "b.png", f"c.{suffix}"))
    io.write(source, np.full((8, 16, count), 100, np.uint8))
    good("convert", source, out, *SAME, "--preview", shown)
    colors = 1 if count < 3 else 3
    assert io.read(shown).shape[-1] == (count if suffix == "png" else colors)


def test_alpha_is_of_colors_alone(tmp_path: Path) -> None:
    source, out, back = (tmp_path / name for name in ("a.exr", "b.tif", "c.exr"))
    image = np.full((8, 16, 5), (0.5, 1, 2, 0.5, 7), np.float32)
    io.write(source, image, channels=("R", "G", "B", "A", "Z"))
    good("convert", source, out, *SAME)
    assert io.read(out)[0, 0].tolist() == [1, 2, 4, 0.5, 7]
    good("convert", out, back, *SAME)
    assert np.array_equal(io.read(back), image)


def test_integers_beside_colors_keep_their_values(tmp_path: Path) -> None:
    image = np.full((8, 16, 5), (100, 50, 25, 128, 77), np.uint8)
    assert straightened(image, 3)[0, 0].tolist() == [199, 100, 50, 128, 77]
    turned = straightened(image[..., [3, 0, 1, 2, 4]], 0)
    assert turned[0, 0].tolist() == [128, 199, 100, 50, 77]


def test_other_channels_are_not_tone_mapped(tmp_path: Path) -> None:
    source, out = tmp_path / "a.exr", tmp_path / "b.tif"
    image = np.full((8, 16, 5), (0.5, 1, 2, 1, 0.25), np.float32)
    io.write(source, image, channels=("R", "G", "B", "A", "Z"))
    good("convert", source, out, *SAME, "--tonemap", "reinhard", "--bits", 8)
    assert np.array_equal(io.read(out)[..., :3], io.tonemap(image[..., :3]))
    assert io.read(out)[0, 0, 3:].tolist() == [255, 64]
