"""exrenvmap, OpenEXR's own converter of environment maps (Debian's package `openexr`)."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

from . import openimageio_oracle


def convert(image: np.ndarray, source: str, target: str, width: int, folder: Path) -> np.ndarray:
    """Return an image of RGB as exrenvmap makes it: "l" is a latlong, "c" a column of faces."""
    path = openimageio_oracle.write(image, folder / "in.exr")
    # A narrow filter, so that places can be told from blur.
    options = [f"-{source}i", f"-{target}", "-w", str(width), "-f", "0.1", "5"]
    command = ["exrenvmap", *options, str(path), str(folder / "out.exr")]
    subprocess.run(command, check=True, capture_output=True)
    return openimageio_oracle.read(folder / "out.exr")[..., :3]
