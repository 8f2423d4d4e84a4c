"""A page to look around in for each projection, by `sm.view`."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import spheremap as sm
from spheremap import _core
from spheremap.cli.sky import radiance

from .source import Source

# Texels of an image, so that no page is a megabyte.
TEXELS = 40_000


def image(p: sm.Projection) -> np.ndarray:
    """Return the sky of `spheremap demo` as a small image of a projection."""
    size = 16
    while np.prod(p.shape(size + 8)) <= TEXELS:
        size += 8
    large = radiance(np.nan_to_num(p.directions(p.shape(size)), nan=1.0).astype(np.float32))
    return np.minimum(large, 40.0)


def make(source: Source) -> None:
    """Write them to _static/look, where pages of projections show them."""
    with tempfile.TemporaryDirectory() as folder:
        for entry in _core.registry():
            p = sm.projection(entry["name"])
            path = Path(folder) / "look.html"
            sm.view(image(p), p, name=f"A sky as {p.name}").save(path)
            source.copy(path, f"_static/look/{p.name}.html")
