"""HEALPix pixel numbers, regions of the sky, and HEALPix maps as images.

The sphere is 12 faces of nside² pixels of equal area. In *ring* order pixels are counted along
rings of equal latitude from the north, in *nested* order face by face along a Z-order curve [1]_.
z points to the north pole, x to longitude 0 and y to longitude 90° east, as in healpy.

All functions take arrays of any shape; those of pixel numbers run on threads. Numbers are int64; -1
is the pixel of what has none. Where healpy has a function of the same name, `nest`, `lonlat` and
what else both have come in its order.

Notes
-----
Indices equal healpy's. A direction within 4e-15 rad of a border between pixels, which is what
rounding moves it by, may be given to either of them, here as there. At a pole itself the pixel is
that of longitude 0, whatever the signs of zeros.

What a map does not know is NaN, what healpy marks by ``UNSEEN`` (-1.6375e30), or masked in a masked
array: it becomes NaN in images and has no weight in means. A part of the sky is the numbers of its
pixels with a value for each; `whole_map` and `seen_pixels` go there and back.

References
----------
.. [1] K. M. Górski et al., "HEALPix: A Framework for High-Resolution Discretization and Fast
   Analysis of Data Distributed on the Sphere", Astrophysical Journal 622, 759, 2005.

Examples
--------
>>> from spheremap import healpix
>>> int(healpix.vec2pix(64, [0.0, 0.0, 1.0])), int(healpix.vec2pix(64, [0.0, 0.0, 1.0], nest=True))
(0, 4095)
"""

from .frames import frame_rotation
from .maps import UNSEEN, from_image, reorder, to_image, ud_grade
from .numbers import (
    ang2pix,
    boundaries,
    neighbors,
    nest2ring,
    npix2nside,
    nside2npix,
    nside2pixarea,
    nside2resol,
    pix2ang,
    pix2vec,
    ring2nest,
    vec2pix,
)
from .parts import seen_pixels, whole_map
from .regions import interpolation_weights, query_disc, query_polygon

__all__ = [
    "UNSEEN",
    "ang2pix",
    "boundaries",
    "frame_rotation",
    "from_image",
    "interpolation_weights",
    "neighbors",
    "nest2ring",
    "npix2nside",
    "nside2npix",
    "nside2pixarea",
    "nside2resol",
    "pix2ang",
    "pix2vec",
    "query_disc",
    "query_polygon",
    "reorder",
    "ring2nest",
    "seen_pixels",
    "to_image",
    "ud_grade",
    "vec2pix",
    "whole_map",
]


def __dir__() -> list[str]:
    return __all__
