"""Conversions as sparse matrices give what converting gives."""

from __future__ import annotations

import pickle
import sys

import numpy as np
import pytest
import spheremap as sm
from conftest import some_fast

CASES = [
    ("latlong", "healpix", (24, 48), 8, "area"),
    ("latlong", "healpix", (24, 48), 3, "area"),
    ("healpix", "latlong", (12, 8, 8), 12, "area"),
    ("latlong:healpy", "healpix:healpy", (25, 48), 8, "bilinear"),
    ("healpix:healpy", "latlong", (12, 8, 8), 32, "bilinear"),
    ("latlong", "cube", (32, 64), 8, "catmull-rom"),
    ("cube", "latlong", (6, 8, 8), 16, "lanczos3"),
    ("latlong", "octahedral", (8, 16), 16, "nearest"),
    ("sphere", "latlong", (32, 32), 16, "area"),
    ("angular", "latlong", (32, 32), 16, "bilinear"),
    ("latlong", "octahedral", (32, 64), 8, "ewa"),
]


@some_fast(
    ("src", "dst", "source", "size", "filter"), CASES, fast=[c for c in CASES if "healpix" not in c]
)
def test_a_matrix_is_its_conversion(src, dst, source, size, filter):
    matrix = sm.weights_matrix(src, dst, size=size, source_shape=source, filter=filter)
    field = np.random.default_rng(0).normal(size=source)
    want = sm.convert(field, src, dst, size=size, filter=filter)
    assert matrix.shape == (want.size, field.size)
    # Weights are what converting gives: rounding of sums of some hundred numbers near 1, and
    # weights below 1e-14, which are left out.
    np.testing.assert_allclose(matrix @ field.ravel(), want.ravel(), rtol=0, atol=1e-11)
    sums = np.asarray(matrix.sum(axis=1)).ravel()
    seen = sm.convert(np.ones(source), src, dst, size=size, filter=filter).ravel()
    # As above.
    np.testing.assert_allclose(sums, seen, rtol=0, atol=1e-11)
    assert matrix.nnz < 0.6 * np.prod(matrix.shape)


def test_light_is_kept_by_areas():
    matrix = sm.weights_matrix("latlong", "healpix", size=4, source_shape=(16, 32), filter="area")
    areas = sm.solid_angle("healpix", 4).ravel() @ matrix
    # Shares of texels are right to 5e-7 of a texel.
    np.testing.assert_allclose(areas, sm.solid_angle("latlong", (16, 32)).ravel(), rtol=5e-6)
    assert matrix.data.min() > 0


def test_a_turn_and_options_go_along():
    turn = sm.rotation(30, 20, 10)
    given = {"rotation": turn, "filter": "bilinear", "antialias": False, "world": "literal"}
    matrix = sm.weights_matrix(
        "latlong:blender", "latlong:unity", size=8, source_shape=(16, 32), **given
    )
    field = np.random.default_rng(1).random((16, 32))
    want = sm.convert(field, "latlong:blender", "latlong:unity", size=8, **given)
    # Four weights near 1.
    np.testing.assert_allclose(matrix @ field.ravel(), want.ravel(), rtol=0, atol=1e-13)
    assert pickle.loads(pickle.dumps(matrix)).nnz == matrix.nnz <= 4 * want.size


def test_what_is_no_matrix():
    def make(**options):
        return sm.weights_matrix("latlong", "cube", size=4, source_shape=(8, 16), **options)

    with pytest.raises(ValueError, match="`skipna` is no option of a matrix"):
        make(skipna=True)
    with pytest.raises(ValueError, match="`fill` is no option of a matrix"):
        make(fill=1.0)
    for option in ("window", "channels_first"):
        with pytest.raises(ValueError, match=f"`{option}` is no option of a matrix"):
            make(**{option: True})
    with pytest.raises(ValueError, match="'mode'` is no matrix"):
        make(filter="mode")
    with pytest.raises(TypeError, match=r"sharpness|unexpected"):
        make(sharpness=3)


def test_without_scipy_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.sparse", None)
    with pytest.raises(ImportError, match="pip install scipy"):
        sm.weights_matrix("latlong", "cube", size=4, source_shape=(8, 16))
