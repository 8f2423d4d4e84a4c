"""`write`: an image in memory as a pyramid."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_image, spatial_axes, spatial_shape
from .._scalars import as_flag
from ..io.tonemap import Curve
from ..map.images import channels_last, expect_aspect
from ..map.named import resolve
from .asked import Extension, Format, Frame, Kind, written
from .colors import shown
from .held import HeldImage
from .pyramid import Pyramid

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._names import ConvertFilter
    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds

__all__ = ["write"]


def write(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    folder: str | os.PathLike[str],
    *,
    format: Format | str,
    size: int | None = None,
    tile_size: int = 512,
    extension: Extension | str | None = None,
    quality: int = 90,
    filter: ConvertFilter | str = "bilinear",
    rotation: Any | None = None,
    world: Worlds = "match",
    curve: Curve | str = "none",
    exposure: float = 0.0,
    title: str | None = None,
    frame: Frame | str = "equatorial",
    properties: Mapping[str, str] | None = None,
    page: bool = True,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> Pyramid:
    """Write an image as a pyramid of tiles for a viewer on the web.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Floats are linear light; uint8 and uint16 are pictures of sRGB. Of two channels the first is
        written, of more than three the first three. The second of two, and the fourth of four, is
        alpha: straight in pictures, which become light on black; light is premultiplied.
    projection : Projection or str
        How the image maps the sphere.
    folder : path
        Where the files go: a new folder, or an empty one.
    format : {"pannellum", "marzipano", "photo-sphere-viewer", "deepzoom", "hips"}
        What the tiles are for. ``"pannellum"`` and ``"marzipano"`` are cubes,
        ``"photo-sphere-viewer"`` and ``"deepzoom"`` panoramas of longitude and latitude, and
        ``"hips"`` is HEALPix, as sky surveys are published.
    size : int, optional
        Of the largest level: the side of a face, or the height of a panorama. By default that at
        which nothing of the image is lost. It is rounded up to what the format can have: by a few
        texels, and with ``"hips"`` to a power of two times `tile_size`.
    tile_size : int
        The side of a tile, from 16 to 8192, for ``"hips"`` a power of two. ``"marzipano"`` and
        ``"photo-sphere-viewer"`` have tiles of equal size, which may be smaller.
    extension : {"jpg", "png", "fits"}, optional
        Of the tiles: ``"jpg"`` by default. ``"fits"`` is of ``"hips"`` with one channel, and keeps
        the numbers as float32.
    quality : int
        Of .jpg, from 1 to 100.
    filter, rotation, world
        As for `convert`, which makes the largest level.
    curve : {"none", "reinhard"}
        How light becomes 8 bits, as in `spheremap.io.tonemap`: ``"none"`` cuts it at 1.
    exposure : float
        In stops. Of floats, as is `curve`.
    title : str, optional
        What the image is called; the folder's name where nothing is said.
    frame : {"equatorial", "galactic", "ecliptic"}
        Of ``"hips"``: the frame of the sky in which the image's directions are, +z its north pole
        and +x longitude 0, as ``"latlong:healpy"`` and ``"healpix:healpy"`` have them. It says so,
        and turns nothing; ``rotation=healpix.frame_rotation("galactic", "icrs")`` does.
    properties : mapping of str, optional
        Of ``"hips"``: lines of its file ``properties``, as ``creator_did`` or ``obs_copyright``.
    page : bool
        Whether an ``index.html`` shows the tiles. It loads the viewer from a public server.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    Pyramid
        What was written.

    Raises
    ------
    ValueError, TypeError
        For a format that there is not, for settings that it cannot have, and as `convert` does.
    OSError
        Where nothing can be written, and for a folder in which something is.
    ImportError
        If OpenImageIO is missing, or astropy for FITS.
    MemoryError
        If the largest level is too large.

    Notes
    -----
    The largest level is what `convert` makes of the image, and each of the others has the mean
    light of the one before. Each file appears whole or not at all, and the one that a viewer is
    given appears last: where it is, all is there. Two levels are held in memory, where light takes
    4 bytes a channel; `write_file` takes no more than it is given.

    The formats are those of Pannellum 2.5, Marzipano 0.10, Photo Sphere Viewer 5, Deep Zoom of 2009
    and HiPS 1.0 of the IVOA.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np, spheremap as sm
    >>> sky = np.ones((64, 128, 3), np.float32)
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "sky"
    >>> made = sm.tiles.write(sky, "latlong", place, format="pannellum", tile_size=32)
    >>> made.manifest.name, made.shape, made.levels, made.tiles
    ('config.json', (6, 42, 42), 2, 30)
    """
    kind = Kind.of(format, extension, curve, exposure, resolve(projection, rotation=rotation))
    pixels = _pixels(image, kind.src, any_aspect, channels_first)
    return written(
        HeldImage(kind.taken(shown(pixels))),
        kind,
        folder,
        size=size,
        tile_size=tile_size,
        quality=quality,
        filter=filter,
        world=world,
        title=title,
        frame=frame,
        properties=properties,
        page=page,
    )


def _pixels(
    image: ArrayLike, p: Projection, any_aspect: bool, channels_first: bool
) -> NDArray[Any]:
    """Return an image with its channels last."""
    pixels, axes = as_image(image, None), spatial_axes(p)
    if as_flag(channels_first, "channels_first"):
        pixels = channels_last(pixels, axes)
    if 0 in pixels.shape:
        raise ValueError(f"Expected `image` to have texels, got shape {pixels.shape}.")
    expect_aspect(p, pixels.shape, any_aspect)
    spatial_shape(pixels, p, "image")
    return pixels[..., np.newaxis] if pixels.ndim == axes else pixels
