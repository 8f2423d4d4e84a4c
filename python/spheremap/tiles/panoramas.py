"""Panoramas of longitude and latitude: Photo Sphere Viewer, and Deep Zoom."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..map.named import projection
from .cutting import tiles, whole, write_tiles
from .levels import levels
from .pyramid import Pyramid

if TYPE_CHECKING:
    from .job import Job
    from .level import Level

__all__ = ["deepzoom", "photo_sphere_viewer"]

_OVERLAP = 1
_DZI = """<?xml version="1.0" encoding="UTF-8"?>
<Image xmlns="http://schemas.microsoft.com/deepzoom/2008" Format="{extension}" \
Overlap="{overlap}" TileSize="{tile_size}">
  <Size Height="{height}" Width="{width}"/>
</Image>
"""


def photo_sphere_viewer(job: Job) -> Pyramid:
    """Write what its adapter for tiles takes: 2, 4, 8 ... columns of square tiles.

    The adapter tears an image into as many columns as its sphere has segments, so that their number
    is a power of two, and every level has the same tiles.
    """
    latlong = projection("latlong")
    wanted = 2 * job.wanted(latlong)
    count = max(0, (-(-wanted // job.tile_size) - 1).bit_length() - 1)
    tile_size = -(-wanted // 2 ** (count + 1))
    height = tile_size << count
    shapes = [(height >> k, 2 * height >> k) for k in range(count + 1)]
    written = 0
    for k, level in enumerate(levels(job, latlong, shapes)):
        names = f"{count - k}/panorama_{{}}_{{}}"
        written += _write_panorama(job, level, names, tile_size)
        if k == count:
            write_tiles(job, level, zip(["base"], whole(level.shape), strict=True), 2 * tile_size)
    if job.page:
        job.folder.page("photo-sphere-viewer")
    manifest = job.folder.json(
        "config.json",
        {
            "caption": job.title,
            "baseUrl": f"base.{job.extension}",
            "tileUrl": f"{{level}}/panorama_{{col}}_{{row}}.{job.extension}",
            "levels": [
                {"width": width, "cols": width // tile_size, "rows": width // tile_size // 2}
                for _, width in reversed(shapes)
            ],
        },
    )
    return Pyramid(manifest, (height, 2 * height), count + 1, written)


def deepzoom(job: Job) -> Pyramid:
    """Write a panorama as Deep Zoom: levels from one texel up, tiles that overlap by one."""
    latlong = projection("latlong")
    height, width = latlong.shape(job.wanted(latlong))
    if job.size is None and job.src.name == "latlong":
        # A texel more or less is what the image has.
        height, width = job.shape
    last = (max(height, width) - 1).bit_length()
    shapes = [(-(-height // 2**k), -(-width // 2**k)) for k in range(last + 1)]
    written = 0
    for k, level in enumerate(levels(job, latlong, shapes)):
        names = f"panorama_files/{last - k}/{{}}_{{}}"
        written += _write_panorama(job, level, names, job.tile_size, _OVERLAP)
    if job.page:
        job.folder.page("deepzoom")
    text = _DZI.format(
        extension=job.extension,
        overlap=_OVERLAP,
        tile_size=job.tile_size,
        height=height,
        width=width,
    )
    manifest = job.folder.manifest("panorama.dzi", text.encode())
    return Pyramid(manifest, (height, width), last + 1, written)


def _write_panorama(job: Job, level: Level, pattern: str, size: int, overlap: int = 0) -> int:
    """Write the tiles of a panorama; the pattern takes column and row."""
    return write_tiles(
        job,
        level,
        (
            (pattern.format(tile.column, tile.row), tile.part)
            for tile in tiles(level.shape, size, overlap)
        ),
        size,
    )
