"""HiPS, how sky surveys are published: HEALPix tiles of all orders from 0.

A tile of order k is one pixel of nside 2^k and holds those of nside 2^k · width in it. Its columns
go north-west and its rows, from the top of a picture, north-east [1]_; FITS counts rows from the
bottom. So the north is at the lower right, and the east, seen from inside, left of it.

References
----------
.. [1] P. Fernique et al., "HiPS - Hierarchical Progressive Survey", IVOA Recommendation 1.0, 2017;
   figure 9 and the WCS keywords of an order-0 tile.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import UTC, datetime
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import _core
from .._progress import part
from .._threads import on_all_threads
from ..healpix import frame_rotation
from ..map.named import projection
from .colors import light
from .pyramid import Pyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .job import Job

__all__ = ["FRAMES", "hips"]

# The words of HiPS for frames, and ours.
FRAMES = {"equatorial": "icrs", "galactic": "galactic", "ecliptic": "ecliptic"}
# Tiles of this order lie in one file as well, each as large as this.
_ALLSKY, _THUMB = 3, 64
_SHARE = 0.005


class _Tile(NamedTuple):
    """A tile's name, what it holds as a picture, and where it is: face, column, row of tiles."""

    name: str
    pixels: NDArray[Any]
    number: int
    place: tuple[int, int, int]


def hips(job: Job) -> Pyramid:
    """Write a HiPS: all orders, the preview of order 3, a page, and ``properties``."""
    sky = projection("healpix:healpy")
    order = max(0, -(-job.wanted(sky) // job.tile_size) - 1).bit_length()
    side = job.tile_size << order
    with part(0.0, 0.5):
        # NaN is what no program shows, and alpha where there are no NaN.
        faces = job.converted(sky, side, fill=np.nan if job.image.dtype.kind == "f" else 0.0)
    written, seen = 0, list[int]()
    with part(0.5, 1.0):
        for k in range(order, -1, -1):
            found = [tile for tile in _tiles(_stored(job, faces), k) if _is_seen(tile, faces)]
            on_all_threads(partial(_write, job, k), found)
            written += len(found)
            seen = [tile.number for tile in found] if k == order else seen
            if k == 0:
                values = faces
            _write_allsky(job, faces, order)
            if k:
                faces = _halved(faces)
        while faces.shape[1] > _THUMB << _ALLSKY and order >= _ALLSKY:
            faces = _halved(faces)
            _write_allsky(job, faces, order)
        # Pictures need no astropy, and it alone writes this.
        if job.extension == "fits" or find_spec("astropy") is not None:
            from .fits import moc

            job.folder.data("Moc.fits", moc(seen, order, job.frame))
        if job.page:
            job.folder.page("hips")
    said = _properties(job, order, values, len(seen) / (12 * 4**order))
    lines = [f"{name:<20} = {value}\n" for name, value in said.items()]
    manifest = job.folder.data("properties", "".join(lines).encode())
    return Pyramid(manifest, (12, side, side), order + 1, written)


def _tiles(faces: NDArray[Any], order: int) -> Iterator[_Tile]:
    """Yield the tiles of an order; u of `healpix` goes north-east and v north-west."""
    width = faces.shape[1] >> order
    for face in range(12):
        for row in range(1 << order):
            for column in range(1 << order):
                # The binary digits of both in turn.
                number = face * 4**order + int(f"{column:b}", 4) + 2 * int(f"{row:b}", 4)
                across = slice(column * width, (column + 1) * width)
                block = faces[face, row * width : (row + 1) * width, across]
                folder = f"Norder{order}/Dir{number // 10_000 * 10_000}"
                name = f"{folder}/Npix{number}"
                yield _Tile(name, block.swapaxes(0, 1), number, (face, column, row))


def _is_seen(tile: _Tile, faces: NDArray[Any]) -> bool:
    """Tell whether anything is known in a tile of light."""
    face, column, row = tile.place
    width = tile.pixels.shape[0]
    block = faces[face, row * width :, column * width :][:width, :width]
    return faces.dtype.kind != "f" or not np.isnan(block).all()


def _halved(faces: NDArray[Any]) -> NDArray[np.float32]:
    """Return each four pixels' mean light; of those that are known, where some are."""
    n = faces.shape[1] // 2
    out = np.empty((12, n, n, faces.shape[-1]), np.float32)
    for face, held in zip(faces, out, strict=True):
        bright = light(face)
        quads = [bright[j::2, i::2] for j in (0, 1) for i in (0, 1)]
        np.multiply(quads[0] + quads[1] + quads[2] + quads[3], np.float32(0.25), out=held)
        some = np.isnan(held)
        if some.any():
            known = sum(~np.isnan(quad) for quad in quads)
            total = sum(np.nan_to_num(quad, posinf=np.inf, neginf=-np.inf) for quad in quads)
            mean = total / np.maximum(known, 1)
            held[some] = np.where(known > 0, mean, np.nan)[some]
    return out


def _write(job: Job, order: int, tile: _Tile) -> None:
    if job.extension != "fits":
        job.folder.picture(f"{tile.name}.{job.extension}", tile.pixels)
        return
    # Here, as astropy takes time to import.
    from .fits import fits, place

    cards = place(job.frame, order, tile.number, tile.place, tile.pixels.shape[0])
    job.folder.data(f"{tile.name}.fits", fits(tile.pixels[::-1, :, 0], cards))


def _stored(job: Job, pixels: NDArray[Any]) -> NDArray[Any]:
    """Return what files hold: numbers, or a picture, in .png with alpha where some are missing."""
    if job.extension == "fits":
        return pixels
    picture = job.look.picture(pixels)
    if job.extension == "jpg" or pixels.dtype.kind != "f":
        return picture
    known = ~np.isnan(pixels).any(axis=-1, keepdims=True)
    if known.all():
        return picture
    return np.concatenate([picture, known.astype(np.uint8) * np.uint8(255)], axis=-1)


def _write_allsky(job: Job, faces: NDArray[Any], order: int) -> None:
    """Write the tiles of order 3 side by side, of faces of the size that they have there."""
    width = min(job.tile_size, _THUMB)
    if order < _ALLSKY or faces.shape[1] != width << _ALLSKY:
        return
    count = 12 * 4**_ALLSKY
    columns = int(count**0.5)
    rows = -(-count // columns)
    blank = np.nan if faces.dtype.kind == "f" else 0
    sky = np.full((rows * width, columns * width, faces.shape[-1]), blank, faces.dtype)
    for tile in _tiles(faces, _ALLSKY):
        row, column = divmod(tile.number, columns)
        sky[row * width :, column * width :][:width, :width] = tile.pixels
    name = f"Norder{_ALLSKY}/Allsky"
    if job.extension != "fits":
        job.folder.picture(f"{name}.{job.extension}", _stored(job, sky))
        return
    from .fits import fits

    job.folder.data(f"{name}.fits", fits(sky[::-1, :, 0], {}))


def _properties(job: Job, order: int, values: NDArray[Any], seen: float) -> dict[str, str]:
    """Return what ``properties`` says, with what the caller says instead."""
    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%MZ")
    word = re.sub(r"[^A-Za-z0-9_.-]+", "-", job.title).strip("-") or "sky"
    middle = frame_rotation(FRAMES[job.frame], "icrs") @ [1.0, 0.0, 0.0]  # type: ignore[arg-type]
    said = {
        "creator_did": f"ivo://unregistered/P/{word}",
        "obs_title": job.title,
        "dataproduct_type": "image",
        "hips_version": "1.4",
        "hips_builder": f"spheremap {_core.__version__}",
        "hips_creation_date": now,
        "hips_release_date": now,
        "hips_status": "public master clonableOnce",
        "hips_frame": job.frame,
        "hips_order": str(order),
        "hips_order_min": "0",
        "hips_tile_width": str(job.tile_size),
        "hips_tile_format": {"jpg": "jpeg"}.get(job.extension, job.extension),
        "hips_sampling": str(job.filter),
        "hips_hierarchy": "mean",
        "hips_initial_ra": f"{np.degrees(np.arctan2(middle[1], middle[0])) % 360:.5f}",
        "hips_initial_dec": f"{np.degrees(np.arcsin(middle[2])):.5f}",
        "hips_initial_fov": "180",
        "hips_pixel_scale": f"{np.degrees(np.sqrt(np.pi / 3)) / (job.tile_size << order):.9g}",
        "moc_sky_fraction": f"{seen:.6g}",
    }
    if job.extension == "fits":
        said["hips_pixel_bitpix"] = "-32"
        known = values[np.isfinite(values)]
        if known.size:
            low, high = np.quantile(known, [_SHARE, 1 - _SHARE])
            said["hips_pixel_cut"] = f"{low:.6g} {high:.6g}"
    elif job.image.shape[-1] == 3:
        said["dataproduct_subtype"] = "color"
    return said | dict(job.properties)
