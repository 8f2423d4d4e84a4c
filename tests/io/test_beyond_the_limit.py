"""Images that OpenImageIO would not open by itself: larger than the machine's memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from spheremap import io
from spheremap.io import opened

oiio = pytest.importorskip("OpenImageIO")


@pytest.fixture
def one_megabyte() -> Iterator[None]:
    """A machine that has no more."""
    limit = oiio.get_int_attribute("limits:imagesize_MB", 0)
    opened._most.cache_clear()
    oiio.attribute("limits:imagesize_MB", 1)
    yield
    opened._most.cache_clear()
    oiio.attribute("limits:imagesize_MB", limit)


@pytest.mark.usefixtures("one_megabyte")
@pytest.mark.parametrize("suffix", [".tif", ".exr"])
def test_parts_of_a_file_are_read_however_large_it_is(suffix: str, tmp_path: Path) -> None:
    sky = np.random.default_rng(0).random((512, 1024, 3), np.float32)
    place, target = tmp_path / f"sky{suffix}", tmp_path / "octahedral.exr"
    io.write(place, sky)
    with pytest.raises(OSError, match=r"takes? 0.0 GB, more than the 0.0 .* part by part"):
        io.read(place)
    assert io.header(place).width == 1024
    io.convert_file(place, target, "latlong", "octahedral", size=64, memory=1 << 27)
    wanted = sm.convert(sky, "latlong", "octahedral", size=64)
    np.testing.assert_array_equal(io.read(target), wanted)
