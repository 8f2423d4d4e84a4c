"""Image files as other programs write them."""

from __future__ import annotations

import zlib
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


def put_panorama(path: Path, image: np.ndarray, **words: object) -> None:
    """Write a .png file with words of GPano."""
    put(path, image)
    words = {"ProjectionType": "equirectangular", **words}
    xmp = (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/">'
        '<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
        '<rdf:Description rdf:about="" xmlns:GPano="http://ns.google.com/photos/1.0/panorama/" '
        + " ".join(f'GPano:{name}="{value}"' for name, value in words.items())
        + "/></rdf:RDF></x:xmpmeta>"
    )
    data = path.read_bytes()
    chunk = b"iTXtXML:com.adobe.xmp\0\0\0\0\0" + xmp.encode()
    size, check = ((len(chunk) - 4).to_bytes(4, "big"), zlib.crc32(chunk).to_bytes(4, "big"))
    # After the signature and the header chunk.
    path.write_bytes(data[:33] + size + chunk + check + data[33:])
