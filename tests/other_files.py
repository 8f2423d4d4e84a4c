"""Image files as other programs write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

oiio = pytest.importorskip("OpenImageIO", reason="files need OpenImageIO")


def put(path: Path, image: np.ndarray, **attributes: object) -> None:
    """Write a file with windows (x, y, full_width ...) and whatever else it says."""
    height, width, count = image.shape
    kind = {"uint8": "uint8", "uint16": "uint16", "float32": "float"}[image.dtype.name]
    spec = oiio.ImageSpec(width, height, count, kind)
    for name, value in attributes.items():
        if hasattr(spec, name):
            setattr(spec, name, value)
        else:
            spec.attribute(name, value)
    sink = oiio.ImageOutput.create(str(path))
    assert sink.open(str(path), spec) and sink.write_image(image) and sink.close()


def put_parts(path: Path, values: dict[str, float]) -> None:
    """Write a file of several images of one value each, 8 x 16."""
    specs = []
    for name in values:
        spec = oiio.ImageSpec(16, 8, 3, "float")
        spec.attribute("oiio:subimagename", name)
        specs.append(spec)
    sink = oiio.ImageOutput.create(str(path))
    assert sink.open(str(path), tuple(specs))
    for k, value in enumerate(values.values()):
        if k:
            assert sink.open(str(path), specs[k], "AppendSubimage")
        sink.write_image(np.full((8, 16, 3), value, np.float32))
    sink.close()
