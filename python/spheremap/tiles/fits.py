"""FITS tiles of HiPS, by astropy: ``pip install spheremap[hips]``."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["fits", "library", "moc", "place"]

# Names of the two axes of each frame in the projection HPX.
_AXES = {
    "equatorial": ("RA---HPX", "DEC--HPX"),
    "galactic": ("GLON-HPX", "GLAT-HPX"),
    "ecliptic": ("ELON-HPX", "ELAT-HPX"),
}


def library() -> Any:
    """Return ``astropy.io.fits``, or raise what says how to install it."""
    try:
        from astropy.io import fits
    except ImportError:
        raise ImportError(
            "FITS tiles need astropy: pip install spheremap[hips]", name="astropy"
        ) from None
    return fits


def fits(values: NDArray[Any], cards: Mapping[str, Any]) -> bytes:
    """Return a FITS file of float32, its first row at the bottom as FITS has it."""
    # What is not contiguous astropy writes number by number.
    unit = library().PrimaryHDU(values.astype(">f4", order="C"))
    unit.header.update(cards)
    return _bytes(unit)


def moc(numbers: Iterable[int], order: int, frame: str) -> bytes:
    """Return the coverage of tiles as a multi-order map: ``Moc.fits``.

    P. Fernique et al., "MOC: Multi-Order Coverage map", IVOA Recommendation 2.0, 2022, section 4.2.
    """
    cells, here = [], sorted(numbers)
    for k in range(order, -1, -1):
        brothers = Counter(number >> 2 for number in here)
        # Four of them are their parent.
        whole = {parent for parent, count in brothers.items() if count == 4 and k}
        cells += [4 * 4**k + number for number in here if number >> 2 not in whole]
        here = sorted(whole)
    astropy = library()
    column = astropy.Column(name="UNIQ", format="K", array=sorted(cells))
    table = astropy.BinTableHDU.from_columns([column])
    table.header.update(
        {
            "PIXTYPE": "HEALPIX",
            "ORDERING": "NUNIQ",
            "COORDSYS": frame[0].upper() if frame != "equatorial" else "C",
            "MOCVERS": "2.0",
            "MOCDIM": "SPACE",
            "MOCORD_S": order,
            "MOCORDER": order,
            "MOCTOOL": "spheremap",
        }
    )
    return _bytes(table)


def place(
    frame: str, order: int, number: int, where: tuple[int, int, int], width: int
) -> dict[str, Any]:
    """Return what a tile's header says of its place on the sky, in the projection HPX.

    M. R. Calabretta, B. F. Roukema, "Mapping on the HEALPix grid", Monthly Notices of the Royal
    Astronomical Society 381, 865, 2007: faces are squares that stand on a corner, 90° across.
    """
    face, column, row = where
    # The middle of a face: four around each pole, between them four on the equator.
    ring, turn = divmod(face, 4)
    x = 90.0 * turn + (0.0 if ring == 1 else 45.0)
    # One lies at longitude 180, where the plane ends: in its middle the plane begins.
    begins = 180.0 if (ring, turn) == (1, 2) else 0.0
    x, y = (x - begins + 180.0) % 360.0 - 180.0, 45.0 * (1 - ring)
    step = 45.0 / (width << order)
    side = float(width << order)
    # Where the origin of the plane lies on the face, in pixels north-east and north-west.
    east, west = (side - (y + x) / step) / 2, (side - (y - x) / step) / 2
    return {
        "ORDER": order,
        "NPIX": number,
        "CTYPE1": _AXES[frame][0],
        "CTYPE2": _AXES[frame][1],
        "CUNIT1": "deg",
        "CUNIT2": "deg",
        "CRPIX1": west - row * width + 0.5,
        "CRPIX2": column * width + width - east + 0.5,
        "CRVAL1": begins,
        "CRVAL2": 0.0,
        "CD1_1": -step,
        "CD1_2": -step,
        "CD2_1": step,
        "CD2_2": -step,
        "PV2_1": 4,
        "PV2_2": 3,
        **({"RADESYS": "ICRS"} if frame == "equatorial" else {}),
    }


def _bytes(unit: Any) -> bytes:
    held = io.BytesIO()
    unit.writeto(held)
    return held.getvalue()
