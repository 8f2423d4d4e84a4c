"""Draw docs/images/view-overlays.png: the page itself, in Chromium (see `make test-browser`).

python tools/make_view_images.py
"""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

import numpy as np
import spheremap as sm
from playwright.sync_api import sync_playwright
from spheremap import io
from spheremap.cli.sky import radiance
from spheremap.viewer import Viewer

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SIZE = {"width": 360, "height": 420}


def viewers() -> list[Viewer]:
    sky = radiance(sm.directions("latlong", 256)).astype(np.float32)
    first = sm.view(sky, "latlong", fov=100, direction=[0.45, 0.42, -0.8])
    first.lights(sm.light.lights(sky, "latlong", count=24)).lights(sm.light.sun(sky, "latlong"))
    first.box((300, 90, 360, 118), "box").mark([0, 0, -1], "ahead")
    first.outline([[1, 0, 0], [0, 1, 0], [0, 0, -1]], "an octant")
    cube = sm.convert(sky, "latlong", "cube", size=128)
    return [
        first,
        sm.view(sky, "latlong", screen="mollweide", tissot=True),
        sm.view(cube, "cube", fov=130, seams=True, density=True),
    ]


def main() -> None:
    shots = []
    path = os.environ.get("SPHEREMAP_CHROMIUM") or shutil.which("chromium")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=path, args=ARGUMENTS)
        for k, viewer in enumerate(viewers()):
            place = Path(folder) / f"{k}.html"
            viewer.save(place)
            page = browser.new_page(viewport=SIZE)
            page.goto(place.as_uri())
            page.wait_for_function("window.spheremap")
            page.evaluate("spheremap.ready.then(() => { spheremap.draw(3); return true; })")
            page.evaluate("document.activeElement.blur()")
            shot = place.with_suffix(".png")
            page.locator(".stage").screenshot(path=shot)
            shots.append(io.read(shot)[..., :3])
        browser.close()
    height = min(len(shot) for shot in shots)
    gap = np.full((height, 8, 3), 255, np.uint8)
    parts = [part for shot in shots for part in (shot[:height], gap)]
    io.write(IMAGES / "view-overlays.png", np.concatenate(parts[:-1], axis=1))


if __name__ == "__main__":
    main()
