"""Printed JAX, compiled (`make test-printed`)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import spheremap as sm
from oracles import need
from printed import (
    CASES,
    PACKINGS,
    TAPPED,
    VERBS,
    Array,
    asked,
    assert_alike,
    assert_native,
    assert_packs_alike,
    assert_sums_alike,
    assert_taps,
    directions,
    made,
    roundings,
)

pytestmark = [pytest.mark.programs, pytest.mark.runs("jax", language="jax")]


def functions(p: sm.Projection, *verbs: str) -> dict[str, Any]:
    """Return verbs of a map."""
    names: dict[str, Any] = {}
    exec(sm.code(p, "jax", verbs=verbs, name="m"), names)
    return {verb: names[f"m_{verb}"] for verb in verbs}


@pytest.mark.parametrize("case", CASES)
def test_jax_is_within_the_bounds(case: str) -> None:
    jax = need("jax")
    p = made(case)
    verbs = functions(p, *VERBS)

    # All at once: compilers take longer to start than to run.
    @jax.jit
    def run(given: dict[str, Array]) -> dict[str, Any]:
        return {verb: verbs[verb](data) for verb, data in given.items()}

    found = {verb: np.asarray(out) for verb, out in run(asked(p, np.float32)).items()}
    # Columns one after the other.
    found["jacobian"] = np.swapaxes(found["jacobian"], -1, -2).reshape(-1, 6)
    assert len(directions(np.float32)) > 20_000
    assert_alike(p, np.float32, lambda verb, _: found[verb], exact=False)


def test_jax_reflects() -> None:
    jax = need("jax")
    reflect = jax.jit(functions(made("latlong"), "reflect")["reflect"])
    view = directions(np.float32)
    normal = np.roll(view, 7, axis=0)
    # A dozen roundings of numbers up to 2.
    few = 24 * float(np.finfo(np.float32).eps)
    assert np.abs(np.asarray(reflect(view, normal)) - sm.reflect(view, normal)).max() <= few


@pytest.mark.parametrize(("case", "size"), TAPPED)
def test_jax_taps(case: str, size: tuple[int, int]) -> None:
    jax = need("jax")
    taps = jax.jit(functions(made(case), "taps")["taps"])
    extent = np.array(size[::-1], np.float32)
    assert_taps(case, size, lambda d: np.concatenate(taps(d, extent), axis=-1))


@pytest.mark.parametrize("case", CASES)
def test_jax_has_functions_of_its_own(case: str) -> None:
    jax = need("jax")
    p = made(case)
    names: dict[str, Any] = {}
    exec(sm.code(p, "jax", name="m", precision="native"), names)
    assert_native(p, jax.jit(lambda d: names["m_decode"](names["m_encode"](d))))


@pytest.mark.parametrize("name", [n for n in PACKINGS if sm.packing.packing(n).bits <= 32])
def test_jax_packs(name: str) -> None:
    jax = need("jax")
    for rounding in roundings(name):
        names: dict[str, Any] = {}
        exec(sm.packing.code(name, "jax", rounding=rounding, name="m"), names)
        pack, unpack = jax.jit(names["m_pack"]), jax.jit(names["m_unpack"])
        assert_packs_alike(
            name,
            rounding,
            np.float32,
            lambda d, pack=pack: np.asarray(pack(d)),
            lambda words, unpack=unpack: np.asarray(unpack(words.astype(np.uint32))),
            exact=False,
        )


@pytest.mark.parametrize("channels", [1, 3])
def test_jax_sums_harmonics(channels: int) -> None:
    jax = need("jax")

    def run(text: str, d: Array) -> Array:
        names: dict[str, Any] = {}
        exec(text, names)
        return np.asarray(jax.jit(names["m_evaluate"])(d)).reshape(len(d), -1)

    assert_sums_alike("jax", channels, run)
