"""Pyramids in the viewers that they are for: what is seen is what `convert` gives.

`make test-browser`: playwright drives Chromium; the viewers come from npm, and the addresses at
which a page looks for them are answered from there.
"""

from __future__ import annotations

import functools
import http.server
import shutil
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from browser import launched
from spheremap import io

pytestmark = pytest.mark.programs

# Of 8-bit pictures: the viewer looks up in tiles of 8 bits, and `convert` in light.
LEAST = 35.0
SIZE = {"width": 800, "height": 600}
PACKAGES = (
    "pannellum@2.5.7",
    "marzipano@0.10.2",
    "three@0.185.1",
    "@photo-sphere-viewer/core@5.15.1",
    "@photo-sphere-viewer/equirectangular-tiles-adapter@5.15.1",
    "openseadragon@6.1.1",
    "aladin-lite@3.8.2",
)
SERVER = "https://cdn.jsdelivr.net/npm/"
# What lies over the picture.
HIDDEN = """.pnlm-ui, .pnlm-panorama-info, .psv-navbar, .psv-loader-container, .aladin-box,
    .openseadragon-canvas ~ div, .aladin-stack-control, .aladin-fov, .aladin-location,
    .aladin-cooFrame, .aladin-projection-control, .aladin-logo-container, .aladin-status-bar,
    .aladin-widgets-toolbar, [class^=aladin-btn], .aladin-reticle { display: none !important }"""
# How each is told where to look: degrees to the right and up, and of the height of the picture.
LOOK = {
    "pannellum": """([yaw, pitch, fov]) => {
        const wide = Math.tan(fov * Math.PI / 360) * innerWidth / innerHeight;
        viewer.setHfovBounds([10, 150]);
        viewer.lookAt(pitch, yaw, Math.atan(wide) * 360 / Math.PI, false);
    }""",
    "marzipano": """([yaw, pitch, fov]) => {
        const rad = Math.PI / 180;
        const view = viewer.scene().view();
        view.setLimiter(null);
        view.setParameters({ yaw: yaw * rad, pitch: -pitch * rad, fov: fov * rad });
    }""",
    "photo-sphere-viewer": """([yaw, pitch, fov]) => {
        viewer.setOptions({ minFov: 10, maxFov: 150 });
        viewer.rotate({ yaw: `${yaw}deg`, pitch: `${pitch}deg` });
        viewer.zoom(viewer.dataHelper.fovToZoomLevel(fov));
    }""",
}
VIEWS = [(0.0, 0.0, 60.0), (130.0, 35.0, 40.0), (-60.0, -70.0, 80.0), (20.0, 5.0, 20.0)]


def peak_to_noise(a: np.ndarray, b: np.ndarray) -> float:
    error = np.mean((a.astype(np.float64) - b) ** 2)
    return float(10 * np.log10(255**2 / max(error, 1e-12)))


def scene(d: np.ndarray) -> np.ndarray:
    """Return light that is another in every direction, and finer than a face is wide."""
    x, y, z = (np.nan_to_num(d[..., k]) for k in range(3))
    waves = [1 + np.sin(15 * x + 4 * z), 1 + np.cos(17 * y - z), 1 + np.sin(14 * z + 6 * y)]
    return (np.stack(waves, axis=-1) * 0.4 + 0.1 + 0.1 * (x + y)[..., None]).astype(np.float32)


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the viewers."""
    if shutil.which("npm") is None:
        pytest.skip("the viewers come from npm")
    folder = tmp_path_factory.mktemp("viewers")
    command = ["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", *PACKAGES]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"npm has no viewers: {done.stderr[-200:]}")
    return folder / "node_modules"


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with launched() as browser:
        yield browser


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: Any) -> None:
        pass


@pytest.fixture
def opened(chromium: Any, packages: Path, tmp_path: Path) -> Iterator[Callable[[Path], Any]]:
    """Return what serves a folder and opens its page; a tile that is missing fails the test."""
    missed: list[str] = []
    context = chromium.new_context(viewport=SIZE)
    handler = functools.partial(Quiet, directory=str(tmp_path))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()

    def answer(route: Any) -> None:
        package, _, rest = route.request.url.removeprefix(SERVER).rpartition("@")
        place = packages / package / rest.partition("/")[2]
        if place.is_file():
            route.fulfill(path=place, headers={"Access-Control-Allow-Origin": "*"})
        else:
            route.fulfill(status=404)

    def open_page(folder: Path) -> Any:
        page = context.new_page()
        page.route(f"{SERVER}**", answer)
        page.on("pageerror", lambda error: missed.append(str(error)))
        page.on("response", lambda r: missed.append(f"{r.status} {r.url}") if r.status > 399 else 0)
        place = folder.relative_to(tmp_path).as_posix()
        page.goto(f"http://127.0.0.1:{server.server_port}/{place}/index.html")
        page.wait_for_function("window.viewer", timeout=60_000)
        page.add_style_tag(content=HIDDEN)
        return page

    yield open_page
    context.close()
    server.shutdown()
    server.server_close()
    # Aladin asks catalogs of the world for what lies there, and for a coverage that may be missing.
    known = ("favicon", "Moc.fits", "Failed to fetch")
    assert [said for said in missed if not any(word in said for word in known)] == []


def seen(page: Any, tmp_path: Path) -> np.ndarray:
    """Return the picture when it changes no more."""
    path, before = tmp_path / "seen.png", None
    for _ in range(40):
        page.wait_for_timeout(700)
        page.screenshot(path=path)
        now = io.read(path)[..., :3]
        if before is not None and np.array_equal(now, before):
            return now
        before = now
    raise AssertionError("the picture does not come to rest")


@pytest.mark.parametrize("format", list(LOOK))
def test_a_view_is_what_convert_gives(
    format: str, opened: Callable[[Path], Any], tmp_path: Path
) -> None:
    light = scene(sm.directions("latlong", 1000))
    # Three levels, and edge tiles where the format has them.
    folder = tmp_path / "out"
    made = sm.tiles.write(light, "latlong", folder, format=format, tile_size=250, extension="png")
    assert made.levels >= 3
    page = opened(folder)
    seen(page, tmp_path)
    for yaw, pitch, fov in VIEWS:
        page.evaluate(LOOK[format], [yaw, pitch, fov])
        got = seen(page, tmp_path)
        height, width = got.shape[:2]
        wide = 2 * np.degrees(np.arctan(np.tan(np.radians(fov) / 2) * width / height))
        camera = sm.projection("perspective", fov=wide, aspect=width / height)
        camera = camera.turned(sm.rotation(-yaw, pitch))
        wanted = io.tonemap(
            sm.convert(light, "latlong", camera, size=(height, width)), curve="none"
        )
        ratio = peak_to_noise(got, wanted)
        print(f"{format}: {yaw}, {pitch}, {fov}: {ratio:.1f} dB")
        assert ratio >= LEAST


@pytest.mark.parametrize("middle", [0.5, 0.0, 0.3])
def test_deep_zoom_shows_the_panorama(
    middle: float, opened: Callable[[Path], Any], tmp_path: Path
) -> None:
    light = scene(sm.directions("latlong", 1000))
    folder = tmp_path / "out"
    sm.tiles.write(light, "latlong", folder, format="deepzoom", tile_size=254, extension="png")
    page = opened(folder)
    page.wait_for_function("viewer.world.getItemCount() > 0")
    page.evaluate(
        """(x) => {
            viewer.viewport.zoomTo(viewer.viewport.imageToViewportZoom(1), null, true);
            viewer.viewport.panTo(new OpenSeadragon.Point(x, 0.25), true);
        }""",
        middle,
    )
    got = seen(page, tmp_path)
    height, width = got.shape[:2]
    turned = np.roll(light, width // 2 - round(2000 * middle), axis=1)
    wanted = io.tonemap(turned[500 - height // 2 :, :width][:height], curve="none")
    ratio = peak_to_noise(got, wanted)
    print(f"{middle}: {ratio:.1f} dB")
    assert ratio >= LEAST


@pytest.mark.parametrize("extension", ["png", "fits"])
def test_aladin_shows_the_sky(
    extension: str, opened: Callable[[Path], Any], tmp_path: Path
) -> None:
    light = scene(sm.directions("latlong", 1000))
    given = light[..., :1] if extension == "fits" else light
    folder = tmp_path / "out"
    made = sm.tiles.write(
        given, "latlong", folder, format="hips", tile_size=64, extension=extension
    )
    assert made.levels >= 4
    lines = (line.split("=") for line in made.manifest.read_text().splitlines())
    said = {name.strip(): value.strip() for name, value in lines}
    page = opened(folder)
    for yaw, pitch, wide in [(0, 0, 60), (200, -75, 40), (40, 30, 20)]:
        page.evaluate(
            """([ra, dec, fov]) => {
                viewer.setProjection("TAN");
                viewer.setFov(fov);
                viewer.gotoRaDec(ra, dec);
            }""",
            # Right ascension grows to the left.
            [-yaw % 360, pitch, wide],
        )
        page.wait_for_timeout(2000)
        got = seen(page, tmp_path)
        height, width = got.shape[:2]
        camera = sm.projection("perspective", fov=wide, aspect=width / height)
        camera = camera.turned(sm.rotation(-yaw, pitch))
        wanted = sm.convert(given, "latlong", camera, size=(height, width))
        if extension == "fits":
            low, high = map(float, said["hips_pixel_cut"].split())
            picture = np.clip((wanted - low) / (high - low), 0, 1) * 255
        else:
            picture = io.tonemap(wanted, curve="none")
        ratio = peak_to_noise(got, picture)
        print(f"aladin, {extension}: {yaw}, {pitch}, {wide}: {ratio:.1f} dB")
        assert ratio >= LEAST
