"""The light of files, part by part: the bits of what `energy` says of the whole."""

from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap.io import tiling
from spheremap.light import files

rng = np.random.default_rng(23)


def stored(place, p, size, dtype=np.float32):
    """Write an image with a sun, and return it as it is read."""
    image = rng.random((*p.shape(size), 3))
    column, row = p.directions_to_pixels([0.36, 0.48, -0.8], p.shape(size)).astype(int)
    image[row - 2 : row + 2, column - 2 : column + 3] = 90
    image[row + 20, column, 1] = -1
    if np.dtype(dtype).kind == "u":
        image = np.clip(image * 2, 0, 200)
    sm.io.write(place, image.astype(dtype))
    return sm.io.read(place)


@pytest.mark.parametrize(
    ("name", "size", "layout"),
    [("latlong", 600, None), ("cube", 400, "cross"), ("angular", 700, None), ("latlong", 60, None)],
)
@pytest.mark.parametrize(("suffix", "dtype"), [(".exr", np.float16), (".tif", np.uint8)])
def test_it_is_that_of_the_whole(tmp_path, name, size, layout, suffix, dtype):
    p = sm.projection(name, layout=layout)
    image = stored(tmp_path / f"a{suffix}", p, size, dtype)
    options = {"rotation": sm.rotation(30, 20, 10), "luminance": (1, 2, 0)}
    whole = sm.light.energy(image, p, **options)
    found = sm.light.energy_file(tmp_path / f"a{suffix}", p, memory=256 << 20, **options)
    assert str(found) == str(whole) and (found.sun is not None) == (size > 60)
    assert (found.luminance, found.negative) == (whole.luminance, whole.negative)
    np.testing.assert_array_equal(found.integral, whole.integral)
    np.testing.assert_array_equal(found.peak_direction, whole.peak_direction)
    if found.sun is not None:
        np.testing.assert_array_equal(found.sun.direction, whole.sun.direction)
        np.testing.assert_array_equal(found.sun.irradiance, whole.sun.irradiance)


def test_of_strips_that_do_not_fit_a_copy_in_tiles_is_read(tmp_path, monkeypatch):
    """Sheets of a row share strips, which would be decoded for each again."""
    made = []

    def in_tiles(*given):
        made.append(tiling.in_tiles(*given))
        return made[-1]

    monkeypatch.setattr(files, "in_tiles", in_tiles)
    monkeypatch.setattr(files, "_LEAST_MEMORY", 0)
    p = sm.projection("latlong")
    image = stored(tmp_path / "a.exr", p, 600)
    whole = sm.light.energy(image, p)
    # 512 rows of 1200 texels are 7 MB.
    for memory, copies in ((64 << 20, 0), (24 << 20, 1)):
        found = sm.light.energy_file(tmp_path / "a.exr", p, memory=memory)
        assert len(made) == copies
        np.testing.assert_array_equal(found.integral, whole.integral)
        assert found.peak == whole.peak
    assert not Path(made[0].files[0]).exists()


def test_few_texels_are_listed(tmp_path, monkeypatch):
    p = sm.projection("latlong")
    image = stored(tmp_path / "a.exr", p, 800)
    monkeypatch.setattr(files, "texels_around", lambda memory, channels: 5_000)
    found = sm.light.energy_file(tmp_path / "a.exr", p)
    exact = sm.light.energy(image, p)
    assert (found.peak, found.integral.tolist()) == (exact.peak, exact.integral.tolist())
    # Blocks of 4 texels, each of 0.225 degrees.
    assert np.degrees(np.arccos(found.sun.direction @ exact.sun.direction)) < 0.45
    # What a block's mean takes of its neighbors.
    assert found.sun.irradiance == pytest.approx(exact.sun.irradiance, rel=0.05)


def test_holes_are_named_or_skipped(tmp_path):
    image = stored(tmp_path / "a.exr", sm.projection("latlong"), 530)
    image[520, 900, 2] = np.nan
    sm.io.write(tmp_path / "a.exr", image)
    with pytest.raises(ValueError, match=r"at \(520, 900, 2\)"):
        sm.light.energy_file(tmp_path / "a.exr", "latlong")
    whole = sm.light.energy(image, "latlong", skipna=True)
    assert str(sm.light.energy_file(tmp_path / "a.exr", "latlong", skipna=True)) == str(whole)


@pytest.mark.parametrize(
    ("projection", "options", "said"),
    [
        ("cube", {}, "give it a layout"),
        ("angular", {}, "aspect|square|as wide"),
        ("latlong", {"memory": 1 << 20}, "at least 134217728 bytes"),
        ("latlong", {"luminance": (1, 2)}, "luminance"),
        ("latlong", {"negative": "drop"}, "negative"),
    ],
)
def test_what_is_wrong(tmp_path, projection, options, said):
    sm.io.write(tmp_path / "a.exr", np.ones((32, 64, 3), np.float32))
    with pytest.raises(ValueError, match=said):
        sm.light.energy_file(tmp_path / "a.exr", projection, **options)
