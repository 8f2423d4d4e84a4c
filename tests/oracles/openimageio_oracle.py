"""OpenImageIO's environment lookup and its light-probe conversion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from . import need


def openimageio() -> Any:
    return need("OpenImageIO")


def version() -> str:
    return f"OpenImageIO {openimageio().VERSION_STRING}"


def write(image: np.ndarray, path: Path) -> Path:
    """Write a float32 (H, W, C) image as it is."""
    oiio = openimageio()
    image = np.ascontiguousarray(image, np.float32)
    height, width, channels = image.shape
    out = oiio.ImageOutput.create(str(path))
    assert out is not None, oiio.geterror()
    assert out.open(str(path), oiio.ImageSpec(width, height, channels, "float")), out.geterror()
    assert out.write_image(image), out.geterror()
    assert out.close(), out.geterror()
    return path


def read(path: Path) -> np.ndarray:
    """Read a file as float32 (H, W, C)."""
    oiio = openimageio()
    file = oiio.ImageInput.open(str(path))
    assert file is not None, oiio.geterror()
    pixels = file.read_image("float")
    assert pixels is not None, file.geterror()
    file.close()
    return np.asarray(pixels)


def lookup(path: Path, directions: np.ndarray, z_up: bool = False) -> np.ndarray:
    """Bilinear environment lookups of a latlong file, (N, 3) float64.

    Sides must be above 64: a level that fits in one tile fades its first and last row.
    """
    oiio = openimageio()
    system = oiio.TextureSystem(False)  # its own cache: attributes and files of one test only
    system.attribute("autotile", 64)
    if z_up:
        system.attribute("latlong_up", "z")
    options = oiio.TextureOpt()
    options.mipmode = oiio.MipMode.NoMIP
    options.interpmode = oiio.InterpMode.Bilinear
    name, zero = str(path), (0.0, 0.0, 0.0)
    out = np.empty((len(directions), 3))
    for i, d in enumerate(np.asarray(directions, np.float64).tolist()):
        out[i] = system.environment(name, options, d, zero, zero, 3)
    assert not system.geterror()
    return out


def environment_file(image: np.ndarray, folder: Path, name: str) -> tuple[Path, np.ndarray]:
    """What ``maketx --envlatl`` makes of an image, and its top level read back.

    An .exr gets ``oiio:sampleborder``: texels on corners, with the poles and the seam evened out.
    """
    oiio = openimageio()
    source = write(image, folder / "source.tif")
    config = oiio.ImageSpec()
    config.set_format("float")
    out = folder / name
    assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxEnvLatl, str(source), str(out), config), (
        oiio.geterror()
    )
    return out, read(out)


def light_probe_to_latlong(probe: Path, out: Path) -> np.ndarray:
    """What ``maketx --lightprobe`` makes of an angular map: its latlong, read back."""
    oiio = openimageio()
    config = oiio.ImageSpec()
    config.attribute("maketx:nomipmap", 1)
    ok = oiio.ImageBufAlgo.make_texture(
        oiio.MakeTxEnvLatlFromLightProbe, str(probe), str(out), config
    )
    assert ok, oiio.geterror()
    return read(out)
