"""Chromium, drawing by WebGL 2 in software: a system's, or what SPHEREMAP_CHROMIUM names."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from oracles import need

ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@contextmanager
def launched() -> Iterator[Any]:
    """Give a browser, and close it."""
    playwright = need("playwright.sync_api").sync_api
    path = os.environ.get("SPHEREMAP_CHROMIUM") or shutil.which("chromium")
    with playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield browser
        browser.close()
