"""What each program shows of a panorama that `convert` made for it: upright, readable, from ahead.

A panorama of ours is converted for the program, and the program's own camera, which nobody has
turned, looks at it. Its picture is the one that a camera of ours takes of ours.
"""

from __future__ import annotations

import subprocess
from typing import Any

import numpy as np
import pytest
import spheremap as sm

from oracles import (
    ffmpeg_oracle,
    mitsuba_oracle,
    need,
    py360convert_oracle,
    skylibs_oracle,
)

FOV, SIZE, HEIGHT = 70, 33, 256


def panorama() -> np.ndarray:
    """Return a sky that is bright above the horizon, with an R written on it, straight ahead."""
    x, y, z = np.moveaxis(sm.directions("latlong", HEIGHT), -1, 0)
    letter = np.exp(-30 * (x + 0.15) ** 2 - 8 * y**2)
    letter += np.exp(-40 * (x - 0.1) ** 2 - 40 * (y - 0.12) ** 2)
    letter += np.exp(-30 * (x - 0.15) ** 2 - 30 * (y + 0.2) ** 2) / 2
    return 0.2 + 0.2 * np.tanh(2 * y) + 0.2 * letter * (1 - np.tanh(4 * z))


def by_mitsuba(image: np.ndarray) -> np.ndarray:
    mi = mitsuba_oracle.mitsuba()
    print(f"ran against {mitsuba_oracle.version()}")
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "sensor": {
                "type": "perspective",
                "fov": FOV,
                "film": film | {"pixel_format": "rgb", "component_format": "float32"},
                "sampler": {"type": "stratified", "sample_count": 16, "seed": 3},
            },
            "sky": {
                "type": "envmap",
                "bitmap": mi.Bitmap(np.repeat(image[..., None], 3, -1).astype(np.float32)),
            },
        }
    )
    return np.array(mi.render(scene))[..., 0]


def by_py360convert(image: np.ndarray) -> np.ndarray:
    py360convert: Any = need("py360convert")
    print(f"ran against {py360convert_oracle.version()}")
    picture = py360convert.e2p(image[..., None], FOV, 0, 0, (SIZE, SIZE), mode="bilinear")
    return np.asarray(picture)[..., 0]


def by_ffmpeg(image: np.ndarray) -> np.ndarray:
    print(f"ran against {ffmpeg_oracle.version()}")
    effect = f"v360=e:flat:interp=linear:w={SIZE}:h={SIZE}:h_fov={FOV}:v_fov={FOV}"
    raw = ["-f", "rawvideo", "-pix_fmt", "gray16le"]
    command = [ffmpeg_oracle.program(), "-loglevel", "error", *raw, "-s", f"{2 * HEIGHT}x{HEIGHT}"]
    command += ["-i", "-", "-vf", effect, *raw, "-"]
    data = np.rint(image * 65535).astype("<u2").tobytes()
    run = subprocess.run(command, input=data, capture_output=True, check=True)
    return np.frombuffer(run.stdout, "<u2").reshape(SIZE, SIZE) / 65535


def by_skylibs(image: np.ndarray) -> np.ndarray:
    envmap: Any = need("envmap")
    print(f"ran against {skylibs_oracle.version()}")
    sky = envmap.EnvironmentMap(image[..., None], "latlong")
    picture = sky.project(FOV, np.eye(3), ar=1.0, resolution=(SIZE, SIZE))
    return np.asarray(picture)[..., 0]


@pytest.mark.parametrize(
    ("program", "shown_by", "grid", "tolerance"),
    [
        # Means of pixels of 2.1°, of what has a second derivative of 40: h²/12 times that, more or
        # less, for the samples are jittered.
        ("mitsuba", by_mitsuba, "centers", 0.01),
        # One lookup between texels of 0.7°, rounded: to corners and back, of 16 bits, in float32.
        ("py360convert", by_py360convert, "corners", 2e-3),
        ("ffmpeg", by_ffmpeg, "centers", 2e-3),
        ("skylibs", by_skylibs, "corners", 2e-3),
    ],
)
def test_its_camera_sees_what_ours_sees(program, shown_by, grid, tolerance):
    image = panorama()
    name, camera = f"latlong:{program}", sm.projection("perspective", fov=FOV, grid=grid)
    want = sm.convert(image, "latlong", camera, size=SIZE, antialias=False)

    def off(picture: np.ndarray) -> float:
        return float(np.abs(picture - want).max())

    seen = shown_by(sm.convert(image, "latlong", name, size=HEIGHT))
    assert off(seen) < tolerance
    # It would notice: mirrored, and upside down.
    assert off(seen[:, ::-1]) > 0.1 and off(seen[::-1]) > 0.1
    literal = shown_by(sm.convert(image, "latlong", name, size=HEIGHT, world="literal"))
    same = sm.projection(name).world == sm.projection("latlong").world
    assert (off(literal) < tolerance) is same
