"""Verbs of maps on arrays of ndonnx: graphs of ONNX, computed at once or by another program."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm
from conftest import random_directions

ndx = pytest.importorskip("ndonnx")

pytestmark = pytest.mark.programs


@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("case", ["latlong", "cube", "sphere"])
def test_verbs_are_those_of_numpy(case: str, dtype: type) -> None:
    d = random_directions(200, 1).astype(dtype)
    d[0] = 0.0
    uv = sm.encode(d, case)
    given = [(sm.encode, d), (sm.decode, uv), (sm.density, uv)]
    for verb, data in given:
        found = verb(ndx.asarray(data), case)  # type: ignore[operator]
        assert isinstance(found, ndx.Array)
        wanted = verb(data, case)  # type: ignore[operator]
        assert found.unwrap_numpy().dtype == wanted.dtype
        # One normalization more, and polynomials that magnify it: a few roundings.
        tolerance = 8 * np.finfo(dtype).eps
        np.testing.assert_allclose(found.unwrap_numpy(), wanted, rtol=tolerance, atol=tolerance)


def test_a_map_is_a_model() -> None:
    runtime = pytest.importorskip("onnxruntime")
    d = random_directions(200, 2).astype(np.float32)
    given = ndx.argument(shape=("N", 3), dtype=ndx.float32)
    model = ndx.build({"directions": given}, {"uv": sm.encode(given, "latlong")})
    session = runtime.InferenceSession(model.SerializeToString())
    (found,) = session.run(["uv"], {"directions": d})
    # One normalization more, of u and v of up to 1.
    np.testing.assert_allclose(found, sm.encode(d, "latlong"), rtol=0, atol=5e-7)
