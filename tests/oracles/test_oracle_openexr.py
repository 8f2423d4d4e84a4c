"""The official pair of images of OpenEXR: one scene as its cube and as its latlong."""

from __future__ import annotations

import numpy as np
import pytest
import spheremap as sm

from oracles import openimageio_oracle


@pytest.fixture(scope="module")
def pair(data_folder):
    cube = openimageio_oracle.read(data_folder / "OrientationCube.exr")[..., :3]
    panorama = openimageio_oracle.read(data_folder / "OrientationLatLong.exr")[..., :3]
    return cube, panorama


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.corrcoef(np.clip(a, 0, 4).ravel(), np.clip(b, 0, 4).ravel())[0, 1])


def test_each_face(pair):
    cube, panorama = pair
    n = cube.shape[1]
    assert cube.shape[0] == 6 * n
    made = sm.convert(panorama, "latlong:openexr", "cube:openexr", size=n)
    for face in range(6):
        rows = slice(face * n, (face + 1) * n)
        assert correlation(made[rows], cube[rows]) > 0.96


def test_other_signs_do_not_fit(pair):
    cube, panorama = pair
    n = cube.shape[1]
    opengl = sm.projection("cube", convention="opengl", layout="column", grid="corners")
    made = sm.convert(panorama, "latlong:openexr", opengl, size=n)
    scores = [correlation(made[f * n : (f + 1) * n], cube[f * n : (f + 1) * n]) for f in range(6)]
    assert max(scores) < 0.7
