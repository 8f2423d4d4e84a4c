"""Printed code of maps as functions, for libraries whose arrays the kernels do not take."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from .coding import code
from .spec import HELD, map_of

__all__ = ["compiled"]

VERBS = ("encode", "decode", "density", "jacobian", "valid", "reflect")


@lru_cache(HELD)
def compiled(
    spec: str, language: str, double: bool, verbs: tuple[str, ...] = VERBS
) -> dict[str, Callable[..., Any]]:
    """Return verbs of a map in one of Python's languages, in float64 or float32."""
    dtype = "float64" if double else "float32"
    names: dict[str, Any] = {}
    exec(code(map_of(spec), language, verbs=verbs, name="m", dtype=dtype), names)
    return {verb: names[f"m_{verb}"] for verb in verbs}
