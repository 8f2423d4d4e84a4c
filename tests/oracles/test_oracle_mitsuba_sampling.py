"""mitsuba's envmap emitter against Distribution: densities, and where its samples fall.

Its density is another one: bilinear in luminance times sine between texels on corners, ours
constant in each texel. On smooth content at a fine grid both are the density of the same light.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import reference
import spheremap as sm
from conftest import random_directions
from scipy import stats

from oracles import mitsuba_oracle as oracle

CONVENTION = "latlong:mitsuba"


@pytest.fixture(autouse=True)
def _say_the_version(record_property):
    record_property("oracle", oracle.version())
    print(f"ran against {oracle.version()}")


def smooth_light(n: int) -> np.ndarray:
    """Positive light that varies 20:1."""
    light = reference.smooth_function(sm.directions(CONVENTION, n))
    return (0.1 + 2 * (light - light.min()) / np.ptp(light)).astype(np.float32)


def emitter(image: np.ndarray) -> tuple[Any, Any, Any]:
    mi = oracle.mitsuba()
    found = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(image)})
    # Without a scene its sphere is a point.
    return mi, found, mi.SurfaceInteraction3f()


def their_pdf(image: np.ndarray, directions: np.ndarray) -> np.ndarray:
    mi, found, si = emitter(image)
    ds = mi.DirectionSample3f()
    out = np.empty(len(directions))
    for i, d in enumerate(directions.tolist()):
        ds.d = mi.Vector3f(*d)
        out[i] = found.pdf_direction(si, ds)
    return out


def their_samples(image: np.ndarray, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    mi, found, si = emitter(image)
    d, pdf, weight = np.empty((len(xi), 3)), np.empty(len(xi)), np.empty((len(xi), 3))
    for i, pair in enumerate(xi.tolist()):
        ds, spectrum = found.sample_direction(si, mi.Point2f(*pair))
        d[i], pdf[i], weight[i] = ds.d, ds.pdf, spectrum
    return d, pdf, weight


def off_the_poles(d: np.ndarray) -> np.ndarray:
    """At a pole mitsuba divides a density of its grid by a sine, and both go to 0."""
    return d[np.abs(d[:, 1]) < 0.98]


@pytest.mark.parametrize("n", [128, 512])
def test_densities_agree(n):
    image = smooth_light(n)
    d = off_the_poles(random_directions(2000, 300))
    ours = sm.light.Distribution(image, CONVENTION).pdf(d)
    # Half a texel of a light that changes by up to 4 a radian and is 0.1 at least; theirs is
    # bilinear in luminance · sine, known to (π/n)²/8.
    slope = np.abs(np.gradient(image.mean(-1), np.pi / n, axis=0)).max() / image.min()
    assert np.abs(ours / their_pdf(image, d) - 1).max() < slope * np.pi / n


def test_their_samples_fall_where_our_density_says():
    image = smooth_light(256)
    xi = np.random.default_rng(301).random((12_000, 2))
    theirs, pdf, _ = their_samples(image, xi)
    dist = sm.light.Distribution(image, CONVENTION)
    # Bins of equal area; their share from our density on a grid 64 times finer.
    bins, fine = 12, 12 * 16
    middle = sm.directions("sphere", fine)
    held = ~np.isnan(middle[..., 0])
    mass = np.where(held, dist.pdf(np.where(held[..., None], middle, 1)), 0)
    mass *= sm.solid_angle("sphere", fine)
    share = mass.reshape(bins, 16, bins, 16).sum((1, 3)).ravel()
    place = np.minimum((sm.encode(theirs, "sphere") * bins).astype(int), bins - 1)
    count = np.bincount(place[:, 1] * bins + place[:, 0], minlength=bins * bins)
    used = share * len(xi) > 10
    expected = share[used] * (count[used].sum() / share[used].sum())
    assert stats.chisquare(count[used], expected).pvalue > 1e-4
    mid = np.abs(theirs[:, 1]) < 0.98
    assert np.abs(dist.pdf(theirs[mid]) / pdf[mid] - 1).max() < 0.2


def test_estimates_agree():
    image = smooth_light(128)
    xi = np.random.default_rng(303).random((4000, 2))
    _, _, theirs = their_samples(image, xi)
    _, _, ours = sm.light.Distribution(image, CONVENTION).sample(xi, weights=True)
    want = np.tensordot(sm.solid_angle(CONVENTION, 128), image, 2)
    for weight in (theirs, ours):
        assert np.all(np.abs(weight.mean(0) - want) < 5 * weight.std(0) / np.sqrt(len(xi)) + 1e-3)
    # Constant in each texel is what ours is divided by, so luminance has no variance at all.
    luminance = [0.2126, 0.7152, 0.0722]
    assert (ours @ luminance).std() < 1e-5 * (theirs @ luminance).std() + 1e-5
