"""Places where a map is smooth, for derivatives that are compared with differences."""

from __future__ import annotations

import numpy as np
import spheremap as sm
from conftest import NAMES, random_directions

Array = np.ndarray

CASES = [*NAMES, "cube:unreal", "latlong:mitsuba", "angular(fov=180)"]
WHOLE = [
    name for name in NAMES if sm.projection(name).faces == 1 and sm.projection(name).used_part == 1
]


def smooth(case: str | sm.Projection, count: int) -> tuple[Array, Array, Array]:
    """Return directions that a map covers, their places and the numbers of their faces.

    Away from creases, rims and poles: what lies a thousandth of the image around is smooth.
    """
    p = sm.projection(case) if isinstance(case, str) else case
    d = random_directions(400, 3)
    uv = p.encode(d)
    near = [uv]
    for axis in range(2):
        for step in (-1e-3, 1e-3):
            moved = uv.copy()
            moved[:, axis] += step
            near.append(moved)
    found = np.stack([p.jacobian(at) for at in near])
    size = np.linalg.norm(found[0], axis=(1, 2))
    change = np.linalg.norm(found - found[0], axis=(2, 3)).max(axis=0)
    # NaN is not below: places beside a rim are left out.
    kept = np.flatnonzero((change < 0.05 * size) & (p.density(uv) > 0.05))[:count]
    assert len(kept) == count
    return d[kept], uv[kept, :2], uv[kept, 2:]


def inside(case: str, count: int) -> Array:
    """Return directions whose lookups are far from poles and cuts, where differences step over."""
    p = sm.projection(case)
    d = random_directions(200, 5)
    uv = p.encode(d)
    kept = d[(p.density(uv) > 1) & (np.abs(uv - 0.5) < 0.4).all(axis=-1)][:count]
    assert len(kept) == count
    return kept
