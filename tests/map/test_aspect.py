"""No silent wrong picture: an image of another aspect than its projection's is an error."""

from __future__ import annotations

import re

import numpy as np
import pytest
import spheremap as sm
from conftest import CASES, GRIDS, each
from spheremap.map.images import fits

ODD = np.ones((8, 12, 3), np.float32)
SKY = np.ones((8, 16, 3), np.float32)
WIDE = (9, 13)

# Every verb of an image or of a whole shape, with one of another aspect.
VERBS = {
    "solid_angle": lambda **o: sm.solid_angle("perspective", WIDE, **o),
    "directions": lambda **o: sm.directions("perspective", WIDE, **o),
    "pixels_to_directions": lambda **o: sm.pixels_to_directions([1, 1], "latlong", WIDE, **o),
    "directions_to_pixels": lambda **o: sm.directions_to_pixels([1, 1, 1], "latlong", WIDE, **o),
    "sample": lambda **o: sm.sample(ODD, [0, 0, 1], "latlong", **o),
    "sample levels": lambda **o: sm.sample([ODD, ODD[::2, ::2]], [0, 0, 1], "latlong", lod=0, **o),
    "convert": lambda **o: sm.convert(ODD, "latlong", "cube", size=2, **o),
    "convert to a size": lambda **o: sm.convert(SKY, "latlong", "perspective", size=WIDE, **o),
    "convert a batch": lambda **o: sm.convert(ODD[None], "latlong", "cube", size=2, **o),
    "mipmaps": lambda **o: sm.mipmaps(ODD, "latlong", **o),
    "pad": lambda **o: sm.pad(ODD, "latlong", 1, **o),
    "embed": lambda **o: sm.embed(ODD, "perspective", SKY, "latlong", **o),
    "embed into": lambda **o: sm.embed(ODD[:, :8], "perspective", ODD, "latlong", **o),
    "convert_depth": lambda **o: sm.convert_depth(ODD[..., 0], "perspective", **o),
    "remap_plan": lambda **o: sm.remap_plan("latlong", "perspective", size=WIDE, **o),
    "remap_plan from": lambda **o: sm.remap_plan("latlong", "cube", source_shape=WIDE, **o),
    "plan": lambda **o: sm.remap_plan("latlong", "cube", size=2, **o)(ODD),
    "plan.maps": lambda **o: sm.remap_plan("latlong", "cube", size=2, **o).maps(WIDE),
    "ball.render": lambda **o: sm.ball.render(ODD, "latlong", size=8, **o),
    "ball.unwrap": lambda **o: sm.ball.unwrap(
        np.ones((16, 16, 3)), center=(8, 8), radius=7, fov=30, size=(8, 12), **o
    ),
    "light.weights": lambda **o: sm.light.weights("latlong", WIDE, **o),
    "light.integrate": lambda **o: sm.light.integrate(ODD, "latlong", **o),
    "light.mean": lambda **o: sm.light.mean(ODD, "latlong", **o),
    "light.average_direction": lambda **o: sm.light.average_direction(ODD, "latlong", **o),
    "light.ws_psnr": lambda **o: sm.light.ws_psnr(ODD, ODD, "latlong", **o),
    "light.irradiance": lambda **o: sm.light.irradiance(ODD, "latlong", "cube", size=2, **o),
    "light.irradiance to": lambda **o: sm.light.irradiance(
        SKY, "latlong", "latlong", size=WIDE, **o
    ),
    "light.irradiance sh": lambda **o: sm.light.irradiance(
        ODD, "latlong", "cube", size=2, method="sh", order=1, **o
    ),
    "light.irradiance_at": lambda **o: sm.light.irradiance_at(ODD, [0, 1, 0], "latlong", **o),
    "light.convolve": lambda **o: sm.light.convolve(
        ODD, "latlong", "cube", lobe="phong", exponent=9, size=2, **o
    ),
    "light.prefilter": lambda **o: sm.light.prefilter(
        ODD, "latlong", "cube", roughness=0.5, size=2, samples=16, **o
    ),
    "light.prefilter_chain": lambda **o: sm.light.prefilter_chain(
        ODD, "latlong", "cube", size=2, samples=16, **o
    ),
    "light.lights": lambda **o: sm.light.lights(ODD, "latlong", count=2, **o),
    "light.sun": lambda **o: sm.light.sun(ODD, "latlong", **o),
    "light.remove_sun": lambda **o: sm.light.remove_sun(ODD, "latlong", **o),
    "light.energy": lambda **o: sm.light.energy(ODD, "latlong", **o),
    "light.Distribution": lambda **o: sm.light.Distribution(ODD, "latlong", **o),
    "light.bake": lambda **o: sm.light.bake(
        ODD, "latlong", size=2, diffuse_size=2, order=1, samples=4, **o
    ),
    "light.bake_matcap": lambda **o: sm.light.bake_matcap(ODD, "latlong", size=4, **o),
    "light.shade_environment": lambda **o: sm.light.shade_environment(
        [0, 0, 0], [0, 0, 1], [0, 0, 9], ODD, "latlong", **o
    ),
    "sh.project": lambda **o: sm.sh.project(ODD, "latlong", order=1, **o),
}


@pytest.mark.parametrize("name", VERBS)
def test_every_verb_refuses_another_aspect_and_takes_it_on_request(name):
    with pytest.raises(
        ValueError, match=r"as wide as high, .* `any_aspect=True` takes it as it is"
    ):
        VERBS[name]()
    VERBS[name](any_aspect=True)
    with pytest.raises(TypeError, match="Expected `any_aspect` to be a bool, got str"):
        VERBS[name](any_aspect="yes")


@each([case for case in CASES if case.make().faces == 1])
def test_shapes_of_a_map_fit_it_on_every_grid(case):
    for grid in GRIDS:
        p = case.make(grid=grid)
        for size in (2, 3, 5, 8, 21, 64, 333, 4096):
            height, width = p.shape(size)
            for rows, columns in ((0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)):
                if min(height + rows, width + columns) > 0:
                    assert fits(p, (height + rows, width + columns)), (height, width)
            # Some texels more are another aspect, where there are enough to tell.
            if min(height, width) > 63:
                ratio = width / height
                assert not fits(p, (height, width + 3 + int(2 * ratio)))
                assert not fits(p, (height + 3 + int(2 / ratio), width))


def test_rows_on_the_poles_cropped_rounding_and_single_texels_fit():
    p = sm.projection("latlong")
    # ERA5 at a quarter of a degree, a panorama of odd width, a texel, and two.
    for shape in ((721, 1440), (361, 720), (2000, 3999), (2001, 4000), (1, 1), (1, 2), (2, 3)):
        assert fits(p, shape), shape
    for shape in ((9, 3), (3, 512), (480, 640), (64, 64), (512, 1030), (1, 6)):
        assert not fits(p, shape), shape


def message(call) -> str:
    with pytest.raises(ValueError) as caught:
        call()
    return str(caught.value)


def test_messages_name_what_fits():
    panorama = np.zeros((64, 128, 3), np.uint8)
    first = message(lambda: sm.convert(panorama.transpose(2, 0, 1), "latlong", "cube", size=16))
    assert "to be twice as wide as high, each side within a texel, got (3, 64, 128)" in first
    assert "looks like channels first: pass `channels_first=True`" in first
    assert "np.moveaxis(image, 0, -1)" in first
    batch = message(lambda: sm.convert(np.zeros((9, 64, 128)), "latlong", "cube"))
    assert "A batch of gray images has shape (9, 64, 128, 1)" in batch
    square = message(lambda: sm.convert(panorama, "latlong", "perspective(fov=90)", size=(48, 64)))
    assert "Expected `size` of projection 'perspective' to be as wide as high" in square
    assert "'perspective' with aspect=64/48" in square
    lone = message(lambda: sm.light.mean(np.zeros((9, 3)), "latlong"))
    assert re.search(r"got \(9, 3\)\. `any_aspect=True`", lone)
    faces = message(lambda: sm.pad(np.zeros((6, 3, 8, 8)), "cube", 1))
    assert "(6, 3, 8, 8) looks like channels first" in faces
    cross = message(lambda: sm.pad(np.zeros((3, 24, 32)), sm.projection("cube", layout="cross"), 1))
    assert "(3, 24, 32) looks like channels first" in cross
    tall = message(lambda: sm.sample(np.zeros((10, 10)), [0, 0, 1], "perspective(aspect=1.5)"))
    assert "1.5 times as wide as high" in tall


def test_what_a_message_names_is_right():
    panorama = np.random.default_rng(0).random((8, 16, 3)).astype(np.float32)
    moved = panorama.transpose(2, 0, 1)
    want = sm.convert(panorama, "latlong", "cube", size=4)
    got = sm.convert(moved, "latlong", "cube", size=4, channels_first=True)
    assert np.array_equal(np.moveaxis(got, -3, -1), want)
    camera = sm.projection("perspective", fov=90, aspect=64 / 48)
    assert sm.convert(panorama, "latlong", camera, size=(48, 64)).shape == (48, 64, 3)
