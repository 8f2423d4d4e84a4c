"""Blender, as the module bpy in a Python of its own: its wheel wants another NumPy than ours.

SPHEREMAP_BLENDER names that Python; `make test-programs` makes one.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np

from . import blender_render, openimageio_oracle


def views(image: Path, projection: str, folder: Path, size: int) -> list[np.ndarray]:
    """Return what Blender sees of an environment in each of the views of `blender_render`."""
    command = [os.environ["SPHEREMAP_BLENDER"], blender_render.__file__]
    command += [projection, str(image), str(folder), str(size)]
    subprocess.run(command, check=True, capture_output=True)
    count = len(blender_render.VIEWS)
    return [openimageio_oracle.read(folder / f"{k}.exr")[..., :3] for k in range(count)]


def directions(size: int) -> list[np.ndarray]:
    """Return the world directions of the pixels of each view."""
    center = (np.arange(size) + 0.5) / size * 2 - 1
    x, up = np.meshgrid(center, -center)
    camera = np.stack([x, up, -np.ones_like(x)], -1)
    camera /= np.linalg.norm(camera, axis=-1, keepdims=True)
    return [camera @ _turn(*np.radians(view)).T for view in blender_render.VIEWS]


def _turn(about_x: float, about_z: float) -> np.ndarray:
    (c, s), (d, t) = ((np.cos(a), np.sin(a)) for a in (about_x, about_z))
    turned_x = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return np.array([[d, -t, 0], [t, d, 0], [0, 0, 1]]) @ turned_x
