"""Pages that are written by hand: those of docs/, notebooks/ and site/pages, as they are."""

from __future__ import annotations

import re
from pathlib import Path

from .source import ROOT, Source, toctree

TOP = ("BENCHMARKS.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
LINK = re.compile(r"\]\((?!\w+:)([^)#\s]+)")
# Pages of docs/ that have pages below them, which `maker` writes or which lie in a folder.
BELOW = {
    "docs/decisions/README.md": "docs/decisions/*.md",
    "docs/start/README.md": "docs/start/*.md",
    "notebooks/README.md": "notebooks/*.ipynb",
}


def copy(source: Source) -> None:
    """Copy them, and the files that they link to."""
    pages = [*(ROOT / name for name in TOP), *sorted((ROOT / "docs").rglob("*.md"))]
    pages.append(ROOT / "notebooks" / "README.md")
    for page in pages:
        place = str(page.relative_to(ROOT))
        text = page.read_text(encoding="utf-8")
        copy_linked(source, text, page.parent)
        if place in BELOW:
            below = sorted(path for path in ROOT.glob(BELOW[place]) if path != page)
            text += "\n" + toctree([path.stem for path in below])
        source.write(place, text)
    for folder, pattern, place in (
        ("notebooks", "*.ipynb", "notebooks"),
        ("site/pages", "*", "."),
        ("site/static", "*", "_static"),
    ):
        for path in sorted((ROOT / folder).glob(pattern)):
            source.copy(path, f"{place}/{path.name}")
            if place == ".":
                copy_linked(source, path.read_text(encoding="utf-8"), ROOT)


def copy_linked(source: Source, text: str, folder: Path) -> None:
    """Copy the files that a page links to, which are no pages."""
    for link in LINK.findall(text):
        target = (folder / link).resolve()
        if target.is_file() and target.suffix not in (".md", ".ipynb"):
            source.copy(target, str(target.relative_to(ROOT)))
