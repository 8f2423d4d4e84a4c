"""What `spheremap tiles` shows of a file: its colors, all at once or part by part."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import spheremap as sm
from spheremap import io
from spheremap.cli import files, picture
from spheremap.cli.terminal import read
from spheremap.io.large import expect_plain
from spheremap.io.opened import opened
from spheremap.io.reading import Source
from spheremap.tiles.colors import on_black

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Shown"]


class Shown:
    """The colors of a file, of sRGB or linear light, and the largest light among them."""

    def __init__(
        self, path: Path, part: str | None, color_space: str | None, channels: str | None
    ) -> None:
        self._path, self._part = path, part
        self._color_space = color_space
        self._channels = None if channels is None else channels.split(",")
        self.head = io.header(path, part=part)
        self._dtype = np.dtype(self.head.dtype)
        one = np.zeros((1, 1, len(self.head.channels)), self._dtype)
        self.is_light = self._colors(one).dtype.kind == "f"
        self.largest = 0.0

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.head.height, self.head.width

    def map(self, name: str | None, any_aspect: bool) -> sm.Projection:
        """Return its map: the named one, what it says, or what its aspect suggests."""
        said, advice = self.head.projection, "--any-aspect takes it as it is"
        return files.taken(name, said, *self.shape, any_aspect=any_aspect, advice=advice)

    def whole(self) -> NDArray[Any]:
        """Return all of its colors."""
        return self._taken(read(self._path, part=self._part))

    def parts(self) -> Source:
        """Return what reads them part by part."""
        expect_plain(self.head, self._path)
        with opened(self._path, self._part) as handle:
            number = handle.current_subimage()
        count = len(self.head.channels)
        return Source([str(self._path)], number, self._dtype, count, self._taken)

    def _taken(self, texels: NDArray[Any]) -> NDArray[Any]:
        pixels = self._colors(texels)
        if self.is_light:
            largest = np.max(pixels, where=np.isfinite(pixels), initial=0.0)
            self.largest = max(self.largest, float(largest))
        return pixels

    def _colors(self, texels: NDArray[Any]) -> NDArray[Any]:
        known = picture.described(texels, self.head, color_space=self._color_space)
        if self._channels is not None:
            known = picture.with_channels(known, self._channels)
        alpha = known.alpha_channel
        if known.is_light or known.color_space != picture.SRGB:
            known = picture.as_light(known)
            light = io.to_linear(known.pixels, color_space=known.color_space, alpha=alpha)
            return picture.without_alpha(replace(known, pixels=light)).pixels
        return known.pixels if alpha is None else on_black(known.pixels, alpha)
