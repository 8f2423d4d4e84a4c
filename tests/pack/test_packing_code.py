"""Printed packings do what the library does: compiled as C, run as NumPy, to the bit."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from printed import (
    LANGUAGES,
    PACKINGS,
    PACKINGS_DOUBLE,
    Array,
    assert_packs_alike,
    called,
    compiled,
    roundings,
)

CASES = [
    (dtype, name, rounding)
    for dtype, names in ((np.float32, PACKINGS), (np.float64, PACKINGS_DOUBLE))
    for name in names
    for rounding in roundings(name)
]
IDS = [f"{dtype.__name__}-{name}-{rounding}" for dtype, name, rounding in CASES]


def label(name: str, rounding: str) -> str:
    """Return what functions of a case are called."""
    return f"{name.replace('-', '_')}_{rounding}"


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Callable[[type], ctypes.CDLL]:
    """Return every case as one library of C, by width."""

    @cache
    def of_type(dtype: type) -> ctypes.CDLL:
        number = "float" if dtype is np.float32 else "double"
        parts = []
        for width, name, rounding in CASES:
            if width is not dtype:
                continue
            m = label(name, rounding)
            options: dict[str, Any] = {"rounding": rounding, "name": m, "dtype": dtype.__name__}
            parts.append(sm.packing.code(name, "c", **options))
            loop = "{\n    for (long i = 0; i < n; i++)"
            parts.append(
                f"void all_{m}_pack(const {number}* in, uint64_t* out, long n) {loop} "
                f"out[i] = {m}_pack(in + 3 * i);\n}}\n"
                f"void all_{m}_unpack(const uint64_t* in, {number}* out, long n) {loop} "
                f"{m}_unpack(in[i], out + 3 * i);\n}}\n"
            )
        folder = tmp_path_factory.mktemp("packings")
        return compiled("\n".join(parts), folder, "-Wno-unused-parameter")

    return of_type


@pytest.mark.runs("cc", language="c")
@pytest.mark.parametrize(("dtype", "name", "rounding"), CASES, ids=IDS)
def test_compiled_c_has_the_integers_of_the_library(
    dtype: type, name: str, rounding: str, library: Callable[[type], ctypes.CDLL]
) -> None:
    def verb(which: str, data: Array, out: Array) -> Array:
        return called(library(dtype)[f"all_{label(name, rounding)}_{which}"], data, out)

    def pack(d: Array) -> Array:
        return verb("pack", d, np.empty(len(d), np.uint64))

    def unpack(words: Array) -> Array:
        return verb("unpack", np.ascontiguousarray(words), np.empty((len(words), 3), dtype))

    assert_packs_alike(name, rounding, dtype, pack, unpack)


@pytest.mark.runs("numpy", language="numpy")
@pytest.mark.parametrize(("dtype", "name", "rounding"), CASES, ids=IDS)
def test_numpy_has_the_integers_of_the_library(dtype: type, name: str, rounding: str) -> None:
    names: dict[str, Any] = {}
    options: dict[str, Any] = {"rounding": rounding, "name": "m", "dtype": dtype.__name__}
    exec(sm.packing.code(name, "numpy", **options), names)

    def quiet(function: str) -> Callable[[Array], Array]:
        def run(data: Array) -> Array:
            with np.errstate(all="ignore"):
                out: Array = names[function](data)
            return out

        return run

    assert_packs_alike(name, rounding, dtype, quiet("m_pack"), quiet("m_unpack"))


@pytest.mark.parametrize("language", [entry["name"] for entry in LANGUAGES])
def test_every_packing_prints_in_every_language(language: str) -> None:
    for name in PACKINGS:
        if name == "snorm16x3" and language in ("glsl", "glsl_es", "hlsl", "wgsl", "osl"):
            with pytest.raises(ValueError, match="48 bits"):
                sm.packing.code(name, language)
            continue
        text = sm.packing.code(name, language, name="some_name")
        for verb in ("pack", "unpack"):
            assert re.search(rf"\bsome_name_{verb}\(", text)
        assert not re.search(r"\b(inf|NaN)\b", re.sub(r"(//|#).*", "", text))
        opened = re.findall(r"^\w[\w ]* (\w+)\(", text, re.M)
        assert opened and all(function.startswith("some_name_") for function in opened)


def test_options_are_checked() -> None:
    code: Any = sm.packing.code
    for arguments, options, says in [
        (("oct17", "glsl"), {}, "did you mean 'oct"),
        (("oct16", "glls"), {}, "did you mean 'glsl'"),
        (("oct16", "glsl"), {"verbs": ["pak"]}, "did you mean 'pack'"),
        (("oct16", "glsl"), {"verbs": []}, "at least one verb"),
        (("oct16", "glsl"), {"name": "1st"}, "a letter"),
        (("oct16", "glsl"), {"rounding": "up"}, "'precise' or 'hex'"),
        (("oct40", "glsl"), {}, "20 bits"),
        (("oct40", "glsl"), {"dtype": "float64"}, "40 bits"),
        (("oct16", "wgsl"), {"dtype": "float64"}, "64 bits"),
        (("fibonacci16", "c"), {}, "searches"),
        (("draco8x2", "c"), {}, "another program"),
    ]:
        with pytest.raises(ValueError, match=re.escape(says)):
            code(*arguments, **options)
    with pytest.raises(TypeError, match="Expected"):
        code("oct16", "glsl", verbs="pack")


def test_only_what_is_asked_for_is_printed() -> None:
    text = sm.packing.code("oct16", "glsl", verbs=["unpack"])
    assert "oct16_unpack" in text and "_pack(" not in text.replace("un_pack", "")
    assert "oct16_centers_pack(" in sm.packing.code("oct16-centers", "hlsl")
