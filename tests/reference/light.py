"""Light from the formulas of the papers, in float64 NumPy: harmonics, lobes, the DFG table."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import lpmv


def ylm(order: int, d: np.ndarray) -> np.ndarray:
    """Orthonormal real harmonics without the Condon-Shortley phase, by Legendre and angles."""
    x, y, z = np.moveaxis(d, -1, 0)
    phi = np.arctan2(y, x)
    out = np.empty((*d.shape[:-1], (order + 1) ** 2))
    for l_ in range(order + 1):
        for m in range(l_ + 1):
            k = (2 * l_ + 1) / (4 * math.pi) * math.factorial(l_ - m) / math.factorial(l_ + m)
            # scipy's Legendre functions have the phase.
            p = (-1) ** m * math.sqrt(k * (2 if m else 1)) * lpmv(m, l_, z)
            out[..., l_ * l_ + l_ + m] = p * np.cos(m * phi)
            if m:
                out[..., l_ * l_ + l_ - m] = p * np.sin(m * phi)
    return out


def lobe(name: str, parameter: float, t: np.ndarray) -> np.ndarray:
    """Return a lobe as a function of the cosine, not normalized."""
    up = np.maximum(t, 0)
    match name:
        case "cosine":
            return up
        case "cone":
            return (t >= math.cos(math.radians(parameter))).astype(float)
        case "phong":
            return np.where(t > 0, up**parameter, 0)
        case "vmf":
            return np.exp(parameter * (t - 1))
        case "ggx":
            a2 = parameter**2
            return a2 / (math.pi * ((1 + t) / 2 * (a2 - 1) + 1) ** 2) * up
        case "charlie":
            sin = np.sqrt(np.maximum((1 - t) / 2, 0))
            return (2 + 1 / parameter) / (2 * math.pi) * sin ** (1 / parameter) * up
    raise ValueError(name)


def under_lobe(
    values: np.ndarray, weights: np.ndarray, d: np.ndarray, n: np.ndarray, name: str, p: float
) -> np.ndarray:
    """Return the mean of values under a lobe about each direction."""
    k = lobe(name, p, n @ d.T) * weights
    return k @ values / k.sum(-1, keepdims=True)


def dfg_ggx(roughness: float, nv: float, along: int, around: int) -> tuple[float, float]:
    """Return E and B, averaged over visible normals (spherical caps, Dupuy & Benyoub 2023)."""
    a = roughness**2
    sin = math.sqrt(1 - nv * nv)
    v = np.array([a * sin, 0, nv]) / math.hypot(a * sin, nv)
    z = (1 - (np.arange(along)[:, None] + 0.5) / along) * (1 + v[2]) - v[2]
    phi = math.pi * (np.arange(around) + 0.5) / around
    r = np.sqrt(np.maximum(1 - z * z, 0))
    c = np.stack(np.broadcast_arrays(r * np.cos(phi) + v[0], r * np.sin(phi), z + v[2]))
    h = c * np.array([a, a, 1.0])[:, None, None]
    h /= np.sqrt((h**2).sum(0))
    vh = np.clip(sin * h[0] + nv * h[2], 0, 1)
    nl = 2 * vh * h[2] - nv

    def smith(c: np.ndarray | float) -> np.ndarray:
        return (np.sqrt(1 + a * a * (1 / np.square(c) - 1)) - 1) / 2

    above = nl > 0
    nl = np.where(above, np.clip(nl, 1e-300, 1), 1)
    g = np.where(above, (1 + smith(nv)) / (1 + smith(nv) + smith(nl)), 0)
    return float(g.mean()), float((g * (1 - vh) ** 5).mean())


def dfg_charlie(roughness: float, nv: float, along: int, around: int) -> tuple[float, float]:
    """Return E and B, summed over half vectors evenly spaced in cos θ and azimuth."""
    a = roughness**2
    reach = min(1.0, math.sqrt(80 * a))
    hz = (np.arange(along)[:, None] + 0.5) / along * reach
    phi = math.pi * (np.arange(around) + 0.5) / around
    sh = np.sqrt(1 - hz * hz)
    vh = math.sqrt(1 - nv * nv) * sh * np.cos(phi) + nv * hz
    nl = 2 * vh * hz - nv
    above = (nl > 0) & (vh > 0)
    nl = np.where(above, nl, 1)
    f = (2 + 1 / a) / (2 * math.pi) * sh ** (1 / a) / (4 * (nl + nv - nl * nv)) * nl * 4 * vh
    f = np.where(above, f, 0) * (reach / along) * (2 * math.pi / around)
    return float(f.sum()), float((f * (1 - np.clip(vh, 0, 1)) ** 5).sum())
