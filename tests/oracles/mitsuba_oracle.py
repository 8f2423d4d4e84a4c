"""mitsuba's ``envmap`` emitter as a lookup table of directions."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import need


def mitsuba() -> Any:
    """Give the module with the variant that needs nothing else installed."""
    mi = need("mitsuba")
    if mi.variant() != "scalar_rgb":
        mi.set_variant("scalar_rgb")
    return mi


def version() -> str:
    return f"mitsuba {mitsuba().__version__} (scalar_rgb)"


def lookup(
    image: np.ndarray, directions: np.ndarray, to_world: np.ndarray | None = None
) -> np.ndarray:
    """Radiance that a float32 (H, W, 3) environment sends from each direction, (N, 3) float64."""
    mi = mitsuba()
    scene: dict[str, Any] = {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(image, np.float32)),
    }
    if to_world is not None:
        matrix = np.eye(4)
        matrix[:3, :3] = to_world
        scene["to_world"] = mi.ScalarTransform4f(matrix)
    emitter = mi.load_dict(scene)
    si = mi.SurfaceInteraction3f()
    out = np.empty((len(directions), 3))
    evaluate, vector = emitter.eval, mi.Vector3f
    # The emitter is asked from inside: wi points away from the light that arrives.
    for i, (x, y, z) in enumerate((-np.asarray(directions, np.float64)).tolist()):
        si.wi = vector(x, y, z)
        out[i] = evaluate(si)
    return out
