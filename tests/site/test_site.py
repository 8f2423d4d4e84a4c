"""The pages that `make site` has made: links, sizes, what has a page, and who can read them.

`make test-site` builds them and says by SPHEREMAP_SITE where they are. axe-core comes from npm, and
runs in Chromium.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
import spheremap as sm
from browser import launched
from spheremap import _core

pytestmark = pytest.mark.programs

# With its pictures and frames, so that it opens on a slow line.
LARGEST = 1_000_000
AXE = "axe-core@4.14.1"
# One of each kind.
KINDS = (
    "index.html",
    "gallery.html",
    "speed.html",
    "docs/start/vision.html",
    "docs/projections.html",
    "docs/projections/latlong.html",
    "docs/conventions/blender.html",
    "docs/resampling.html",
    "api/index.html",
    "api/spheremap.convert.html",
    "api/spheremap.Projection.html",
    "notebooks/1_first_panorama.html",
    "search.html",
)


class Page(HTMLParser):
    """What a page links to, what it shows, and the places in it that can be linked to."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.shown: list[str] = []
        self.places: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value for name, value in attrs if value}
        self.places |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag in ("img", "iframe") and "src" in given:
            self.shown.append(given["src"])


def site() -> Path:
    folder = os.environ.get("SPHEREMAP_SITE")
    if not folder:
        pytest.skip("SPHEREMAP_SITE names no folder: run `make test-site`")
    return Path(folder)


@cache
def read(path: Path) -> Page:
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


@cache
def pages() -> list[Path]:
    """Return all pages, but those of `sm.view`, which are shown in others."""
    folder = site()
    found = [path for path in folder.rglob("*.html") if "_static" not in path.parts]
    assert found, folder
    return sorted(found)


def target_of(path: Path, link: str) -> Path | None:
    """Return the file that a link leads to, or None where it leads out of the site."""
    parts = urlsplit(link)
    if parts.scheme in ("http", "https", "mailto", "data"):
        return None
    return (path.parent / unquote(parts.path)).resolve() if parts.path else path


def test_links_lead_somewhere() -> None:
    broken = []
    for path in pages():
        page = read(path)
        for link in page.links + page.shown:
            target = target_of(path, link)
            if target is None:
                continue
            anchor = unquote(urlsplit(link).fragment)
            there = target.is_file()
            if there and anchor and target.suffix == ".html":
                there = anchor in read(target).places
            if not there:
                broken.append((path.name, link))
    assert broken == []


def test_nothing_is_loaded_from_elsewhere() -> None:
    for path in pages():
        text = path.read_text(encoding="utf-8")
        for start in ('src="http', "src='http", 'rel="stylesheet" href="http', "url(http"):
            assert start not in text, (path.name, start)


def test_no_page_is_large() -> None:
    large = {}
    for path in pages():
        shown = {target_of(path, link) for link in read(path).shown} - {None}
        size = path.stat().st_size + sum(p.stat().st_size for p in shown if p is not None)
        if size >= LARGEST:
            large[str(path.relative_to(site()))] = size
    assert large == {}


def test_every_projection_and_program_has_a_page() -> None:
    for entry in _core.registry():
        path = site() / "docs" / "projections" / f"{entry['name']}.html"
        shown = [Path(link) for link in read(path).shown]
        assert f"projection-{entry['name']}.png" in [link.name for link in shown], path.name
        assert f"{entry['name']}.html" in [link.name for link in shown], "no view to turn"
        assert "formula" in read(path).places
    for convention in _core.convention_table():
        kind, name = convention["kind"], convention["name"]
        own = [read(p).places for p in (site() / "docs" / "conventions").glob("*.html")]
        assert any(f"{kind}-{name}" in p or f"{kind}{name}" in p for p in own), (kind, name)


def public() -> Iterator[str]:
    """Give all public names, with their modules; of what is not installed, none."""
    subjects = [x for x in sm.__all__ if isinstance(getattr(sm, x), ModuleType)]
    for module in ("spheremap", *(f"spheremap.{x}" for x in [*subjects, "xarray", "dask"])):
        loaded = import_module(module)
        for name in loaded.__all__:
            if not isinstance(getattr(loaded, name), ModuleType):
                yield f"{module}.{name}"


def test_every_public_name_has_a_page() -> None:
    names = list(public())
    # Its verbs on tensors are read from files, not imported: one stands for them.
    for name in [*names, "spheremap.torch.convert", "spheremap.jax.convert"]:
        path = site() / "api" / f"{name}.html"
        assert path.is_file(), name
        assert name in read(path).places, name
    for name in dir(sm.Projection):
        if not name.startswith("_"):
            places = read(site() / "api" / "spheremap.Projection.html").places
            assert f"spheremap.Projection.{name}" in places, name


def test_search_knows_the_pages() -> None:
    index = (site() / "searchindex.js").read_text(encoding="utf-8")
    for word in ("equirectangular", "spheremap.light.irradiance", "docs/projections/mollweide"):
        assert word in index, word


def test_every_notebook_has_its_figures() -> None:
    notebooks = sorted((site() / "notebooks").glob("[1-9]_*.html"))
    assert len(notebooks) == 8
    for path in notebooks:
        assert read(path).shown, path.name


@pytest.fixture(scope="module")
def axe(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return the program of axe-core."""
    if shutil.which("npm") is None:
        pytest.skip("axe-core comes from npm")
    folder = tmp_path_factory.mktemp("axe")
    command = ["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", AXE]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"npm has no axe-core: {done.stderr[-200:]}")
    source: Path = folder / "node_modules" / "axe-core" / "axe.min.js"
    return source.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with launched() as browser:
        yield browser


@pytest.fixture
def tab(request: pytest.FixtureRequest, chromium: Any) -> Iterator[Any]:
    """Return a page of a browser that asks nothing of any server, of what a test asks of it."""
    context = chromium.new_context(offline=True, **getattr(request, "param", {}))
    # A machine with much to do is no reason to fail.
    context.set_default_timeout(600_000)
    yield context.new_page()
    context.close()


@pytest.mark.parametrize(
    "tab",
    [{"color_scheme": "light"}, {"color_scheme": "dark"}],
    indirect=True,
    ids=["light", "dark"],
)
@pytest.mark.parametrize("page", KINDS)
def test_everybody_can_read_it(page: str, tab: Any, axe: str) -> None:
    tab.goto((site() / page).as_uri())
    tab.evaluate(axe)
    # In the page alone: frames hold pages of sm.view, which have tests of their own.
    found = tab.evaluate("axe.run(document, { iframes: false })")
    serious = [
        (rule["id"], node["html"][:120], node["failureSummary"][:200])
        for rule in found["violations"]
        if rule["impact"] in ("serious", "critical")
        for node in rule["nodes"]
    ]
    assert serious == []
    # What axe cannot decide it does not count, and an empty page has nothing to find.
    assert len(found["passes"]) > 10


@pytest.mark.parametrize("tab", [{"color_scheme": "dark"}], indirect=True, ids=["dark"])
def test_colors_are_those_that_are_asked_for(tab: Any) -> None:
    tab.goto((site() / "index.html").as_uri())
    assert tab.evaluate("document.documentElement.dataset.theme") == "dark"


@pytest.mark.parametrize(
    "tab", [{"viewport": {"width": 390, "height": 800}}], indirect=True, ids=["phone"]
)
@pytest.mark.parametrize("page", KINDS)
def test_a_phone_shows_it_without_scrolling_aside(page: str, tab: Any) -> None:
    tab.goto((site() / page).as_uri())
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390


def test_the_view_of_a_projection_draws(tab: Any) -> None:
    said: list[str] = []
    # What the theme says of its own does not count.
    tab.on("console", lambda m: said.append(m.text) if "look" in m.location["url"] else None)
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.goto((site() / "docs" / "projections" / "cube.html").as_uri())
    tab.locator("iframe.look").scroll_into_view_if_needed()
    frame = tab.locator("iframe.look").element_handle().content_frame()
    frame.wait_for_function("window.spheremap")
    frame.evaluate("spheremap.ready.then(() => true)")
    assert said == []


def test_search_finds(tab: Any) -> None:
    tab.goto((site() / "search.html").as_uri() + "?q=equirectangular")
    tab.wait_for_selector("#search-results li a")
    found = tab.eval_on_selector_all("#search-results li a", "links => links.map(a => a.href)")
    assert any("docs/projections/latlong" in link for link in found)
