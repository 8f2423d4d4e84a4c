"""Maps as source text of other languages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from .. import _core
from .._scalars import as_items, as_text
from .named import resolve

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .._names import CodeVerb, Language
    from .named import ProjectionLike

__all__ = ["code"]

Precision: TypeAlias = Literal["exact", "native"]


def code(
    projection: ProjectionLike,
    language: Language | str,
    *,
    verbs: Sequence[CodeVerb | str] = ("encode", "decode"),
    name: str | None = None,
    precision: Precision = "exact",
    dtype: str = "float32",
    rotation: Any | None = None,
) -> str:
    """Return verbs of a map as source text of another language, complete in itself.

    The text is what the library computes, operation by operation, with axes, rotation, layout, face
    order and parameters of the map folded in. What a shader does not need is left out: scaling of
    directions that are far from unit length, and NaN for places outside the valid image, which
    `valid` answers for.

    Parameters
    ----------
    projection : Projection or str
        As for `projection`.
    language : str
        "glsl", "glsl_es", "hlsl", "slang", "wgsl", "msl", "osl", "c", "cuda", "opencl", "numpy",
        "array_api", "torch" or "jax".
    verbs : sequence of str
        The functions: "encode", "decode", "density", "jacobian", "valid"; "taps", the columns, rows
        and weights of the four texels of a bilinear lookup in a direction, and their faces where
        these are apart, as `sample` mixes them across a seam, or a seamless sampler across an edge
        of a cube; "reflect", which takes a view vector and a normal and gives the direction to look
        up. A function takes and gives the language's vectors: a direction has three numbers,
        image coordinates two, (u, v), or three, (u, v, face). In C they are arrays, and NumPy,
        torch and JAX take arrays (..., 3) and (..., 2).
    name : str, optional
        What names begin with; the projection's name where nothing is said.
    precision : {"exact", "native"}
        Whether sines, arctangents and the like are the library's polynomials, which have its bits
        and bounds, or the language's own, which may be faster and are worse: WGSL allows an
        arctangent 4096 units in the last place.
    dtype : {"float32", "float64"}
        The width of numbers; float64 in languages that have it.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        As for `convert`: turns the map in the world.

    Returns
    -------
    str
        Source text.

    Raises
    ------
    ValueError, TypeError
        For names that are unknown, options that the language does not have, and "taps" of a map
        whose seams do not join texel to texel, as of mirror balls.

    Notes
    -----
    Formulas and sources are those of `projection`; docs/languages.md tells what ran where.
    `packing.code` prints codes of unit vectors, `sh.code` spherical harmonics.

    Examples
    --------
    >>> import spheremap as sm
    >>> print(sm.code("octahedral", "glsl", verbs=["encode"]))  # doctest: +ELLIPSIS
    // Octahedral map: octahedral
    ...
    vec2 octahedral_encode(vec3 d) {
    ...
    }
    <BLANKLINE>
    """
    if isinstance(verbs, str):
        raise TypeError(f"Expected a sequence of verbs, as [{verbs!r}], got a str.")
    words = [as_text(verb, "verbs") for verb in as_items(verbs, "verbs", "names of verbs")]
    _core.check_word("precision", as_text(precision, "precision"), ["exact", "native"])
    _core.check_word("dtype", as_text(dtype, "dtype"), ["float32", "float64"])
    return _core.code(
        resolve(projection, rotation=rotation),
        as_text(language, "language"),
        verbs=words,
        name=None if name is None else as_text(name, "name"),
        native=precision == "native",
        double=dtype == "float64",
    )
