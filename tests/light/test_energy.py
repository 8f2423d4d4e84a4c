"""The energy report, and what the command line shows of it."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import LAYOUTS, each
from spheremap import _core

# Solid angles of lens maps have no closed form, and are good to 1e-10.
COVERED = 1e-9


@each(LAYOUTS)
def test_a_constant_image(case):
    p = case.make()
    report = sm.light.energy(np.full((*p.shape(12), 3), [1.0, 2.0, 4.0]), p)
    covered = p.covered_solid_angle
    assert report.solid_angle == pytest.approx(covered, rel=COVERED)
    np.testing.assert_allclose(report.integral, covered * np.array([1, 2, 4]), rtol=COVERED)
    # What is covered cancels in the mean: NumPy's own 1e-7 is far above sums of doubles.
    np.testing.assert_allclose(report.mean, [1, 2, 4])
    luminance = 0.2126 + 2 * 0.7152 + 4 * 0.0722
    # Sums of three doubles; `approx`'s own 1e-6 is far above.
    assert report.luminance == pytest.approx(luminance)
    assert report.peak == report.darkest == pytest.approx(luminance)
    assert report.dynamic_range == 0 and report.sun is None and report.negative == 0


def test_peak_range_negative_and_sun():
    image = np.full((32, 64, 3), 0.5, np.float32)
    image[5, 9] = 2048
    image[30, 1] = 0.125
    image[31, 2, 1] = -7
    report = sm.light.energy(image, "latlong")
    # Powers of two times the weights' sum, which is 1 but for rounding, and one texel's direction.
    assert report.peak == pytest.approx(2048)
    np.testing.assert_allclose(report.peak_direction, sm.directions("latlong", 32)[5, 9])
    assert report.dynamic_range == pytest.approx(14, abs=1e-5)
    assert report.negative == 1
    weight = sm.solid_angle("latlong", 32)
    # 2048 terms, doubles, in another order.
    np.testing.assert_allclose(report.integral, np.tensordot(weight, image, 2), rtol=1e-9)
    assert report.sun is not None
    # One texel above an even surround: its own solid angle but for rounding.
    assert report.sun.solid_angle == pytest.approx(weight[5, 9], rel=1e-6)
    text = str(report)
    for word in ("covers", "energy", "mean", "peak", "range", "negative", "sun", "stops"):
        assert word in text
    assert "14.0 stops" in text and "1 texels" in text


def test_without_light():
    report = sm.light.energy(np.zeros((4, 8)), "latlong")
    assert np.isnan(report.dynamic_range) and np.isnan(report.darkest)
    assert report.integral.tolist() == [0.0] and "nan stops" in str(report)


def test_what_lies_outside_the_disk_does_not_count(data_folder):
    oiio = pytest.importorskip("OpenImageIO")
    probe = np.asarray(oiio.ImageBuf(str(data_folder / "grace_probe.hdr")).get_pixels("float"))
    p = sm.projection("angular")
    want = sm.light.energy(probe, p)
    # The credit printed in the corner.
    outside = np.isnan(p.directions(1000)[..., 0])
    assert probe[outside].max() > 0
    probe[outside] = np.nan
    got = sm.light.energy(probe, p)
    assert np.array_equal(got.integral, want.integral) and got.peak == want.peak
    weight = _core.texel_weights(p, 1000)
    assert weight.sum() == pytest.approx(4 * np.pi, rel=COVERED) and not weight[outside].any()
    # 10⁶ doubles in another order; NumPy's own 1e-7 is far above.
    np.testing.assert_allclose(got.integral, np.tensordot(weight, np.nan_to_num(probe), 2))


@each(LAYOUTS)
def test_texel_weights_are_solid_angles_moved_inside(case):
    p = case.make()
    for n in (1, 2, 3, 10, 31):
        weight, solid_angle = _core.texel_weights(p, n), p.solid_angle(n)
        held = ~np.isnan(p.directions(n)[..., 0])
        assert weight.sum() == pytest.approx(p.covered_solid_angle, rel=COVERED)
        assert not weight[~held].any()
        assert (weight >= solid_angle)[held].all()
        # Only the texels along the rim gain anything.
        inner = held & (np.isnan(np.roll(p.directions(n)[..., 0], 1)) == 0)
        if held.all():
            assert np.array_equal(weight, solid_angle)
        assert inner.any() or n < 3


def test_bad_input():
    with pytest.raises(ValueError, match="shape"):
        sm.light.energy(np.ones((4, 8)), "cube")
    image = np.ones((4, 8))
    image[2, 3] = np.inf
    with pytest.raises(ValueError, match=r"1 NaN or infinite value, at \(2, 3\)"):
        sm.light.energy(image, "latlong")
    assert np.isfinite(sm.light.energy(image, "latlong", skipna=True).integral).all()


@pytest.fixture
def image_file(tmp_path):
    pytest.importorskip("OpenImageIO")
    from spheremap import io

    image = np.full((32, 64, 3), 0.5, np.float32)
    image[5, 9] = 2048
    image[0, 0] = np.nan
    path = tmp_path / "sky.exr"
    io.write(path, image)
    return path


def run(capsys, *arguments: object) -> tuple[int, str, str]:
    from spheremap.cli import app

    code = app.run([str(a) for a in arguments])
    said = capsys.readouterr()
    return code, said.out, said.err


def test_info_shows_it(image_file, capsys):
    code, out, _ = run(capsys, "info", image_file)
    assert code == 0 and "light     as latlong" in out
    for word in ("energy", "peak", "12.0 stops", "sun", "irradiance"):
        assert word in out
    code, out, _ = run(capsys, "info", image_file, "--from", "latlong:mitsuba")
    assert code == 0 and "light     as latlong" in out
    code, _, err = run(capsys, "info", image_file, "--from", "angular")
    assert code == 1 and "expected for example" in err
    code, _, err = run(capsys, "info", image_file, "--from", "angulr")
    assert code == 2 and "did you mean" in err


def test_info_of_what_fits_no_projection(tmp_path, capsys):
    pytest.importorskip("OpenImageIO")
    from spheremap import io

    io.write(tmp_path / "odd.exr", np.ones((7, 40, 3), np.float32))
    code, out, _ = run(capsys, "info", tmp_path / "odd.exr")
    assert code == 0 and "as it is" in out and "energy" not in out
