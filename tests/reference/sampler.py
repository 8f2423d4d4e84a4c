"""A texture sampler, literally as graphics APIs describe it.

From the Direct3D 11.3 functional specification, 7.18 (Texture Sampling: address modes, mipmap
selection), and The OpenGL Graphics System 4.6, 8.13 (cube maps) and 8.14 (minification), with
their letters: u, v in texels, ρ the scale factor, λ the level of detail. One lookup at a time, in
float64; hardware computes the same in fewer bits.
"""

from __future__ import annotations

import math

import numpy as np

Array = np.ndarray


def level_of_detail(right: Array, down: Array) -> float:
    """λ = log2 ρ, for derivatives in texels (8.14, equations 8.7 and 8.8)."""
    rho = max(math.hypot(*right), math.hypot(*down))
    return math.log2(rho) if rho > 0 else -math.inf


def selected(lod: float, levels: int) -> tuple[int, int, float]:
    """Clamp a level of detail, and return both levels and the part of the further one."""
    lod = min(max(lod, 0.0), levels - 1.0)
    near = math.floor(lod)
    return near, min(near + 1, levels - 1), lod - near


def trilinear(looks: list[Array], lod: float) -> Array:
    """Mix what two levels show linearly in λ."""
    near, far, part = selected(lod, len(looks))
    return (1 - part) * looks[near] + part * looks[far]


def address(i: int, n: int, mode: str) -> int | None:
    """The texel that stands for number i of n (7.18.6), None for the border."""
    if mode == "wrap":
        return i % n
    if mode == "mirror":
        return i % n if (i // n) % 2 == 0 else n - 1 - i % n
    if mode == "clamp":
        return min(max(i, 0), n - 1)
    return i if 0 <= i < n else None


def texel(image: Array, i: int, j: int, modes: tuple[str, str], border: Array) -> Array:
    x, y = address(i, image.shape[1], modes[0]), address(j, image.shape[0], modes[1])
    return border if x is None or y is None else image[y, x]


def nearest(image: Array, uv: Array, modes: tuple[str, str], border: Array) -> Array:
    height, width = image.shape[:2]
    i, j = math.floor(uv[0] * width), math.floor(uv[1] * height)
    return texel(image, i, j, modes, border)


def bilinear(image: Array, uv: Array, modes: tuple[str, str], border: Array) -> Array:
    """The four texels around a place (8.14.2.1), centers at ½."""
    height, width = image.shape[:2]
    u, v = uv[0] * width - 0.5, uv[1] * height - 0.5
    i, j = math.floor(u), math.floor(v)
    alpha, beta = u - i, v - j

    def at(x: int, y: int) -> Array:
        return texel(image, x, y, modes, border)

    top = (1 - alpha) * at(i, j) + alpha * at(i + 1, j)
    bottom = (1 - alpha) * at(i, j + 1) + alpha * at(i + 1, j + 1)
    return (1 - beta) * top + beta * bottom


def sample_2d(
    levels: list[Array],
    uv: Array,
    modes: tuple[str, str] = ("clamp", "clamp"),
    border: float = 0.0,
    lod: float | None = None,
    derivatives: tuple[Array, Array] | None = None,
) -> Array:
    """Look a 2-D texture up, at a level or by the derivatives of (u, v)."""
    edge = np.full(levels[0].shape[2:], border)
    if derivatives is not None:
        size = np.array(levels[0].shape[1::-1], np.float64)
        lod = level_of_detail(derivatives[0] * size, derivatives[1] * size)
    looks = [bilinear(level, uv, modes, edge) for level in levels]
    return trilinear(looks, 0.0 if lod is None else lod)


# Table 8.19 of OpenGL 4.6: for the major axis +x, -x, +y, -y, +z, -z, the component and sign of
# sc, tc and ma.
CUBE = (
    ((2, -1), (1, -1), (0, 1)),
    ((2, 1), (1, -1), (0, -1)),
    ((0, 1), (2, 1), (1, 1)),
    ((0, 1), (2, -1), (1, -1)),
    ((0, 1), (1, -1), (2, 1)),
    ((0, -1), (1, -1), (2, -1)),
)


def cube_face(r: Array) -> int:
    axis = int(np.argmax(np.abs(r)))
    return 2 * axis + (r[axis] < 0)


def cube_st(r: Array, face: int) -> Array:
    """s and t of a face: ½ (sc/|ma| + 1), ½ (tc/|ma| + 1)."""
    sc, tc, ma = (sign * r[k] for k, sign in CUBE[face])
    return np.array([0.5 * (sc / ma + 1), 0.5 * (tc / ma + 1)])


def cube_derivative(r: Array, dr: Array, face: int) -> Array:
    """ds and dt, by the quotient rule on the face that holds r."""
    sc, tc, ma = (sign * r[k] for k, sign in CUBE[face])
    dsc, dtc, dma = (sign * dr[k] for k, sign in CUBE[face])
    return 0.5 * np.array([(dsc * ma - sc * dma) / ma**2, (dtc * ma - tc * dma) / ma**2])


def sample_cube(
    levels: list[Array],
    r: Array,
    lod: float | None = None,
    derivatives: tuple[Array, Array] | None = None,
) -> Array | None:
    """Look a cube map up (faces in OpenGL's order); None where a level needs another face's texels.

    What seamless cube maps do there is left to implementations at the corners.
    """
    face = cube_face(r)
    st = cube_st(r, face)
    if derivatives is not None:
        n = levels[0].shape[1]
        a, b = (cube_derivative(r, d, face) * n for d in derivatives)
        lod = level_of_detail(a, b)
    near, far, _ = selected(lod or 0.0, len(levels))
    looks: list[Array] = [levels[0][0, 0, 0]] * len(levels)
    for k in {near, far}:
        n = levels[k].shape[1]
        if np.any(st * n < 0.5) or np.any(st * n > n - 0.5):
            return None
        looks[k] = bilinear(levels[k][face], st, ("clamp", "clamp"), levels[k][0, 0, 0])
    return trilinear(looks, lod or 0.0)
