"""Printed harmonics are those of `sh.evaluate`, compiled as C and run as NumPy."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from printed import LANGUAGES, called, compiled, directions

LOOP = """
void all(const {number}* in, {number}* out, long n) {{
    for (long i = 0; i < n; i++) {call};
}}
"""


@pytest.mark.parametrize("dtype", [np.float32, np.float64], ids=["f32", "f64"])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("order", range(9))
def test_printed_sums_are_those_of_evaluate(
    order: int, channels: int, dtype: type, tmp_path: Path
) -> None:
    c = np.random.default_rng(order).normal(size=((order + 1) ** 2, channels))
    d = directions(dtype)
    wanted = sm.sh.evaluate(c, d)
    options: dict[str, Any] = {"name": "m", "dtype": dtype.__name__}
    call = (
        "out[i] = m_evaluate(in + 3 * i)"
        if channels == 1
        else "m_evaluate(in + 3 * i, out + 3 * i)"
    )
    number = "float" if dtype is np.float32 else "double"
    text = sm.sh.code(c, "c", **options) + LOOP.format(number=number, call=call)
    library = compiled(text, tmp_path, "-Wno-unused-parameter")
    found = called(library.all, d, np.empty((len(d), channels), dtype))
    names: dict[str, Any] = {}
    exec(sm.sh.code(c, "numpy", **options), names)
    assert np.array_equal(names["m_evaluate"](d).reshape(found.shape), found)
    # Each basis function rounds ten times a degree at the most, and is at most sqrt((2l + 1)/4 pi);
    # the library, too, brings the direction to length 1, which moves a polynomial of degree l by l
    # roundings.
    degrees = np.repeat(np.arange(order + 1), 2 * np.arange(order + 1) + 1)
    size = (np.abs(c) * np.sqrt((2 * degrees + 1) / (4 * np.pi))[:, None]).sum(axis=0).max()
    assert np.abs(found - wanted).max() <= 10 * (order + 1) * size * np.finfo(dtype).eps


@pytest.mark.parametrize("language", [entry["name"] for entry in LANGUAGES])
def test_harmonics_print_in_every_language(language: str) -> None:
    for c in ([1.0], [1.0, 0.0, 0.5, 0.0], np.ones((25, 3))):
        text = sm.sh.code(c, language, name="sky")
        assert re.search(r"\bsky_evaluate\(", text)
        assert not re.search(r"\b(inf|NaN)\b", re.sub(r"(//|#).*", "", text))


def test_options_are_checked() -> None:
    code: Any = sm.sh.code
    for arguments, options, says in [
        (([1.0], "glls"), {}, "did you mean 'glsl'"),
        (([1.0, 2.0], "glsl"), {}, "(order + 1)"),
        ((np.ones((4, 2)), "glsl"), {}, "one channel or three"),
        ((np.ones(100), "glsl"), {}, "up to order 8"),
        (([np.inf], "glsl"), {}, "finite"),
        (([1e300], "glsl"), {}, "finite"),
        (([1.0], "wgsl"), {"dtype": "float64"}, "64 bits"),
        (([1.0], "glsl"), {"name": "1st"}, "a letter"),
    ]:
        with pytest.raises(ValueError, match=re.escape(says)):
            code(*arguments, **options)
