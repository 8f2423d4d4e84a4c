"""Files larger than memory take what they were given, and a tenth."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from large_files import WATCH, store

pytest.importorskip("OpenImageIO")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="looks into /proc"),
]

SCRIPT = (
    WATCH
    + """
import sys
import numpy as np, spheremap as sm, spheremap.light

place, limit = sys.argv[1], int(sys.argv[2]) << 20

# What the first call of any size takes is there before.
sm.io.write(place + ".small.exr", np.ones((64, 128, 3), np.float32))
cross = sm.projection("cube", layout="cross")
sm.io.convert_file(place + ".small.exr", place + ".exr", "latlong", cross, memory=limit)
sm.io.convert_file(
    place + ".small.exr", place + ".exr", "latlong", cross, filter="ewa", memory=limit
)
sm.light.energy_file(place + ".small.exr", "latlong", memory=limit)
print(most_taken(lambda: {call}))
"""
)

# Results of 96 MB at most: to compress more noise would take most of the time.
CALLS = {
    "convert": "sm.io.convert_file(place, place + '.out.tif', 'latlong', cross, any_aspect=True, "
    "size=1152, memory=limit)",
    "strips": "sm.io.convert_file(place + '.strips.tif', place + '.out.tif', 'latlong', cross, "
    "any_aspect=True, size=1152, memory=limit)",
    "alpha": "sm.io.convert_file(place, place + '.out.tif', 'latlong', 'angular', alpha=2, "
    "any_aspect=True, size=1536, memory=limit)",
    "chain": "sm.io.convert_file(place, place + '.out.tif', 'latlong', cross, filter='ewa', "
    "any_aspect=True, size=768, memory=limit)",
    "energy": "sm.light.energy_file(place, 'latlong', any_aspect=True, memory=limit)",
}


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """Return a file in tiles, of 151 MB, beside which is one in strips."""
    place = str(tmp_path_factory.mktemp("large") / "sky.tif")
    band = np.random.default_rng(0).integers(0, 50_000, (256, 6144, 3), np.uint16)
    band[100:110, 100:110] = 65_535
    store(place + ".strips.tif", 4096, band, side=0)
    return store(place, 4096, band, side=256)


@pytest.mark.parametrize("what", CALLS)
def test_it_keeps_within_its_memory(large, what):
    script = SCRIPT.replace("{call}", CALLS[what])
    done = subprocess.run(
        [sys.executable, "-c", script, large, "128"], capture_output=True, text=True, check=True
    )
    taken = int(done.stdout) / 2**20
    # A tenth more is what the page grants.
    assert 8 < taken < 141, f"{taken:.0f} MiB"
