"""An independent reference of conservative conversion: brute force, from `reference` alone.

Each target texel is cut into many, each of which looks up the source texel that holds its
center and counts by the density there. The error goes as the supersampling to the power -3/2,
which is far from 1e-6, and shares nothing with the method under test.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import maps

Array = np.ndarray


def nearest_inside(r: maps.Reference, shape: tuple[int, ...]) -> Array:
    """For each texel its own flat index, or that of the nearest one with a valid center."""
    uv = r.texel_uv(shape)
    flat = uv.reshape(-1, uv.shape[-1])
    inside = r.valid(flat)
    index = np.arange(len(flat))
    place = np.stack(np.unravel_index(index, uv.shape[:-1]), -1)[:, -2:]
    valid = index[inside]
    for k in index[~inside]:
        same = valid[np.all(flat[valid, 2:] == flat[k, 2:], axis=-1)]
        if len(same):
            # In texels, so that ties are exact; the first of equally near ones by row and column.
            index[k] = same[np.argmin(((place[same] - place[k]) ** 2).sum(-1))]
    return index.reshape(uv.shape[:-1])


def filled(r: maps.Reference, image: Array) -> Array:
    """Give an image whose texels outside hold the value of the nearest inside."""
    return image.reshape(-1)[nearest_inside(r, image.shape)]


def energy(r: maps.Reference, image: Array, solid_angle: Array) -> float:
    """Σ L·dω of a source."""
    return float((filled(r, image) * solid_angle).sum())


def convert(
    image: Array,
    src: maps.Reference,
    dst: maps.Reference,
    shape: tuple[int, ...],
    rotation: Any,
    finer: int,
) -> Array:
    """Supersample. `src` covers the sphere, and both have one face and texel centers.

    What a target texel with its center outside covers counts with the nearest one inside, whose
    mean both have.
    """
    rows, columns = shape
    uv = dst.texel_uv((rows * finer, columns * finer))
    weight = np.where(dst.valid(uv), dst.density(uv), 0.0)
    d = np.where(weight[..., None] > 0, dst.decode(uv), (0.0, 0.0, 1.0)) @ np.asarray(rotation)
    u, v = np.moveaxis(src.encode(d)[..., :2], -1, 0)
    height, width = image.shape
    i = np.clip((u * width).astype(int), 0, width - 1)
    j = np.clip((v * height).astype(int), 0, height - 1)
    value = filled(src, image)[j, i]

    def blocks(x: Array) -> Array:
        return x.reshape(rows, finer, columns, finer).sum((1, 3))

    owner = nearest_inside(dst, shape).reshape(-1)
    covers = blocks(weight).reshape(-1) > 0
    total, light = np.zeros(owner.size), np.zeros(owner.size)
    np.add.at(total, owner, blocks(weight).reshape(-1))
    np.add.at(light, owner, blocks(weight * value).reshape(-1))
    mean = light[owner] / np.where(total > 0, total, 1.0)[owner]
    return np.where(covers, mean, 0.0).reshape(shape)
