"""Printed JAX, compiled (`make test-printed`)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import spheremap as sm
from oracles import need
from printed import CASES, TAPPED, VERBS, Array, asked, assert_alike, assert_taps, directions, made

pytestmark = pytest.mark.programs


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
