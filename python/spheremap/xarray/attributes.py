"""Projections as attributes, which zarr and NetCDF keep: words and numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..map.named import projection

if TYPE_CHECKING:
    from collections.abc import Mapping

    from .._projection import Projection

__all__ = ["attributes", "described", "without"]

# All that a projection may be said by.
_WORDS = ("convention", "axes", "grid", "layout", "world")
_NAMES = ("projection", *_WORDS, "pose")


def attributes(p: Projection) -> dict[str, Any]:
    """Return what says a projection."""
    parameters = ", ".join(f"{name}={value!r}" for name, value in p.parameters.items())
    said: dict[str, Any] = {"projection": f"{p.name}({parameters})" if parameters else p.name}
    words = {name: getattr(p, name) for name in _WORDS}
    said |= {name: word for name, word in words.items() if word is not None}
    if p.pose is not None:
        said["pose"] = np.ravel(p.pose).tolist()
    return said


def described(said: Mapping[Any, Any]) -> Projection:
    """Return the projection that attributes say, or raise ValueError."""
    if "projection" not in said:
        raise ValueError(
            "This array does not say its projection: .sphere.assign('latlong') returns one "
            "that does."
        )
    words: dict[str, Any] = {name: str(said[name]) for name in _WORDS if said.get(name) is not None}
    p: Projection = projection(str(said["projection"]), **words)
    return p.turned(np.reshape(said["pose"], (3, 3))) if said.get("pose") is not None else p


def without(said: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return all other attributes."""
    return {name: value for name, value in said.items() if name not in _NAMES}
