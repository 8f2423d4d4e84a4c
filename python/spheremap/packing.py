"""Unit vectors in 4 to 64 bits: names, arrays of fields, and which scheme to use.

The core packs into unsigned words. What a word's fields look like as an array is decided here.
"""

from __future__ import annotations

import html
import math
import warnings
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _core
from ._arrays import as_array, common_shape, expect_room, expect_vectors, index_text
from ._scalars import as_flag, as_float_dtype, as_items, as_text, as_whole
from ._show import html_table, text_table

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike, DTypeLike, NDArray

    from ._names import Language

__all__ = [
    "Packing",
    "UnboundedPackingWarning",
    "best_packing",
    "canonical",
    "code",
    "pack",
    "pack_frame",
    "packing",
    "packings",
    "unpack",
    "unpack_frame",
]


def __dir__() -> list[str]:
    return __all__


_WORDS = {8: np.uint8, 16: np.uint16, 32: np.uint32, 64: np.uint64}


class UnboundedPackingWarning(UserWarning):
    """A scheme was asked to pack whose error has no bound in steps of its grid."""


@dataclass(frozen=True)
class Packing:
    """What a packing scheme claims about itself. Made by `packing`.

    Attributes
    ----------
    name : str
        The name it is asked for by.
    family, variant : str
        The family of schemes it belongs to, and its grid or spacing ("" if there is no choice).
    title, source, summary : str
        Its full name, where it comes from, and what it is good for.
    bits : int
        Bits a direction.
    codes : int
        How many codes there are; for a scheme of whole words, codes are 0 to ``codes - 1``.
    dtype : numpy.dtype
        The type of the codes.
    shape : tuple of int
        The shape of one direction's code: ``()`` for a word, ``(2,)`` for two fields.
    roundings : tuple of str
        The ways of rounding it has.
    bounds : mapping of str to float
        For each way of rounding, an angle in radians that the error of a direction never
        exceeds, in exact arithmetic. float32, in which `unpack` computes unless it is told float64,
        adds at most 5e-7, and Draco's decoder 1e-6. Of fields of 23 bits and more ("oct46",
        "oct64", "oct32x2") that is more than the bound itself: ``dtype=np.float64`` keeps it.
    hemisphere : bool
        Whether it holds directions with z >= 0 only.
    exact : str or None
        The program whose codes it repeats to the bit.
    """

    name: str
    family: str
    variant: str
    title: str
    source: str
    summary: str
    bits: int
    codes: int
    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    roundings: tuple[str, ...]
    bounds: Mapping[str, float] = field(hash=False)
    hemisphere: bool
    exact: str | None

    def __reduce__(self) -> tuple[Any, ...]:
        return packing, (self.name,)

    def __repr__(self) -> str:
        many = f"{self.shape[0]} of " if self.shape else ""
        off = f"off by {math.degrees(self.bound):.3g}° at most"
        if math.isinf(self.bound):
            off = "its error has no bound"
        return f'Packing("{self.name}", {self.bits} bits as {many}{self.dtype}, {off})'

    @property
    def bound(self) -> float:
        """The bound of the default rounding, in radians; see `bounds` for what float32 adds."""
        return self.bounds.get("precise", self.bounds[self.roundings[0]])


@dataclass(frozen=True)
class _Scheme:
    """A resolved name: the core's object, and how its words are looked at."""

    core: _core.Packer
    about: Packing
    word: np.dtype[Any]
    fields: int | None
    field_bits: int
    signed: bool

    @property
    def is_view(self) -> bool:
        """Whether a word is its fields, lying side by side in memory."""
        size = self.about.dtype.itemsize
        return (
            self.fields is not None
            and self.field_bits == size * 8
            and self.fields * size == self.word.itemsize
        )


@lru_cache(maxsize=1024)
def _resolve_name(name: str) -> _Scheme:
    core = _core.Packer(name)
    a = core.about()
    word = np.dtype(_WORDS[a["stored_bits"]])
    fields: int | None = a["fields"]
    each = a["bits"] // fields if fields else a["bits"]
    dtype = word
    if fields:
        size = max(8, 1 << (each - 1).bit_length())
        dtype = np.dtype(f"{'i' if a['signed'] else 'u'}{size // 8}")
    about = Packing(
        name=a["name"],
        family=a["family"],
        variant=a["variant"],
        title=a["title"],
        source=a["source"],
        summary=a["summary"],
        bits=a["bits"],
        codes=a["codes"],
        dtype=dtype,
        shape=(fields,) if fields else (),
        roundings=tuple(a["bounds"]),
        bounds=MappingProxyType(a["bounds"]),
        hemisphere=a["hemisphere"],
        exact=a["exact"],
    )
    return _Scheme(core, about, word, fields, each, a["signed"])


def _resolve(name: str | Packing) -> _Scheme:
    if isinstance(name, Packing):
        name = name.name
    if not isinstance(name, str):
        raise TypeError(f"Expected a Packing or the name of one, got {type(name).__name__}.")
    return _resolve_name(name)


def packing(name: str | Packing, /) -> Packing:
    """Describe a packing scheme.

    Parameters
    ----------
    name : str or Packing
        A family and the total bits of a code, as in ``"oct16"``; with a grid or spacing after a
        dash where there is a choice, ``"oct16-centers"``, ``"cube24-s2"``; as an array of k fields
        of b bits each ``"oct8x2"``, ``"snorm8x3"``. `packings` lists them.

    Returns
    -------
    Packing

    Raises
    ------
    ValueError
        For an unknown name.

    Notes
    -----
    Grids of the octahedral families, with fields of b bits: ``snorm`` (the default) counts from
    ``-(2**(b-1) - 1)`` to ``2**(b-1) - 1``, and the one number left over reads as the least of
    them, as in Direct3D and Vulkan; ``unorm`` from 0 to ``2**b - 1``; ``centers`` are those of the
    texels of a texture. Fields lie in a word from its lowest bits on, x first. The pole is +z.

    Examples
    --------
    >>> import spheremap as sm
    >>> p = sm.packing.packing("oct16")
    >>> p.bits, p.dtype, p.shape, round(p.bound, 4)
    (16, dtype('uint16'), (), 0.0111)
    """
    return _resolve(name).about


@lru_cache(maxsize=1)
def _table() -> tuple[tuple[str, str, int, str, int | None], ...]:
    return tuple(_core.packing_table())


class Packings(tuple[str, ...]):
    """Names of packing schemes; prints as a table by family and grid."""

    __slots__ = ()

    def _rows(self) -> list[tuple[str, ...]]:
        kinds: dict[tuple[str, str], list[tuple[str, int, int | None]]] = {}
        for name, family, bits, variant, fields in map(_rows_by_name().__getitem__, self):
            kinds.setdefault((family, variant), []).append((name, bits, fields))
        rows: list[tuple[str, ...]] = []
        for (family, variant), found in kinds.items():
            sizes = sorted({bits for _, bits, _ in found})
            span = f"{sizes[0]} to {sizes[-1]}" if len(sizes) > 1 else str(sizes[0])
            words = _span([name for name, _, fields in found if fields is None])
            arrays = _span([name for name, _, fields in found if fields is not None])
            title = _resolve_name(found[0][0]).about.title
            rows.append((family, variant, title, span, words, arrays))
        return rows

    def __repr__(self) -> str:
        # Nothing, or what was made by hand of other words, is a tuple.
        if not self or not set(self) <= set(_rows_by_name()):
            return super().__repr__()
        return text_table(_HEAD, self._rows())

    def _repr_html_(self) -> str:
        if not self or not set(self) <= set(_rows_by_name()):
            return html.escape(super().__repr__())
        return html_table(_HEAD, self._rows())


_HEAD = ("family", "grid", "what", "bits", "as one number", "as an array of fields")


@lru_cache(maxsize=1)
def _rows_by_name() -> dict[str, tuple[str, str, int, str, int | None]]:
    return {row[0]: row for row in _table()}


def _span(names: list[str]) -> str:
    """Return names of one kind in a few words."""
    return ", ".join(names) if len(names) < 4 else f"{names[0]} ... {names[-1]} ({len(names)})"


def packings(
    *, family: str | None = None, bits: int | None = None, words: bool | None = None
) -> Packings:
    """List the names of packing schemes.

    Parameters
    ----------
    family : str, optional
        Only those of this family, as in ``"oct"``.
    bits : int, optional
        Only those with so many bits a direction.
    words : bool, optional
        Only those whose code is one number (True), or an array of fields (False).

    Returns
    -------
    names : tuple of str
        Prints as a table by family and grid.

    Raises
    ------
    ValueError
        For an unknown family.

    Examples
    --------
    >>> import spheremap as sm
    >>> tuple(sm.packing.packings(family="oct", bits=16))
    ('oct16', 'oct8x2', 'oct16-unorm', 'oct8x2-unorm', 'oct16-centers', 'oct8x2-centers')
    """
    families = {row[1]: None for row in _table()}
    if bits is not None:
        bits = as_whole(bits, "bits")
    if words is not None:
        words = as_flag(words, "words")
    if family is not None and as_text(family, "family") not in families:
        raise ValueError(f"unknown family '{family}'; there are {', '.join(families)}")
    return Packings(
        name
        for name, of, size, _, fields in _table()
        if (family is None or of == family)
        and (bits is None or size == bits)
        and (words is None or (fields is None) is words)
    )


def pack(
    directions: ArrayLike,
    name: str | Packing,
    /,
    rounding: Literal["precise", "nearest", "hex"] | str = "precise",
    *,
    invalid: Literal["raise", "zero", "ignore"] | str = "raise",
    out: NDArray[Any] | None = None,
) -> NDArray[Any]:
    """Pack directions into a few bits each.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        Directions of any length, which is not kept.
    name : Packing or str
        The scheme, as for `packing`.
    rounding : {"precise", "nearest", "hex"}
        ``"precise"`` takes the best of the grid points around the direction; ``"nearest"`` rounds
        each coordinate, which is fastest; ``"hex"`` rounds in the plane of the octahedron's face,
        almost as good as ``"precise"`` and almost as fast as ``"nearest"``. A scheme that repeats
        another program rounds as that does.
    invalid : {"raise", "zero", "ignore"}
        What becomes of a direction that is zero or not finite, or below the horizon of a scheme
        that holds a hemisphere: an error that names the first, the code 0, or the code 0 but the
        nearest horizon for the last.
    out : ndarray, optional
        Where to put the codes: C-contiguous, of their shape and dtype.

    Returns
    -------
    codes : ndarray, shape (...) or (..., k)
        Of the dtype and with the last axis that `packing` says.

    Raises
    ------
    ValueError
        For a wrong shape, an unknown name or rounding, an invalid direction, or an unfit `out`.
    TypeError
        For complex numbers and objects, or an `out` of another dtype.

    Warns
    -----
    UnboundedPackingWarning
        For a scheme whose error has no bound in steps of its grid: ``sphere``, ``matcap`` and
        ``z_phi``.

    Notes
    -----
    The same direction gives the same code on every CPU and with any number of threads. Each
    direction that a grid holds has one code, although the map may fold it to several places: -z is
    one corner of the octahedral square and not four. `canonical` names the schemes that are
    exceptions.

    Draco itself takes vectors whose components sum to 1e-6 or less for +x. ``draco`` keeps their
    directions, and has Draco's codes of all others.

    Source: Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors,
    and `Packing.source`.

    Examples
    --------
    >>> import spheremap as sm
    >>> codes = sm.packing.pack([[0, 0, 1], [0, 0, -1], [1, 0, 0]], "oct16")
    >>> codes.dtype, [hex(c) for c in codes]
    (dtype('uint16'), ['0x0', '0x7f7f', '0x7f'])
    >>> sm.packing.pack([3.0, 4.0, 0.0], "oct8x2").tolist()
    [54, 73]
    """
    scheme = _resolve(name)
    if math.isinf(scheme.about.bound):
        warnings.warn(
            f"no multiple of its step bounds the error of '{scheme.about.name}'; "
            f"{_instead(scheme.about)} has as many bits",
            UnboundedPackingWarning,
            stacklevel=2,
        )
    if scheme.fields is None:
        return scheme.core.pack(directions, rounding, invalid, out)
    if out is not None:
        _check_out(scheme, out)
    if scheme.is_view and (out is None or _viewable(out, scheme.word)):
        words = None if out is None else out.view(scheme.word)[..., 0]
        words = np.asarray(scheme.core.pack(directions, rounding, invalid, words))
        return words[..., None].view(scheme.about.dtype) if out is None else out
    words = np.asarray(scheme.core.pack(directions, rounding, invalid))
    return _split(scheme, words, out)


def unpack(
    codes: ArrayLike,
    name: str | Packing,
    /,
    *,
    dtype: DTypeLike = np.float32,
    out: NDArray[Any] | None = None,
) -> NDArray[np.floating[Any]]:
    """Unpack codes to unit vectors: the inverse of `pack`.

    Parameters
    ----------
    codes : array_like of int, shape (...) or (..., k)
        As `pack` returns them; of any integer dtype that holds them.
    name : Packing or str
        The scheme, as for `packing`.
    dtype : {float32, float64}
        The type to compute. float32 adds up to 5e-7 rad to the scheme's ``bound``, which is more
        than the bound itself where fields have 23 bits or more, as in "oct46", "oct64" and
        "oct32x2": float64 keeps that.
    out : ndarray, optional
        Where to put the result: C-contiguous, of the result's shape and dtype.

    Returns
    -------
    directions : ndarray, shape (..., 3)
        Unit vectors. NaN for a code that has no direction (three components that are all zero).

    Raises
    ------
    ValueError
        For a code out of the scheme's range, a wrong shape, an unknown name, or an unfit `out`.
    TypeError
        For codes that are no integers, another `dtype`, or an `out` of another dtype.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.packing.unpack([0x7F7F, 0x007F], "oct16").tolist()
    [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]
    """
    scheme = _resolve(name)
    real = as_float_dtype(dtype)
    return scheme.core.unpack(_words(scheme, codes), real == np.float32, out)


def canonical(codes: ArrayLike, name: str | Packing, /) -> NDArray[Any]:
    """Return one code for each direction, so that codes can be compared and counted.

    Where a map folds, one direction has several codes: the edge of the octahedral square meets
    itself, a pole has every longitude, and the field -128 of a snorm grid reads as -127.

    Parameters
    ----------
    codes : array_like of int, shape (...) or (..., k)
        Codes of the scheme.
    name : Packing or str
        The scheme, as for `packing`.

    Returns
    -------
    codes : ndarray
        Of the same shape, in the dtype of the scheme. Each decodes to the direction of the code
        that was given, within 5e-7 (2e-6 in ``draco``); codes of one direction become equal; and
        codes that this function returned stay as they are.

    Raises
    ------
    ValueError
        For a code out of the scheme's range, a wrong shape or an unknown name.
    TypeError
        For codes that are no integers.

    Notes
    -----
    Codes that `pack` wrote stay as they are, except in schemes that write several codes of one
    direction. ``snorm``, ``rgb`` and ``rgb10a2``: numbers in proportion are one direction, and the
    code returned is that of the point nearest to the unit sphere. ``pbrt``, ``unreal``, ``cesium``
    and ``meshoptimizer``: those programs write two codes on an edge of the square, where a
    component is just below 0; the code returned is that of one above.

    One direction is what is one in exact arithmetic: ``meshoptimizer`` rounds what it decodes, and
    different codes may give the same numbers. What no direction decides is 0: the last field of
    ``meshoptimizer``, the alpha of ``rgb10a2``. Two kinds of codes are never written by `pack`:
    those of ``matcap`` outside the disk, of which the first along a ray stands for all, and the
    last row and column of ``draco``, beyond its grid, which stay as they are.

    Examples
    --------
    All four corners of the square are -z:

    >>> import numpy as np
    >>> import spheremap as sm
    >>> sm.packing.canonical([[127, 127], [-127, 127], [127, -128]], "oct8x2").tolist()
    [[127, 127], [127, 127], [127, 127]]
    >>> len(np.unique(sm.packing.canonical(np.arange(2**16), "oct16")))
    64518
    >>> sm.packing.canonical([[1, 0, 0], [5, -5, 0]], "snorm8x3").tolist()
    [[127, 0, 0], [90, -90, 0]]
    """
    scheme = _resolve(name)
    words = scheme.core.canonical(_words(scheme, codes))
    if scheme.fields is None:
        return words if words.ndim else words[()]
    return _split(scheme, words, None)


def code(
    scheme: str | Packing,
    language: Language | str,
    /,
    *,
    verbs: Sequence[Literal["pack", "unpack"] | str] = ("pack", "unpack"),
    rounding: Literal["precise", "nearest", "hex"] | str = "precise",
    name: str | None = None,
    precision: Literal["exact", "native"] = "exact",
    dtype: str = "float32",
) -> str:
    """Return `pack` and `unpack` of a scheme as source text of another language.

    The text is what the library computes, operation by operation, complete in itself: from a unit
    vector to the word of its code, and back. What shaders do not need is left out: directions of
    other lengths, and a code for what is no direction.

    Parameters
    ----------
    scheme : Packing or str
        As for `packing`. Where its codes are arrays of fields, as of "oct8x2", the
        functions give and take the word that has the first field in its lowest bits.
    language : str
        As for `spheremap.code`.
    verbs : sequence of {"pack", "unpack"}
        The functions.
    rounding : {"precise", "nearest", "hex"}
        As for `pack`.
    name : str, optional
        What names begin with; the name of the scheme where nothing is said.
    precision : {"exact", "native"}
        As for `spheremap.code`.
    dtype : {"float32", "float64"}
        The width of numbers; fields of more than 16 bits want float64.

    Returns
    -------
    str
        Source text.

    Raises
    ------
    ValueError, TypeError
        For names that are unknown; schemes that are no formulas, which are `fibonacci`, `rings` and
        those that repeat other programs; options that the language does not have.

    Notes
    -----
    float64 has the integers of `pack`, and so has float32 for `oct` and `woct`. The library
    computes the other schemes in float64: in float32 a direction between two codes may get the
    other one.

    Examples
    --------
    >>> import spheremap as sm
    >>> print(sm.packing.code("oct16", "glsl", verbs=["unpack"]))  # doctest: +ELLIPSIS
    // Octahedral: oct16
    ...
    vec3 oct16_unpack(uint code) {
    ...
    }
    <BLANKLINE>
    """
    found = _resolve(scheme)
    if isinstance(verbs, str):
        raise TypeError(f"Expected a sequence of verbs, as [{verbs!r}], got a str.")
    words = [as_text(verb, "verbs") for verb in as_items(verbs, "verbs", "names of verbs")]
    _core.check_word("precision", as_text(precision, "precision"), ["exact", "native"])
    _core.check_word("dtype", as_text(dtype, "dtype"), ["float32", "float64"])
    return found.core.code(
        as_text(language, "language"),
        verbs=words,
        rounding=as_text(rounding, "rounding"),
        name=None if name is None else as_text(name, "name"),
        native=precision == "native",
        double=dtype == "float64",
    )


def best_packing(bits: int, /, *, hemisphere: bool = False, standard: bool = False) -> Packing:
    """Return the scheme with the smallest worst error that fits into so many bits.

    Parameters
    ----------
    bits : int
        The bits there are, 8 to 64.
    hemisphere : bool
        Whether all directions have z >= 0.
    standard : bool
        Whether other programs must be able to read the codes: then `woct`, which is our own, does
        not count.

    Returns
    -------
    Packing
        ``summary`` says why; ``bound`` is its worst error in radians.

    Raises
    ------
    ValueError
        For fewer than 8 or more than 64 bits.
    TypeError
        For a number of bits that is no integer.

    Notes
    -----
    Schemes that need a search to encode (spherical Fibonacci, rings) and those that repeat another
    program are not proposed. The others are compared by their stated bounds with
    ``rounding="precise"``.

    Examples
    --------
    >>> import spheremap as sm
    >>> sm.packing.best_packing(16).name, sm.packing.best_packing(16, standard=True).name
    ('woct16-centers', 'oct16-centers')
    >>> sm.packing.best_packing(16, hemisphere=True, standard=True).name
    'hemioct16-centers'
    """
    if isinstance(bits, bool) or not isinstance(bits, (int, np.integer)):
        raise TypeError(f"Expected `bits` to be an integer, got {type(bits).__name__}.")
    if not 8 <= bits <= 64:
        raise ValueError(f"Expected `bits` to be between 8 and 64, got {bits}.")
    hemisphere, standard = as_flag(hemisphere, "hemisphere"), as_flag(standard, "standard")
    found = [
        about
        for name, _, size, _, fields in _table()
        if size <= bits and size > bits - 8 and fields is None
        for facts in [_core.Packer(name).about()]
        if not facts["slow"] and (facts["standard"] or not standard)
        for about in [packing(name)]
        if about.exact is None and (hemisphere or not about.hemisphere)
    ]
    return min(found, key=lambda about: (about.bound, about.bits))


@lru_cache(maxsize=64)
def _instead(about: Packing) -> str:
    best = best_packing(max(about.bits, 8), hemisphere=about.hemisphere, standard=True)
    return f"'{best.name}'"


def _check_out(scheme: _Scheme, out: object) -> None:
    dtype = scheme.about.dtype
    if not isinstance(out, np.ndarray):
        raise TypeError(f"Expected `out` to be an array of {dtype}, got {type(out).__name__}.")
    if out.dtype != dtype:
        raise TypeError(f"Expected `out` to be an array of {dtype}, got {out.dtype}.")
    if out.shape[-1:] != scheme.about.shape:
        raise ValueError(f"Expected `out` to have shape (..., {scheme.fields}), got {out.shape}.")
    if not out.flags.c_contiguous:
        raise ValueError("Expected `out` to be C-contiguous and aligned.")
    if not out.flags.writeable:
        raise ValueError("`out` is read-only.")


def _viewable(array: NDArray[Any], word: np.dtype[Any]) -> bool:
    return bool(array.ctypes.data % word.alignment == 0)


def _split(scheme: _Scheme, words: NDArray[Any], out: NDArray[Any] | None) -> NDArray[Any]:
    """Return the fields of words, in `out` if there is one."""
    assert scheme.fields is not None
    dtype, bits = scheme.about.dtype, scheme.field_bits
    shape = (*words.shape, scheme.fields)
    if out is None:
        out = np.empty(shape, dtype)
    elif out.shape != shape:
        raise ValueError(f"Expected `out` to have shape {shape}, got {out.shape}.")
    unsigned = np.dtype(f"u{dtype.itemsize}")
    mask = scheme.word.type((1 << bits) - 1)
    for k in range(scheme.fields):
        part = (words >> scheme.word.type(k * bits)) & mask
        part = part.astype(unsigned).view(dtype) if words.ndim else part.astype(unsigned)
        out[..., k] = part if words.ndim else np.asarray(part).view(dtype)
    return out


def _words(scheme: _Scheme, codes: ArrayLike) -> NDArray[Any]:
    """Return codes, of whatever integers, as the words of a scheme."""
    array = as_array(codes, "codes")
    if array.dtype.kind not in "iu" and not (array.size == 0 and not hasattr(codes, "dtype")):
        raise TypeError(f"Expected `codes` to be integers, got dtype {array.dtype}.")
    if scheme.fields is None:
        return _held(array, scheme.word, scheme.about.name, 0, scheme.about.codes - 1)
    if array.shape[-1:] != (scheme.fields,):
        raise ValueError(
            f"Expected `codes` of '{scheme.about.name}' to have shape (..., {scheme.fields}), "
            f"got {array.shape}."
        )
    bits, signed = scheme.field_bits, scheme.signed
    low = -(1 << (bits - 1)) if signed else 0
    array = _held(array, scheme.about.dtype, scheme.about.name, low, low + (1 << bits) - 1)
    if scheme.is_view and _viewable(array, scheme.word):
        return array.view(scheme.word)[..., 0]
    words = np.zeros(array.shape[:-1], scheme.word)
    mask = scheme.word.type((1 << bits) - 1)
    for k in range(scheme.fields):
        words |= (array[..., k].astype(scheme.word) & mask) << scheme.word.type(k * bits)
    return words


def _held(
    array: NDArray[Any], dtype: np.dtype[Any], name: str, low: int, high: int
) -> NDArray[Any]:
    """Return integers in another dtype, or raise where one is not in the range of the scheme."""
    limits = np.iinfo(array.dtype) if array.dtype.kind in "iu" else None
    fits = limits is None or (low <= limits.min and limits.max <= high)
    # Views that repeat an element may be larger than any memory: that shows before they are read.
    expect_room(array.shape, dtype)
    if not fits and array.size:
        # Python integers compare exactly whatever the dtype.
        least, most = int(array.min()), int(array.max())
        if least < low or most > high:
            wrong = (array < low) if least < low else (array > high)
            place = int(np.argmax(wrong))
            raise ValueError(
                f"Expected `codes` of '{name}' to be in [{low}, {high}], "
                f"got {int(array.flat[place])} at `codes`{index_text(place, list(array.shape))}."
            )
    return np.require(array, dtype=dtype, requirements=["C", "A"])


def pack_frame(
    normals: ArrayLike,
    tangents: ArrayLike,
    name: Literal["frame32", "frame64"] | str = "frame32",
    /,
    *,
    invalid: Literal["raise", "zero"] | str = "raise",
) -> NDArray[Any]:
    """Pack tangent frames: a normal, a tangent as an angle about it, and the bitangent's sign.

    Parameters
    ----------
    normals : array_like, shape (..., 3)
        Of any length.
    tangents : array_like, shape (..., 3) or (..., 4)
        Of any length; the part perpendicular to the normal that is given counts. The sign of a
        fourth component is that of the bitangent, as in glTF; without one it is +.
    name : {"frame32", "frame64"}
        32 bits: ``oct20``, 11 bits of angle and the sign. 64 bits: ``oct40``, 23 bits and the sign.
    invalid : {"raise", "zero"}
        What becomes of a frame whose normal or tangent is zero or not finite, or whose tangent lies
        along the normal: an error that names the first, or the code 0.

    Returns
    -------
    codes : ndarray, shape (...)
        uint32 or uint64: the normal in the lowest bits, then the angle, then the sign.

    Raises
    ------
    ValueError
        For a wrong shape, an unknown name, or an invalid frame.
    TypeError
        For complex numbers and objects.

    Notes
    -----
    The angle counts from the first axis of Duff et al. 2017, Building an Orthonormal Basis,
    Revisited, about the normal as it will be decoded. The normal is off by at most the bound of its
    scheme, and the perpendicular part of the tangent by half a step of its angle (0.088° or
    2.1e-5°) more.

    Examples
    --------
    >>> import spheremap as sm
    >>> code = sm.packing.pack_frame([0, 0, 1], [0, 1, 0, -1])
    >>> normal, tangent = sm.packing.unpack_frame(code)
    >>> normal.tolist(), tangent.tolist()
    ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0, -1.0])
    """
    n, t = as_array(normals, "normals"), as_array(tangents, "tangents")
    for array, what in ((n, "normals"), (t, "tangents")):
        if array.dtype.kind not in "fiub":
            raise TypeError(f"Expected `{what}` to be real numbers, got dtype {array.dtype}.")
    expect_vectors(n.shape, "normals")
    if t.shape[-1:] not in ((3,), (4,)):
        raise ValueError(f"Expected `tangents` to have shape (..., 3) or (..., 4), got {t.shape}.")
    if as_text(invalid, "invalid") not in ("raise", "zero"):
        raise ValueError(f"Expected `invalid` to be 'raise' or 'zero', got '{invalid}'.")
    shape = common_shape(("normals", n.shape[:-1]), ("tangents", t.shape[:-1]))
    whole = np.ones((*shape, 4))
    # A signaling NaN would warn.
    with np.errstate(invalid="ignore"):
        whole[..., : t.shape[-1]] = t
        n = np.require(np.broadcast_to(n, (*shape, 3)), np.float64, ["C", "A"])
    codes, first = _core.pack_frames(n, whole, name)
    if first is not None and invalid == "raise":
        raise ValueError(
            f"the frame{index_text(first, list(shape))} has a normal or a tangent that is zero or "
            'not finite, or a tangent along its normal; `invalid` can be "zero".'
        )
    codes = np.asarray(codes, np.uint32 if name == "frame32" else np.uint64)
    return codes if shape else codes[()]


def unpack_frame(
    codes: ArrayLike,
    name: Literal["frame32", "frame64"] | str = "frame32",
    /,
    *,
    dtype: DTypeLike = np.float32,
) -> tuple[NDArray[np.floating[Any]], NDArray[np.floating[Any]]]:
    """Unpack tangent frames: the inverse of `pack_frame`.

    Parameters
    ----------
    codes : array_like of int, shape (...)
        As `pack_frame` returns them.
    name : {"frame32", "frame64"}
        What they were packed as.
    dtype : {float32, float64}
        The type of the results.

    Returns
    -------
    normals : ndarray, shape (..., 3)
        Unit vectors.
    tangents : ndarray, shape (..., 4)
        Unit vectors perpendicular to the normals, then +1 or -1: the bitangent is
        ``tangents[..., 3:] * cross(normals, tangents[..., :3])``.

    Raises
    ------
    ValueError
        For a code out of range or an unknown name.
    TypeError
        For codes that are no integers, or another `dtype`.

    Examples
    --------
    >>> import numpy as np
    >>> import spheremap as sm
    >>> code = sm.packing.pack_frame([1, 2, 3], [3, 0, -1], "frame64")
    >>> n, t = sm.packing.unpack_frame(code, "frame64")
    >>> bool(abs(np.dot(n, t[:3])) < 1e-6)
    True
    """
    real = as_float_dtype(dtype)
    name = as_text(name, "name")
    array = as_array(codes, "codes")
    if array.dtype.kind not in "iu" and not (array.size == 0 and not hasattr(codes, "dtype")):
        raise TypeError(f"Expected `codes` to be integers, got dtype {array.dtype}.")
    bits = 32 if name == "frame32" else 64
    words = _held(array, np.dtype(np.uint64), name, 0, (1 << bits) - 1)
    # + 0: no -0.
    both = (_core.unpack_frames(words, name) + 0.0).astype(real, copy=False)
    return np.ascontiguousarray(both[..., :3]), np.ascontiguousarray(both[..., 3:])
