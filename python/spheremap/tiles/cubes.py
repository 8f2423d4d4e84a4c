"""Six faces as a person in the middle sees them: Pannellum and Marzipano.

Both name faces by letters and have each as a photograph: front, back, left and right upright, the
front below what is above and above what is below.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..map.named import projection
from .cutting import tiles, whole, write_tiles
from .levels import levels
from .pyramid import Pyramid

if TYPE_CHECKING:
    from .._projection import Projection
    from .job import Job
    from .level import Level

__all__ = ["marzipano", "pannellum"]

# The letters of the faces of `cube`, +x -x +y -y +z -z, where +z is ahead.
LETTERS = "rludfb"
# Faces that are shown until tiles are there, or where there is no WebGL.
_LARGEST_FALLBACK = 1024
# How the faces of Marzipano's preview lie, one below the other.
_PREVIEW = "bdflru"


def _cube() -> Projection:
    # Forward is -z, and right and down are as seen from inside.
    return projection("cube", axes="+x -y -z")


def _halvings(size: int, tile_size: int) -> int:
    """Return how often a side is halved until a tile holds it."""
    return max(0, (-(-size // tile_size) - 1).bit_length())


def pannellum(job: Job) -> Pyramid:
    """Write Pannellum's ``multires``: ``{level}/{face}{row}_{column}``, the smallest level 1."""
    cube = _cube()
    wanted = job.wanted(cube)
    count = _halvings(wanted, job.tile_size)
    # So that every level is half of the next, to the texel.
    side = -(-wanted // 2**count) * 2**count
    written, has_fallback = 0, False
    for k, faces in enumerate(levels(job, cube, _shapes(side, count))):
        written += _write_faces(job, faces, job.tile_size, f"{count + 1 - k}/{{}}{{}}_{{}}")
        if not has_fallback and (side >> k <= _LARGEST_FALLBACK or k == count):
            names = (f"fallback/{letter}" for letter in LETTERS)
            write_tiles(job, faces, zip(names, whole(faces.shape), strict=True), side >> k)
            has_fallback = True
    if job.page:
        job.folder.page("pannellum")
    manifest = job.folder.json(
        "config.json",
        {
            "title": job.title,
            "type": "multires",
            "autoLoad": True,
            "multiRes": {
                "path": "/%l/%s%y_%x",
                "fallbackPath": "/fallback/%s",
                "extension": job.extension,
                "tileResolution": min(job.tile_size, side),
                "maxLevel": count + 1,
                "cubeResolution": side,
            },
        },
    )
    return Pyramid(manifest, cube.shape(side), count + 1, written)


def marzipano(job: Job) -> Pyramid:
    """Write what Marzipano's tool does: ``{level}/{face}/{row}/{column}`` and a preview."""
    cube = _cube()
    wanted = job.wanted(cube)
    count = _halvings(wanted, job.tile_size)
    # A level is whole tiles, and the preview half of one: no more texels than these take.
    tile_size = 2 * -(-wanted // 2 ** (count + 1))
    side = tile_size * 2**count
    written = 0
    for k, faces in enumerate(levels(job, cube, _shapes(side, count + 1))):
        if k <= count:
            written += _write_faces(job, faces, tile_size, f"{count + 1 - k}/{{}}/{{}}/{{}}")
            continue
        parts = whole(faces.shape)
        preview = [faces.read(parts[LETTERS.index(letter)]) for letter in _PREVIEW]
        picture = job.look.picture(np.concatenate(preview))
        job.folder.picture(f"preview.{job.extension}", picture)
    if job.page:
        job.folder.page("marzipano")
    sizes = [{"tileSize": tile_size, "size": tile_size << k} for k in range(count + 1)]
    half = {"tileSize": tile_size // 2, "size": tile_size // 2, "fallbackOnly": True}
    manifest = job.folder.json(
        "data.json",
        {
            "name": job.title,
            "tileUrl": f"{{z}}/{{f}}/{{y}}/{{x}}.{job.extension}",
            "previewUrl": f"preview.{job.extension}",
            "levels": [half, *sizes],
            "faceSize": side,
            "initialViewParameters": {"pitch": 0, "yaw": 0, "fov": np.pi / 2},
        },
    )
    return Pyramid(manifest, cube.shape(side), count + 1, written)


def _shapes(side: int, count: int) -> list[tuple[int, ...]]:
    return [(6, side >> k, side >> k) for k in range(count + 1)]


def _write_faces(job: Job, faces: Level, tile_size: int, pattern: str) -> int:
    """Write the tiles of six faces; the pattern takes face, row and column."""
    return write_tiles(
        job,
        faces,
        (
            (pattern.format(LETTERS[tile.face or 0], tile.row, tile.column), tile.part)
            for tile in tiles(faces.shape, tile_size)
        ),
        tile_size,
    )
