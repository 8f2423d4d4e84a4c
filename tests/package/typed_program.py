"""A program as users write it, for the test that type checkers pass it; nothing runs it."""

from typing import Any, assert_type

import numpy as np
import spheremap as sm
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float32]


def views(
    panorama: Bytes, light: Floats, filter: str, name: str, labels: NDArray[np.int64]
) -> None:
    # Names, parameters and filters that arrive in variables.
    settings = {"fov": 90.0}
    camera = sm.projection("perspective", **settings)
    other = sm.Projection(name, **settings).turned(np.eye(3))
    turned = sm.projection("latlong", convention="mitsuba", axes="+x -y -z")
    seen = sm.projection("angular", convention="openimageio", fov=180.0)
    assert_type(camera, sm.Projection)

    # Images keep their dtype.
    assert_type(sm.convert(panorama, "latlong", camera, size=64, filter=filter), Bytes)
    assert_type(sm.convert(light, turned, "cube", size=(6, 8, 8), rotation=np.eye(3)), Floats)
    assert_type(sm.convert(labels, name, seen, filter="nearest"), NDArray[np.int64])
    assert_type(sm.convert([[1.0, 2.0]], name, other), NDArray[Any])
    assert_type(sm.sample(panorama, [0, 0, 1], "latlong", filter=filter), Bytes)
    assert_type(sm.pad(light, "latlong", 2, filter=filter), Floats)
    assert_type(sm.embed(panorama, camera, panorama, "latlong", filter=filter), Bytes)
    assert_type(sm.mipmaps(light, "latlong"), list[Floats])
    assert_type(sm.sample_uv(light, [0.5, 0.5], filter=filter), Floats)
    assert_type(camera.convert(panorama, "latlong", filter=filter), Bytes)
    assert_type(camera.sample(light, [0, 0, 1], filter=filter), Floats)
    assert_type(camera.mipmaps(light), list[Floats])
    plan = sm.remap_plan("latlong", camera, size=64, filter=filter)
    assert_type(plan(panorama), Bytes)

    # Sums of light are floats.
    total: NDArray[np.float64] = sm.light.integrate(light, "latlong", negative="clip")
    batch = np.stack([light, light])
    turns = np.stack([np.eye(3), np.eye(3)])
    assert_type(
        sm.convert(batch, "latlong", "cube", rotation=turns, channels_first=True, any_aspect=True),
        Floats,
    )
    # Of one image, one, and of many, a list.
    lamps: sm.light.Lights = sm.light.lights(light, "latlong", count=4)
    many: Any = camera.lights(batch, count=4, rotation=turns)
    dull, sun = sm.light.remove_sun(light, "latlong")
    again = sm.light.add_sun(dull, sun, "latlong")
    print(lamps.irradiance, many[0].directions, again.shape)
    print(sm.light.energy(light, "latlong").peak, sm.light.ws_psnr(light, light, "latlong") + 1.0)
    print(total, sm.ball.render(light, "latlong", filter=filter).shape)
