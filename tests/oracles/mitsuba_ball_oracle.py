"""mitsuba's pictures of a perfectly mirroring ball in an environment."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import mitsuba_oracle


def photo(
    environment: np.ndarray,
    view: Any,
    pose: np.ndarray,
    *,
    samples: int = 9,
    scale: int = 1,
    crop: tuple[int, int, int, int] | None = None,
    background: bool = True,
    bsdf: dict[str, Any] | None = None,
) -> np.ndarray:
    """Render what a camera sees of the unit ball at the origin.

    `view` says where the ball is in the picture (its size, fov, distance and direction), `pose` how
    the camera is turned. `scale` makes the picture larger, of which `crop` (x, y, width, height)
    is rendered.
    """
    mi = mitsuba_oracle.mitsuba()
    height, width = (n * scale for n in view.size)
    matrix = np.eye(4)
    # mitsuba's camera looks along its +z, with +x to the left.
    matrix[:3, :3] = pose @ np.diag([-1.0, 1.0, -1.0])
    matrix[:3, 3] = pose @ (view.distance * view.toward)
    film: dict[str, Any] = {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
        "component_format": "float32",
    }
    if crop is not None:
        names = "crop_offset_x", "crop_offset_y", "crop_width", "crop_height"
        film.update(zip(names, crop, strict=True))
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 3, "hide_emitters": not background},
            "sensor": {
                "type": "perspective",
                "fov": view.fov,
                "fov_axis": "x",
                "near_clip": 0.01,
                "to_world": mi.ScalarTransform4f(matrix),
                "film": film,
                "sampler": {"type": "stratified", "sample_count": samples, "seed": 7},
            },
            "ball": {"type": "sphere", "bsdf": bsdf or {"type": "conductor", "material": "none"}},
            "sky": {
                "type": "envmap",
                "bitmap": mi.Bitmap(np.ascontiguousarray(environment, np.float32)),
            },
        }
    )
    return np.array(mi.render(scene))[..., :3]
