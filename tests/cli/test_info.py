"""`info` on images of any size: the numbers of the library, in little more memory than the file."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from spheremap.cli import files, radiance
from test_cli import good

resource = pytest.importorskip("resource", reason="needs the peak of a process's memory")


def sky(projection: sm.Projection, height: int) -> np.ndarray:
    """Return a smooth sky with a sun of 3 degrees and a texel below 0."""
    d = np.nan_to_num(projection.directions(files.size_of_height(projection, height)))
    sun = np.array([0.48, 0.6, -0.64])
    disk = np.clip((d @ sun - np.cos(np.radians(1.5))) * 1e5, 0, 1)[..., None]
    image = 1 + 0.5 * d + disk * [900, 800, 700]
    image[height // 2, 5 * height // 8] = -3
    return image.astype(np.float32)


@pytest.mark.parametrize(
    ("name", "layout"), [("latlong", None), ("angular", None), ("cube", "cross")]
)
def test_a_large_image_has_the_light_that_the_library_finds(
    name: str, layout: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    p = sm.projection(name, layout=layout)
    image = sky(p, 768)
    exact = sm.light.energy(image, p)
    monkeypatch.setattr(radiance, "FEW", 1 << 14)
    found = radiance.energy(image, p)
    # Reductions by area keep light to 1e-6 for a sun anywhere.
    assert found.integral == pytest.approx(exact.integral, rel=2e-6)
    assert found.luminance == pytest.approx(exact.luminance, rel=2e-6)
    assert found.solid_angle == pytest.approx(exact.solid_angle, rel=1e-11)  # of 2^20 terms
    assert (found.peak, found.darkest) == pytest.approx((exact.peak, exact.darkest), rel=1e-12)
    assert found.negative == exact.negative == 1
    assert found.peak_direction == pytest.approx(exact.peak_direction, abs=1e-12)
    assert found.sun is not None and exact.sun is not None
    # Half a texel of the image, at the sun: 0.25 degrees where the angular map's are largest.
    off = np.degrees(np.arccos(min(1.0, float(found.sun.direction @ exact.sun.direction))))
    assert off < 0.25
    # The edge of a sun of 3 degrees is a tenth of its disk at these texels.
    assert found.sun.irradiance == pytest.approx(exact.sun.irradiance, rel=0.1)


def test_nan_and_infinity_count_as_0_in_a_large_image(monkeypatch: pytest.MonkeyPatch) -> None:
    p = sm.projection("latlong")
    image = sky(p, 256)
    image[3, 4], image[200, 100] = np.nan, np.inf
    exact = sm.light.energy(image, p, skipna=True)
    monkeypatch.setattr(radiance, "FEW", 1 << 10)
    found = radiance.energy(image, p)
    assert found.integral == pytest.approx(exact.integral, rel=2e-6)  # as above
    assert found.peak == exact.peak and np.isnan(image[3, 4]).all()


def test_info_takes_less_than_three_times_the_texels(tmp_path: Path) -> None:
    image = np.ones((2048, 4096, 3), np.float16)
    image[700:704, 100:104] = 20000
    io.write(tmp_path / "sky.exr", image)
    script = (
        "import resource, sys, OpenImageIO, spheremap.light\n"
        "from spheremap.cli import app\n"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "app.parser_of(['info'])\n"
        "before = peak()\n"
        "code = app.run(['info', sys.argv[1]])\n"
        "print('peak', code, peak() - before)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "sky.exr")],
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    _, code, grown = done.stdout.splitlines()[-1].split()
    assert code == "0" and "sun       toward" in done.stdout
    assert int(grown) * 1024 < 3 * image.nbytes


def test_the_table_is_that_of_the_numbers(tmp_path: Path) -> None:
    image = np.arange(40 * 80 * 2, dtype=np.float32).reshape(40, 80, 2) - 7
    io.write(tmp_path / "a.exr", image, channels=("U", "V"))
    rows = {
        row[0]: row[1:] for row in map(str.split, good("info", tmp_path / "a.exr").splitlines())
    }
    for k, name in enumerate("UV"):
        values = image[..., k]
        numbers = f"{values.min():g} {values.max():g} {values.mean(dtype=float):.6g}".split()
        assert rows[name] == [*numbers, "0", "0", str((values < 0).sum())]
