"""All that a renderer needs of an environment, in one call."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import checked_image
from .._progress import counted, part
from .._scalars import as_flag
from .._show import line
from ..io.textures import write_dds, write_ktx2
from ..io.whole import write_bytes
from ..map.images import images
from ..map.named import resolve, resolve_pair
from ..sh import convert as sh_convert
from ..sh import project as sh_project
from .lobes import irradiance
from .specular import dfg, prefilter_chain

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Negative
    from ..map.named import ProjectionLike, Worlds

__all__ = ["Bake", "bake"]

Image = Any

# How much of the time of reflections their table takes, at the usual size.
_TABLE = 0.2


@dataclass(frozen=True, eq=False)
class Bake:
    """An environment made ready for rendering: what `bake` returns."""

    diffuse: NDArray[np.floating[Any]] | None
    """Irradiance over π, (6, N, N, C): what a white Lambertian surface sends back."""
    specular: list[NDArray[np.floating[Any]]] | None
    """A mip chain of GGX reflections, (6, N, N, C), (6, N/2, N/2, C) ..."""
    sh: NDArray[np.float64] | None
    """Coefficients of the radiance, ((order + 1)², C), orthonormal."""
    dfg: NDArray[np.float32] | None
    """The table of the split sum, (128, 128, 2)."""

    __repr__ = line

    def write(self, folder: str | os.PathLike[str], /) -> list[tuple[Path, str]]:
        """Write diffuse and specular as .ktx2 and .dds, dfg as .ktx2 and .dds, and sh as .json.

        Parameters
        ----------
        folder : path-like
            Made if it is not there.

        Returns
        -------
        written : list of (Path, str)
            Each file and what it holds.

        Raises
        ------
        OSError
            For a place that cannot be written.

        Examples
        --------
        >>> import numpy as np, spheremap as sm, tempfile
        >>> sky = np.ones((8, 16, 3), np.float32)
        >>> made = sm.light.bake(sky, "latlong", specular=False, diffuse_size=4)
        >>> [path.name for path, holds in made.write(tempfile.mkdtemp())]
        ['diffuse.ktx2', 'diffuse.dds', 'sh.json']
        """
        place = Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        written = []
        for name, levels in (
            ("diffuse", None if self.diffuse is None else [self.diffuse]),
            ("specular", self.specular),
            ("dfg", None if self.dfg is None else [self.dfg]),
        ):
            if levels is None:
                continue
            shape = levels[0].shape
            kind = "cube" if len(shape) == 4 else "table"
            text = f"{kind} {shape[-2]} x {shape[-3]}, {len(levels)} mip"
            text += "s, half float" if len(levels) > 1 else ", half float"
            for suffix, write in ((".ktx2", write_ktx2), (".dds", write_dds)):
                clipped = write(place / f"{name}{suffix}", levels)
                note = f"; {clipped} values above 65504 clipped" if clipped else ""
                written.append((place / f"{name}{suffix}", text + note))
        if self.sh is not None:
            order = int(np.sqrt(len(self.sh))) - 1
            rows: dict[str, Any] = {"order": order, "orthonormal": self.sh.tolist()}
            if order >= 2:
                named = sh_convert(self.sh, dst="filament-irradiance")
                rows["filament-irradiance"] = named.tolist()
            target = place / "sh.json"
            write_bytes(target, (json.dumps(rows, indent=1) + "\n").encode())
            written.append((target, f"spherical harmonics of order {order}"))
        return written


def bake(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    diffuse: bool = True,
    specular: bool = True,
    sh: bool = True,
    size: int = 256,
    levels: int | None = None,
    diffuse_size: int = 32,
    order: int = 2,
    samples: int = 1024,
    axes: str | None = None,
    rotation: Any | None = None,
    skipna: bool = False,
    world: Worlds = "match",
    negative: Negative = "keep",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> Bake | Any:
    """Make the set of maps that image-based lighting needs.

    Parameters
    ----------
    image, projection, skipna
        As for `integrate`.
    diffuse, specular, sh : bool
        What to make. The specular maps come with their table (`dfg`).
    size, levels, samples
        Of the specular mip chain, as for `prefilter_chain`.
    diffuse_size : int
        Of a face of the diffuse cube.
    order : int
        Of the spherical harmonics.
    axes, rotation
        As for `encode`; the rotation may have shape (N, 3, 3), as for `convert`.
    world : {"match", "literal"}
        What is made lives in the world of plain names, +y up and -z ahead, right-handed, harmonics
        as well. ``"match"``: what is up in the world of `projection` is so there, as for `convert`.
    negative, any_aspect, channels_first
        As for `integrate`.

    Returns
    -------
    Bake
        With ``write`` to put it into a folder; channels are last in it. Of a batch, or with many
        rotations, a list of them.

    Raises
    ------
    ValueError, TypeError
        As for `integrate`.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.ones((32, 64, 3), np.float32)
    >>> baked = sm.light.bake(sky, "latlong", size=16, levels=3, diffuse_size=4, samples=32)
    >>> baked.diffuse.shape, len(baked.specular), baked.sh.shape
    ((6, 4, 4, 3), 3, (9, 3))
    """
    kinds = (("diffuse", diffuse), ("specular", specular), ("sh", sh))
    for name, wanted in kinds:
        as_flag(wanted, name)
    given = resolve(projection, axes)
    several = images(
        image, given, any_aspect=any_aspect, channels_first=channels_first, rotation=rotation
    )
    if several is not None:
        return several.each(bake, locals(), "object")
    pixels = checked_image(image, given, skipna=skipna, negative=negative)
    cube, p = resolve_pair("cube", resolve(given, rotation=rotation), None, world)
    made = Bake(None, None, None, None)
    for kind in counted([kind for kind, wanted in kinds if wanted]):
        if kind == "diffuse":
            light = irradiance(pixels, p, cube, size=diffuse_size, world=world, any_aspect=True)
            made = replace(made, diffuse=light / light.dtype.type(np.pi))
        elif kind == "specular":
            with part(0, 1 - _TABLE):
                chain = prefilter_chain(
                    pixels,
                    p,
                    cube,
                    size=size,
                    levels=levels,
                    samples=samples,
                    world=world,
                    any_aspect=True,
                )
            with part(1 - _TABLE, 1):
                made = replace(made, specular=chain, dfg=dfg())
        else:
            made = replace(made, sh=sh_project(pixels, p, order=order, any_aspect=True))
    return made
