"""Printed Open Shading Language, run by Cycles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import spheremap as sm
from printed import CASES, VERBS, Array, assert_alike, assert_native, directions, made

from oracles import osl_oracle

pytestmark = [pytest.mark.programs, pytest.mark.runs("cycles", language="osl")]


@pytest.fixture(scope="module")
def cycles(tmp_path_factory: pytest.TempPathFactory) -> Iterator[osl_oracle.Shading]:
    with osl_oracle.shading(tmp_path_factory.mktemp("osl")) as shading:
        yield shading


@pytest.mark.parametrize("case", CASES)
def test_cycles_is_within_the_bounds(case: str, cycles: osl_oracle.Shading) -> None:
    p = made(case)
    width = p.encode(np.zeros(3)).shape[-1]
    text = sm.code(p, "osl", verbs=VERBS, name="m")
    columns = "vector s, t; m_jacobian(given, s, t); r = {column};"
    of = {
        "encode": ("r = m_encode(given);", width),
        "decode": ("r = m_decode(given);", 3),
        "density": ("r[0] = m_density(given);", 1),
        "valid": ("r[0] = m_valid(given);", 1),
    }

    def verb(name: str, data: Array) -> Array:
        if name == "jacobian":
            parts = [cycles.run(text, columns.format(column=c), data) for c in "st"]
            return np.concatenate(parts, axis=1)
        call, n = of[name]
        out = cycles.run(text, call, data)[:, :n]
        return out[:, 0] if n == 1 else np.ascontiguousarray(out)

    assert_alike(p, np.float32, verb, exact=False)
    d = directions(np.float32)
    outside = d[np.isnan(p.encode(d)[:, 0])]
    assert len(outside) == 0 or (verb("encode", outside)[:, :2] == -1).all()


@pytest.mark.parametrize("case", CASES)
def test_cycles_has_functions_of_its_own(case: str, cycles: osl_oracle.Shading) -> None:
    p = made(case)
    text = sm.code(p, "osl", name="m", precision="native")
    assert_native(p, lambda d: cycles.run(text, "r = m_decode(m_encode(given));", d))
