"""Maps with parameters, for derivatives by them: of torch and of JAX."""

from __future__ import annotations

from conftest import REGISTRY

# Inside their ranges and at their ends: the default of `angular` is the largest that there is.
CASES: list[tuple[str, dict[str, float]]] = [
    ("angular", {}),
    ("angular", {"fov": 200.0}),
    ("perspective", {"fov": 70.0, "aspect": 1.5, "cx": 0.1, "cy": -0.05}),
    ("cylindrical", {}),
    ("cylindrical", {"fov": 200.0, "aspect": 2.0}),
    ("equisolid", {"fov": 220.0}),
    ("stereographic", {"fov": 220.0}),
    ("orthographic", {"fov": 120.0}),
    ("dual_fisheye", {"fov": 200.0}),
    ("kannala_brandt", {"fov": 170.0, "k1": 0.02, "k2": -0.004, "k3": 0.001, "k4": -0.0002}),
    ("unified", {}),
    ("double_sphere", {"fov": 170.0}),
    ("pannini", {"fov": 140.0, "d": 0.8, "s": 0.2, "aspect": 1.8}),
    ("mercator", {"latitude": 80.0}),
    ("camera_pinhole", {"fx": 0.6, "fy": 0.8, "cx": 0.02, "cy": -0.03, "aspect": 1.3}),
    ("camera_brown_conrady", {}),
    (
        "camera_brown_conrady",
        {"fx": 0.7, "fy": 0.9, "k1": -0.2, "k2": 0.05, "p1": 1e-3, "p2": -2e-3, "k4": 0.01},
    ),
    ("camera_kannala_brandt", {"fx": 0.4, "fy": 0.4, "k1": 0.02, "k2": -0.004, "k3": 0.001}),
    ("camera_unified", {"xi": 0.8, "k1": -0.1, "p1": 1e-3}),
    ("camera_double_sphere", {"fx": 0.4, "fy": 0.5}),
    ("camera_fov", {"fx": 0.4, "fy": 0.5, "omega": 0.9}),
    ("camera_eucm", {"fx": 0.4, "fy": 0.5, "alpha": 0.6, "beta": 1.1}),
    (
        "camera_thin_prism_fisheye",
        {"fx": 0.4, "fy": 0.4, "k1": 0.02, "k2": -0.004, "p1": 1e-3, "p2": -2e-3, "s1": 5e-3},
    ),
    # Of wider ones the thirteenth power of the angle is too steep for the differences of JAX.
    (
        "camera_rad_tan_thin_prism_fisheye",
        {"fx": 0.8, "fy": 0.8, "k0": 0.02, "k1": -0.01, "p0": 2e-3, "p1": -1e-3, "s0": 3e-3},
    ),
]


def maximum(name: str, key: str) -> float:
    """Return the end of a parameter's range."""
    (entry,) = (entry for entry in REGISTRY if entry["name"] == name)
    return next(one["maximum"] for one in entry["parameters"] if one["name"] == key)
