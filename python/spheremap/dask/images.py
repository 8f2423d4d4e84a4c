"""One image in chunks into another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import dask.array as da
import numpy as np
from dask.base import tokenize
from dask.highlevelgraph import HighLevelGraph

from .._arrays import spatial_axes
from .._scalars import as_flag
from ..map.images import expect_aspect, target_shape
from ..map.named import resolve, resolve_pair
from ..map.size import matching_size
from ..resample.chained import Chained
from ..resample.conversion import Conversion, needs_chain
from .chains import chain_converted
from .parts import Part
from .pieces import Chunks, Lengths, chunk_ranges, keys_of, windows_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .._arrays import Size
    from .._names import ConvertFilter
    from .._projection import Projection
    from ..map.named import ProjectionLike, Worlds

__all__ = ["convert"]


def convert(
    image: da.Array,
    /,
    src: ProjectionLike,
    dst: ProjectionLike,
    *,
    size: Size | None = None,
    chunks: Any = "auto",
    rotation: Any | None = None,
    filter: ConvertFilter | str = "bilinear",
    fill: float | Sequence[float] = 0.0,
    skipna: bool = False,
    antialias: bool = True,
    alpha: int | None = None,
    world: Worlds = "match",
    any_aspect: bool = False,
    channels_first: bool = False,
) -> da.Array:
    """Turn an image in chunks from one projection into another.

    Parameters
    ----------
    image : dask.array.Array, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        In chunks of any sizes. Chunks of channels are put together. With one more axis in front
        it is a batch, as for `spheremap.convert`, each of whose images is converted by itself.
    src, dst, size, rotation, filter, fill, skipna, antialias, alpha, world, any_aspect
        As for `spheremap.convert`; one rotation.
    channels_first : bool
        As for `spheremap.convert`.
    chunks : int, tuple or str
        The chunks of an image of the result, as dask has them, without channels, which stay
        together: ``512``, ``(512, 1024)``, ``"auto"``, ``"64 MiB"``, ``((300, 212), (512, 512))``.
        One number, and what is automatic, takes faces one by one.

    Returns
    -------
    image : dask.array.Array of the same dtype and channels
        Computed, it has the bits of `spheremap.convert`, in any chunks and by any scheduler.

    Raises
    ------
    ValueError, TypeError
        As for `spheremap.convert`, and for chunks that dask does not know; all at once, before
        anything is computed, but for masked integers in chunks that are seen.

    Notes
    -----
    A task depends on the chunks of the source that it sees: found on the sphere, never too few and
    a few too many. It takes the memory of these chunks, of its result, and once more of what it
    sees of them, in an array of which nothing else is there. With `alpha`, and with `skipna` where
    a chunk has what is not finite, that array holds floats: colors are weighted first.

    ``"trilinear"`` and ``"ewa"`` have tasks for the levels of a mip chain, in chunks about as large
    as those of the source, and a task of the result depends on the chunks of all levels that it
    may see.

    Every task uses as many threads as `set_num_threads` says; where a worker runs one task a core,
    let it say 1.

    Examples
    --------
    >>> import dask.array as da, numpy as np, spheremap as sm, spheremap.dask
    >>> rng = np.random.default_rng(0)
    >>> panorama = rng.random((512, 1024, 3), np.float32)
    >>> cube = spheremap.dask.convert(
    ...     da.from_array(panorama, chunks=(128, 128, 3)), "latlong", "cube", size=256, chunks=128
    ... )
    >>> cube.shape, cube.numblocks
    ((6, 256, 256, 3), (6, 2, 2, 1))
    >>> whole = sm.convert(panorama, "latlong", "cube", size=256)
    >>> bool((cube.compute() == whole).all())
    True
    """
    if not isinstance(image, da.Array):
        raise TypeError(
            f"Expected `image` to be an array of dask, got {type(image).__name__}; "
            "dask.array.from_array makes one."
        )
    source, target = resolve(src), resolve(dst)
    axes = spatial_axes(source)
    if as_flag(channels_first, "channels_first") or image.ndim == axes + 2:
        given = {
            "size": size,
            "chunks": chunks,
            "rotation": rotation,
            "filter": filter,
            "fill": fill,
            "skipna": skipna,
            "antialias": antialias,
            "alpha": alpha,
            "world": world,
            "any_aspect": any_aspect,
        }
        return _several(image, source, target, given, channels_first)
    _expect_one(image, source)
    expect_aspect(source, image.shape, any_aspect)
    source.shape(image.shape[:axes])
    size = matching_size(image.shape, source, target) if size is None else size
    shape = target_shape(target, size, any_aspect)
    if image.ndim > axes:
        image = image.rechunk({axes: -1})
    source = resolve(source, rotation=rotation)
    options = {
        "filter": filter,
        "fill": fill,
        "skipna": skipna,
        "antialias": antialias,
        "alpha": alpha,
        "world": world,
        "any_aspect": True,
    }
    conversion = Conversion(
        source, target, image.shape, image.dtype.newbyteorder("="), shape, options
    )
    meta = conversion.nothing()
    channels = image.shape[axes:]
    divided = _divided(chunks, shape, channels, meta.dtype)
    target = resolve_pair(source, target, None, world)[1]
    if needs_chain(filter):
        return chain_converted(image, Chained(conversion), target, divided, meta)
    return _graph(image, conversion, target, divided, channels, meta)


def _several(
    image: da.Array,
    source: Projection,
    target: Projection,
    options: dict[str, Any],
    channels_first: bool,
) -> da.Array:
    """Convert an image with its channels first, or each of a batch, into such."""
    axes = spatial_axes(source)
    if channels_first:
        if image.ndim not in (axes + 1, axes + 2):
            raise ValueError(
                "Expected `image` to have its channels before its rows, as channels_first=True "
                f"says, got shape {image.shape}."
            )
        # Of faces, each has its channels.
        image = da.moveaxis(image, -3, -1)
    if image.ndim == axes + 1:
        found = convert(image, source, target, **options)
    elif len(image) == 0:
        raise ValueError("Expected a batch of at least one image, got none.")
    else:
        found = da.stack([convert(one, source, target, **options) for one in image])
    return da.moveaxis(found, -1, -3) if channels_first else found


def _expect_one(image: da.Array, projection: Any) -> None:
    """Raise for what is no image with chunks of known sizes."""
    if any(np.isnan(length) for length in image.shape):
        raise ValueError(
            "Expected `image` to have chunks of known sizes; compute_chunk_sizes() finds them."
        )
    axes = spatial_axes(projection)
    if image.ndim not in (axes, axes + 1):
        raise ValueError(
            f"Expected `image` to have {axes} axes, or {axes + 1} with channels, got shape "
            f"{image.shape}."
        )


def _divided(
    chunks: Any, shape: tuple[int, ...], channels: tuple[int, ...], dtype: np.dtype[Any]
) -> Lengths:
    """Return the lengths of chunks along each axis without channels."""
    given = chunks
    if not isinstance(chunks, tuple | list):
        chunks = (*([1] if len(shape) == 3 else []), chunks, chunks)
    if len(chunks) != len(shape):
        raise ValueError(
            f"Expected `chunks` to be one, or one for each axis of {shape}, got {chunks!r}."
        )
    for length in chunks:
        if isinstance(length, int | np.integer) and not (length == -1 or length > 0):
            raise ValueError(
                f"Expected `chunks` of at least 1 texel, or -1 for whole axes, got {given!r}."
            )
    whole = (*chunks, *(-1 for _ in channels))
    known: Lengths = da.core.normalize_chunks(whole, (*shape, *channels), dtype=dtype)
    return known[: len(shape)]


def _graph(
    image: da.Array,
    conversion: Conversion,
    target: Any,
    divided: Lengths,
    channels: tuple[int, ...],
    meta: Any,
) -> da.Array:
    """Return the result: a task for each of its chunks, with the chunks that it sees."""
    keys = keys_of(image)
    blocks = list(np.ndindex(*map(len, divided)))
    source = Chunks(conversion.src, image.shape, chunk_ranges(image.chunks), len(blocks))
    held = windows_of(divided)
    seen = source.seen_by_each(target, conversion.size, held)

    name = f"spheremap-convert-{tokenize(image.name, conversion, divided)}"
    end = (0,) * len(channels)
    tasks = {}
    for index, some, faces in zip(blocks, seen, held, strict=True):
        part = Part(conversion, tuple(faces), some)
        tasks[(name, *index, *end)] = (part, [keys[k] for k in part.chunks])
    graph = HighLevelGraph.from_collections(name, tasks, dependencies=[image])
    whole = (*divided, *((length,) for length in channels))
    return da.Array(graph, name, whole, meta=meta)
