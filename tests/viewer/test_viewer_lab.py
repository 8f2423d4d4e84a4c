"""The widget in JupyterLab, from a cell to the kernel and back: it shows what `convert` gives."""

from __future__ import annotations

import base64
import json
import os
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from browser import launched
from oracles import need
from spheremap import io

pytestmark = pytest.mark.programs

# Twice as wide as what is sent first, which has a third of a wave in a texel.
SETUP = """
import json, numpy as np, spheremap as sm
def sky(shift=0.0):
    d = sm.directions("latlong", 1024, dtype=np.float32)
    x, y, z = np.moveaxis(d, -1, 0)
    waves = 0.5 + 0.4 * np.sin(350 * y + shift)[..., None] * np.array([1, 0.6, 0.3], np.float32)
    return (waves + 0.3 * np.stack([x, y, z], axis=-1)).clip(0).astype(np.float32)
"""
CELLS = (
    SETUP + 'image = sky()\nw = sm.view(image, "latlong", fov=50, curve="none").widget()\nw',
    'print("CLICKED", json.dumps(w.clicked), "PICKED", json.dumps(w.picked), "FOV", w.fov)',
    "w.direction = [1, 0, 0]",
    "image = sky(2.0)\nw.show(image)",
)


# A canvas that can be read at any time.
KEEP = """
const own = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return own.call(this, kind, { ...options, preserveDrawingBuffer: true });
};
"""
# Decibels: one more lookup between four than `convert` has. What is sent first has 24.
LEAST = 35.0


def notebook() -> dict[str, Any]:
    cells = [
        {
            "cell_type": "code",
            "id": f"cell{k}",
            "metadata": {},
            "execution_count": None,
            "outputs": [],
            "source": source,
        }
        for k, source in enumerate(CELLS)
    ]
    # Without a kernel's name a dialog asks for one.
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return {
        "cells": cells,
        "metadata": {"kernelspec": kernel},
        "nbformat": 4,
        "nbformat_minor": 5,
    }


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    need("jupyterlab")
    need("ipykernel")
    pytest.importorskip("anywidget", reason="widgets need: pip install spheremap[view]")
    folder: Path = tmp_path_factory.mktemp("lab")
    (folder / "look.ipynb").write_text(json.dumps(notebook()), encoding="utf-8")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    settings = {
        name: str(folder / name.lower())
        for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")
    }
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", f"--port={port}"]
    command += [
        "--ServerApp.port_retries=0",
        "--IdentityProvider.token=",
        "--ServerApp.ip=127.0.0.1",
    ]
    command += [
        "--LabApp.news_url=",
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
    ]
    path = os.pathsep.join([str(Path(sm.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    with open(folder / "log", "wb") as log:
        lab = subprocess.Popen(
            command,
            cwd=folder,
            env=os.environ | settings | {"PYTHONPATH": path},
            stdout=log,
            stderr=log,
        )
        try:
            there = f"http://127.0.0.1:{port}"
            for _ in range(240):
                try:
                    with urllib.request.urlopen(f"{there}/api/status", timeout=5):
                        break
                except OSError:
                    assert lab.poll() is None, (folder / "log").read_text()
                    time.sleep(0.5)
            yield f"{there}/lab/tree/look.ipynb"
        finally:
            lab.terminate()
            lab.wait(30)


def wanted(image: np.ndarray, direction: tuple[float, ...], size: tuple[int, int]) -> np.ndarray:
    viewer = sm.view(image, "latlong", fov=50, curve="none", direction=direction)
    return viewer.snapshot(size)


def peak_to_noise(a: np.ndarray, b: np.ndarray) -> float:
    error = np.mean((a.astype(np.float64) - b) ** 2)
    return float(10 * np.log10(255**2 / max(error, 1e-12)))


def test_a_cell_a_click_and_the_kernel(address: str, tmp_path: Path) -> None:
    with launched() as browser:
        page = browser.new_page(viewport={"width": 1100, "height": 900})
        said: list[str] = []
        page.on("pageerror", lambda error: said.append(str(error)))
        # A machine that does other things besides takes minutes.
        page.set_default_timeout(240_000)
        page.add_init_script(KEEP)
        page.goto(address, wait_until="commit")
        cells = page.locator(".jp-Notebook .jp-CodeCell")
        cells.nth(3).wait_for()
        canvas = page.locator(".spheremap canvas")

        def run(k: int) -> None:
            cells.nth(k).locator(".jp-InputArea-editor").click()
            page.keyboard.press("Control+Enter")

        def seen() -> np.ndarray:
            # A screenshot would be between pixels: what is above it need not be whole ones high.
            place = tmp_path / "canvas.png"
            data = canvas.evaluate("(canvas) => canvas.toDataURL('image/png')")
            place.write_bytes(base64.b64decode(data.split(",")[1]))
            return io.read(place)[..., :3]

        def settles(image: np.ndarray, direction: tuple[float, ...]) -> float:
            """Return how well the canvas shows it, once it does."""
            ratio = -np.inf
            for _ in range(120):
                picture = seen()
                ratio = peak_to_noise(picture, wanted(image, direction, picture.shape[:2]))
                if ratio >= LEAST:
                    break
                page.wait_for_timeout(1000)
            return ratio

        names: dict[str, Any] = {}
        exec(SETUP, names)
        image, other = names["sky"](), names["sky"](2.0)

        page.locator(".jp-Notebook-ExecutionIndicator[data-status=idle]").wait_for()
        run(0)
        canvas.wait_for()
        # What was sent first is blurred.
        ratio = settles(image, (0, 0, -1))
        print(f"JupyterLab: {ratio:.1f} dB")
        assert ratio >= LEAST

        box = canvas.bounding_box()
        assert box is not None
        page.mouse.click(box["x"] + box["width"] / 4, box["y"] + box["height"] / 3)
        page.wait_for_timeout(1000)
        run(1)
        output = cells.nth(1).locator(".jp-OutputArea-output")
        output.wait_for()
        text = output.inner_text()
        clicked = json.loads(text.split("CLICKED ")[1].split(" PICKED")[0])
        picked = json.loads(text.split("PICKED ")[1].split(" FOV")[0])
        # The numbers of the array, not the half floats of a reduced one. What is picked has
        # followed the pointer since.
        for told in (clicked, picked):
            column, row = told["texel"]
            assert told["value"] == image[row, column].astype(float).tolist()
        # Of the place that was clicked.
        half = np.tan(np.radians(25))
        d = np.array([-half / 2, half * box["height"] / box["width"] / 3, -1])
        place = sm.projection("latlong").directions_to_pixels(d, 1024)
        # Texels of the image are larger than pixels of the canvas.
        assert np.abs(place - 0.5 - clicked["texel"]).max() < 2.5

        run(2)
        assert settles(image, (1, 0, 0)) >= LEAST
        run(3)
        assert settles(other, (1, 0, 0)) >= LEAST
        page.close()
    assert said == []
