"""The verbs of maps whose parameters are arrays of JAX: the kernels, called from the program.

Parameters are one array; `spec` is the map without them, `names` says which they are. What a
kernel makes of its parameters beforehand is in no printed code, so that values are those of the
kernels, and derivatives those of `map.moving`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from ..map import moving
from ..map.spec import HELD, map_of, spec_of
from . import _images, _sums, _verbs

if TYPE_CHECKING:
    from .._projection import Projection
    from ..map.named import ProjectionLike


@dataclass(frozen=True)
class Moving:
    """A map with parameters that are arrays of JAX."""

    # The text of the map with the numbers that are known; others are what they are by themselves.
    spec: str
    parameters: dict[str, jax.Array]

    def __repr__(self) -> str:
        given = ", ".join(f"{name}={one!r}" for name, one in self.parameters.items())
        return f"projection({map_of(self.spec)!r}, {given})"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the arrays."""
        return tuple(self.parameters)

    @property
    def fixed(self) -> str:
        """The text of the map without them."""
        return moving.spec_without(map_of(self.spec), self.names)

    @property
    def is_known(self) -> bool:
        """Whether all numbers are known, as they are outside of JAX's transforms."""
        return None not in [_value(one) for one in self.parameters.values()]

    def together(self) -> jax.Array:
        """Return the parameters as one array."""
        return jnp.stack([jnp.asarray(one) for one in self.parameters.values()])

    def seen(self, axes: str | None, rotation: Any | None) -> Moving:
        """Return it with other axes, and its world turned."""
        if axes is None and rotation is None:
            return self
        return Moving(spec_of(map_of(self.spec), axes, rotation), self.parameters)

    def in_world_of(self, other: str) -> Moving:
        """Return it with its directions in the world of the map of a text."""
        return Moving(spec_of(map_of(self.spec).in_world_of(map_of(other))), self.parameters)

    def encode(self, directions: jax.Array) -> jax.Array:
        """Return places."""
        return encode(directions, self.together(), self.fixed, self.names)

    def decode(self, uv: jax.Array) -> jax.Array:
        """Return directions."""
        return decode(uv, self.together(), self.fixed, self.names)

    def sample(
        self, image: jax.Array, directions: jax.Array, filter: str, fill: float
    ) -> jax.Array:
        """Return values (..., channels) of an image in directions."""
        rule = Seen(self.fixed, self.names, tuple(image.shape[:-1]), filter, fill)
        return _sums.apply(rule, image, directions, self.together())


def now(projection: ProjectionLike | Moving) -> ProjectionLike:
    """Return a map with the numbers that are known."""
    return map_of(projection.spec) if isinstance(projection, Moving) else projection


def seen(
    projection: ProjectionLike | Moving, axes: str | None, rotation: Any | None
) -> tuple[str, Moving | None]:
    """Return a map with other axes, its world turned, as text, and as what moves if it does."""
    if not isinstance(projection, Moving):
        return spec_of(projection, axes, rotation), None
    moving = projection.seen(axes, rotation)
    return moving.spec, moving


def projection(name: ProjectionLike, /, **parameters: Any) -> Projection | Moving:
    """Return a projection with parameters that are arrays; see `spheremap.jax.projection`."""
    arrays = {key: value for key, value in parameters.items() if isinstance(value, jax.Array)}
    numbers = {key: value for key, value in parameters.items() if key not in arrays}
    if not arrays:
        return moving.made(name, numbers)
    for key, array in arrays.items():
        if array.ndim != 0 or not jnp.issubdtype(array.dtype, jnp.floating):
            raise ValueError(
                f"Expected `{key}` to be one float, an array without axes, got {array.dtype} of "
                f"shape {array.shape}."
            )
    return Moving(
        moving.now(name, numbers, {key: _value(one) for key, one in arrays.items()}), arrays
    )


def _value(array: jax.Array) -> float | None:
    """Return the number in an array; None where a transform hides it."""
    try:
        return float(array)
    except jax.errors.ConcretizationTypeError:
        return None


# Maps ---------------------------------------------------------------------------------------------

Values = tuple[float, ...]


def _moved(verb: str, spec: str, names: tuple[str, ...]) -> Callable[[Any, Values], Any]:
    return lambda data, values: getattr(moving.moved(spec, names, values), verb)(data)


def _derived(verb: str, spec: str, names: tuple[str, ...]) -> Callable[[Any, Values], Any]:
    function = moving.encode_slopes if verb == "encode" else moving.decode_slopes
    # Where a map has no value nothing changes.
    return lambda data, values: np.nan_to_num(function(spec, names, values, data))


@lru_cache(HELD)
def _calls(
    kind: Callable[..., Any], verb: str, spec: str, names: tuple[str, ...], tail: tuple[int, ...]
) -> Any:
    """Return a verb as a compiled program that calls the kernels; under `vmap`, of maps in turn."""
    verb_of = kind(verb, spec, names)

    def call(data: Any, parameters: Any) -> Any:
        given, numbers = np.asarray(data), np.asarray(parameters)
        axes = numbers.ndim - 1
        own = given.shape[axes:]
        lead = np.broadcast_shapes(given.shape[:axes], numbers.shape[:axes])
        whole = np.broadcast_to(given, (*lead, *own))
        out = np.empty((*lead, *own[:-1], *tail), given.dtype)
        for index in np.ndindex(numbers.shape[:axes]):
            # All of an axis along which the map is one.
            sides = zip(index, numbers.shape, strict=False)
            some = tuple(k if n > 1 else slice(None) for k, n in sides)
            out[some] = verb_of(whole[some], tuple(numbers[index].tolist()))
        return out

    def program(data: jax.Array, parameters: jax.Array) -> jax.Array:
        result = jax.ShapeDtypeStruct((*data.shape[:-1], *tail), data.dtype)
        found: jax.Array = jax.pure_callback(
            call, result, data, parameters, vmap_method="expand_dims"
        )
        return found

    return jax.jit(program)


@partial(jax.custom_jvp, nondiff_argnums=(2, 3))
def encode(
    directions: jax.Array, parameters: jax.Array, spec: str, names: tuple[str, ...]
) -> jax.Array:
    """Return places of directions of any length."""
    tail = (_verbs.width(spec),)
    found: jax.Array = _calls(_moved, "encode", spec, names, tail)(directions, parameters)
    return found


@partial(jax.custom_jvp, nondiff_argnums=(2, 3))
def decode(uv: jax.Array, parameters: jax.Array, spec: str, names: tuple[str, ...]) -> jax.Array:
    """Return directions of places."""
    found: jax.Array = _calls(_moved, "decode", spec, names, (3,))(uv, parameters)
    return found


@partial(jax.custom_jvp, nondiff_argnums=(2, 3, 4))
def _slopes(
    data: jax.Array, parameters: jax.Array, verb: str, spec: str, names: tuple[str, ...]
) -> jax.Array:
    """Return derivatives by what is mapped and by the parameters, in the last axis."""
    rows, columns = (2, 3) if verb == "encode" else (3, 2)
    tail = (rows, columns + len(names))
    found: jax.Array = _calls(_derived, verb, spec, names, tail)(data, parameters)
    return found


def _no_second(*_: Any) -> Any:
    raise NotImplementedError("Maps with parameters that are arrays have no second derivative.")


def _encode_jvp(
    spec: str, names: tuple[str, ...], primals: tuple[Any, Any], tangents: tuple[Any, Any]
) -> tuple[jax.Array, jax.Array]:
    uv = encode(*primals, spec, names)
    along = _along(_slopes(*primals, "encode", spec, names), *tangents)
    # The number of a face does not change.
    padding = [(0, 0)] * (along.ndim - 1) + [(0, uv.shape[-1] - 2)]
    return uv, jnp.pad(along, padding)


def _decode_jvp(
    spec: str, names: tuple[str, ...], primals: tuple[Any, Any], tangents: tuple[Any, Any]
) -> tuple[jax.Array, jax.Array]:
    of_uv, of_parameters = tangents
    along = _along(_slopes(*primals, "decode", spec, names), of_uv[..., :2], of_parameters)
    return decode(*primals, spec, names), along


def _along(slopes: jax.Array, of_data: jax.Array, of_parameters: jax.Array) -> jax.Array:
    """Return how the result changes."""
    count = of_data.shape[-1]
    by_data = jnp.sum(slopes[..., :count] * of_data[..., None, :], axis=-1)
    along: jax.Array = by_data + slopes[..., count:] @ of_parameters.astype(slopes.dtype)
    return along


_slopes.defjvp(_no_second)
encode.defjvp(_encode_jvp)
decode.defjvp(_decode_jvp)


# Lookups ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Seen:
    """Lookups by the kernels, in images of one shape of a map that moves."""

    spec: str
    names: tuple[str, ...]
    image: tuple[int, ...]
    filter: str
    fill: float
    is_adjoint: bool = False

    @property
    def adjoint(self) -> Seen:
        """The transposed one."""
        return self._with(0.0, not self.is_adjoint)

    @property
    def plain(self) -> Seen:
        """The same, of black images black."""
        return self._with(0.0, self.is_adjoint)

    def _with(self, fill: float, is_adjoint: bool) -> Seen:
        return Seen(self.spec, self.names, self.image, self.filter, fill, is_adjoint)

    def shape(self, directions: Any, parameters: Any) -> tuple[int, ...]:
        """Return the shape of the result without channels."""
        return self.image if self.is_adjoint else tuple(directions.shape[:-1])

    def tangent(
        self,
        image: jax.Array,
        directions: jax.Array,
        parameters: jax.Array,
        of_directions: jax.Array,
        of_parameters: jax.Array,
    ) -> jax.Array:
        """Return how lookups change: by the slopes between texels."""
        if self.filter != "bilinear" or self.is_adjoint:
            raise NotImplementedError(
                "`sample` has a derivative by directions where it is bilinear, and no second one."
            )
        slopes = _sums.apply(
            Slopes(self.spec, self.names, self.image), image, directions, parameters
        )
        of_uv = _along(
            _slopes(directions, parameters, "encode", self.spec, self.names),
            of_directions,
            of_parameters,
        )
        by_u, by_v = (of_uv[..., k : k + 1].astype(image.dtype) for k in range(2))
        return slopes[0] * by_u + slopes[1] * by_v

    def run(self, image: Any, directions: Any, parameters: Any) -> Any:
        """Look up, or give back to the texels."""
        spec, looked = _standing(self.spec, self.names, directions, parameters)
        rule = _images.Seen(spec, self.image, self.filter, self.fill, self.is_adjoint)
        return rule.run(image, looked)

    def traced(self, image: jax.Array, *given: jax.Array) -> jax.Array:
        """Ask the kernels from the device."""
        return _sums.called(self, image, *given)


@dataclass(frozen=True)
class Slopes:
    """The derivatives of bilinear lookups by u and v, two for each direction."""

    spec: str
    names: tuple[str, ...]
    image: tuple[int, ...]

    @property
    def adjoint(self) -> Slopes:
        """There is none: second derivatives are an error."""
        raise NotImplementedError("`sample` has no second derivative by directions.")

    @property
    def plain(self) -> Slopes:
        """The same."""
        return self

    def shape(self, directions: Any, parameters: Any) -> tuple[int, ...]:
        """Return the shape of the result without channels."""
        return (2, *directions.shape[:-1])

    def tangent(self, image: jax.Array, *given: Any) -> jax.Array:
        """There is none."""
        raise NotImplementedError("`sample` has no second derivative by directions.")

    def run(self, image: Any, directions: Any, parameters: Any) -> Any:
        """Return slopes of lookups by the kernels."""
        spec, looked = _standing(self.spec, self.names, directions, parameters)
        return _images.Slopes(spec, self.image).run(image, looked)

    def traced(self, image: jax.Array, *given: jax.Array) -> jax.Array:
        """Ask the kernels from the device."""
        return _sums.called(self, image, *given)


def _standing(
    spec: str, names: tuple[str, ...], directions: Any, parameters: Any
) -> tuple[str, Any]:
    """Return a map that stands still and what directions are in it: images are looked up alike.

    So what is prepared for lookups serves all steps of a search.
    """
    p = moving.moved(spec, names, tuple(parameters.tolist()))
    rest = moving.at_rest(p, names)
    return spec_of(rest), rest.decode(p.encode(directions))
