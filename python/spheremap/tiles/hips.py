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

import math
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import _core
from .._progress import counted
from ..healpix import frame_rotation
from ..map.named import projection
from ..resample.seen import Rectangle, tiles
from .colors import light
from .cutting import each, whole
from .levels import levels
from .pyramid import Pyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._projection import Projection
    from .job import Job
    from .level import Level

__all__ = ["FRAMES", "hips"]

# The words of HiPS for frames, and ours.
FRAMES = {"equatorial": "icrs", "galactic": "galactic", "ecliptic": "ecliptic"}
# Tiles of this order lie in one file as well, each as large as this.
_ALLSKY, _THUMB = 3, 64
_SHARE = 0.005
# Rows and columns of a smaller order that are made at a time.
_HALVED = 512


class _Tile(NamedTuple):
    """A tile's name and number, where it is (face, column, row of tiles), and its pixels."""

    name: str
    number: int
    place: tuple[int, int, int]
    part: Rectangle


def hips(job: Job) -> Pyramid:
    """Write a HiPS: all orders, the preview of order 3, a page, and ``properties``."""
    sky = projection("healpix:healpy")
    order = max(0, -(-job.wanted(sky) // job.tile_size) - 1).bit_length()
    side = job.tile_size << order
    shapes = [sky.shape(job.tile_size << k) for k in range(order, -1, -1)]
    while order >= _ALLSKY and shapes[-1][1] > _THUMB << _ALLSKY:
        shapes.append(sky.shape(shapes[-1][1] // 2))
    written, seen, cuts = 0, list[int](), None
    # NaN is what no program shows, and alpha where there are no NaN.
    missing = np.nan if job.image.dtype.kind == "f" else 0.0
    for at, level in enumerate(levels(job, sky, shapes, fill=missing, smaller=_halved)):
        k = order - at
        if k >= 0:
            found = _write_tiles(job, level, k)
            written += len(found)
            seen = found if k == order else seen
        if k == 0 and job.extension == "fits":
            cuts = _cuts(level)
        _write_allsky(job, level, order)
    # Pictures need no astropy, and it alone writes this.
    if job.extension == "fits" or find_spec("astropy") is not None:
        from .fits import moc

        job.folder.data("Moc.fits", moc(seen, order, job.frame))
    if job.page:
        job.folder.page("hips")
    said = _properties(job, order, cuts, len(seen) / (12 * 4**order))
    lines = [f"{name:<20} = {value}\n" for name, value in said.items()]
    manifest = job.folder.manifest("properties", "".join(lines).encode())
    return Pyramid(manifest, (12, side, side), order + 1, written)


def _tiles(side: int, order: int) -> Iterator[_Tile]:
    """Yield the tiles of an order; u of `healpix` goes north-east and v north-west."""
    width = side >> order
    for face in range(12):
        for row in range(1 << order):
            for column in range(1 << order):
                # The binary digits of both in turn.
                number = face * 4**order + int(f"{column:b}", 4) + 2 * int(f"{row:b}", 4)
                folder = f"Norder{order}/Dir{number // 10_000 * 10_000}"
                top, left = row * width, column * width
                part = Rectangle(top, top + width, left, left + width, face)
                yield _Tile(f"{folder}/Npix{number}", number, (face, column, row), part)


def _halved(level: Level, sky: Projection, shape: tuple[int, ...]) -> Level:
    """Return each four pixels' mean light; of those that are known, where some are."""
    made = level.empty((*shape, level.shape[-1]))
    for part in counted(tiles(shape, (_HALVED, _HALVED))):
        four = Rectangle(2 * part.top, 2 * part.bottom, 2 * part.left, 2 * part.right, part.face)
        made.put(part, _mean_of_four(light(level.read(four))))
    return made


def _mean_of_four(bright: NDArray[np.float32]) -> NDArray[np.float32]:
    quads = [bright[j::2, i::2] for j in (0, 1) for i in (0, 1)]
    out: NDArray[np.float32] = (quads[0] + quads[1] + quads[2] + quads[3]) * np.float32(0.25)
    some = np.isnan(out)
    if some.any():
        known = sum(~np.isnan(quad) for quad in quads)
        total = sum(np.nan_to_num(quad, posinf=np.inf, neginf=-np.inf) for quad in quads)
        mean = total / np.maximum(known, 1)
        out[some] = np.where(known > 0, mean, np.nan)[some]
    return out


def _write_tiles(job: Job, level: Level, order: int) -> list[int]:
    """Write the tiles of an order in which anything is known, and return their numbers."""
    found: list[int] = []
    with_alpha = level.has_nan

    def write(tile: _Tile) -> None:
        pixels = level.read(tile.part).swapaxes(0, 1)
        if pixels.dtype.kind == "f" and np.isnan(pixels).all():
            return
        if job.extension != "fits":
            picture = _stored(job, pixels, with_alpha)
            job.folder.picture(f"{tile.name}.{job.extension}", picture)
        else:
            # Here, as astropy takes time to import.
            from .fits import fits, place

            cards = place(job.frame, order, tile.number, tile.place, len(pixels))
            job.folder.data(f"{tile.name}.fits", fits(pixels[::-1, :, 0], cards))
        found.append(tile.number)

    each(level, write, _tiles(level.shape[1], order), job.tile_size)
    return sorted(found)


def _stored(job: Job, pixels: NDArray[Any], with_alpha: bool) -> NDArray[Any]:
    """Return a picture, in .png with alpha where some pixels of it are missing."""
    picture = job.look.picture(pixels)
    if job.extension == "jpg" or not with_alpha:
        return picture
    known = ~np.isnan(pixels).any(axis=-1, keepdims=True)
    return np.concatenate([picture, known.astype(np.uint8) * np.uint8(255)], axis=-1)


def _write_allsky(job: Job, level: Level, order: int) -> None:
    """Write the tiles of order 3 side by side, of a level of the size that they have there."""
    width, side = min(job.tile_size, _THUMB), level.shape[1]
    if order < _ALLSKY or side != width << _ALLSKY:
        return
    count = 12 * 4**_ALLSKY
    columns = int(count**0.5)
    rows = -(-count // columns)
    blank = np.nan if level.dtype.kind == "f" else 0
    sky = np.full((rows * width, columns * width, level.shape[-1]), blank, level.dtype)
    for tile in _tiles(side, _ALLSKY):
        row, column = divmod(tile.number, columns)
        pixels = level.read(tile.part).swapaxes(0, 1)
        sky[row * width :, column * width :][:width, :width] = pixels
    name = f"Norder{_ALLSKY}/Allsky"
    if job.extension != "fits":
        # Where there are fewer tiles than places, some are missing.
        picture = _stored(job, sky, sky.dtype.kind == "f")
        job.folder.picture(f"{name}.{job.extension}", picture)
        return
    from .fits import fits

    job.folder.data(f"{name}.fits", fits(sky[::-1, :, 0], {}))


def _cuts(level: Level) -> str | None:
    """Return between which numbers almost all of a level are."""
    values = np.empty(math.prod(level.shape), np.float32)
    count = 0
    for part in whole(level.shape):
        pixels = level.read(part)
        known = pixels[np.isfinite(pixels)]
        values[count : count + known.size] = known
        count += known.size
    if not count:
        return None
    share = [_SHARE, 1 - _SHARE]
    low, high = np.quantile(values[:count], share, overwrite_input=True)
    return f"{low:.6g} {high:.6g}"


def _properties(job: Job, order: int, cuts: str | None, seen: float) -> dict[str, str]:
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
        if cuts is not None:
            said["hips_pixel_cut"] = cuts
    elif job.image.shape[-1] == 3:
        said["dataproduct_subtype"] = "color"
    return said | dict(job.properties)
