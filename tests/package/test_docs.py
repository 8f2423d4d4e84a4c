"""The documentation: its examples run, its tables are up to date, its links lead somewhere."""

from __future__ import annotations

import doctest
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import some_fast

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def examples(page: Path) -> str:
    """Return the page's blocks of Python as one doctest; other lines are blank, so numbers fit."""
    text = page.read_text(encoding="utf-8")
    kept = [""] * (text.count("\n") + 1)
    for block in BLOCK.finditer(text):
        first = text.count("\n", 0, block.start(1))
        lines = block.group(1).splitlines()
        kept[first : first + len(lines)] = lines
    return "\n".join(kept)


def heading(line: str) -> str:
    """Return the anchor that a heading gets."""
    return re.sub(r"[^\w\- ]", "", line.lstrip("# ").lower()).replace(" ", "-")


WITH_EXAMPLES = [p for p in PAGES if examples(p).strip()]
# They take seconds each.
LONG = ("jax.md", "dask.md", "cameras.md")


@some_fast(
    "page",
    WITH_EXAMPLES,
    fast=[p for p in WITH_EXAMPLES if p.name not in LONG],
    ids=[p.name for p in WITH_EXAMPLES],
)
def test_the_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if page.name in ("torch.md", "jax.md"):
        # Run by `make test-torch` and `make test-jax`.
        pytest.importorskip(page.stem)
    monkeypatch.chdir(tmp_path)
    test = doctest.DocTestParser().get_doctest(examples(page), {}, page.name, str(page), 0)
    assert test.examples
    said: list[str] = []
    result = doctest.DocTestRunner().run(test, out=said.append)
    assert result.failed == 0, "".join(said)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_every_block_of_python_is_a_doctest(page: Path) -> None:
    for block in BLOCK.finditer(page.read_text(encoding="utf-8")):
        assert block.group(1).startswith(">>> ")


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_the_links_lead_somewhere(page: Path) -> None:
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        if "://" in link:
            continue
        place, _, anchor = link.partition("#")
        target = (page.parent / place).resolve() if place else page
        assert target.exists(), link
        if anchor:
            lines = target.read_text(encoding="utf-8").splitlines()
            assert anchor in {heading(x) for x in lines if x.startswith("#")}, link


def test_a_package_index_gets_links_that_hold_there() -> None:
    """Pictures by their bytes, other files by the page that shows them, and places in the page."""
    absolute = runpy.run_path(str(ROOT / "tools" / "absolute_links.py"))["absolute"]
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    made = absolute(text, "https://example.org/a/b", "v1")
    assert len(LINK.findall(made)) == len(LINK.findall(text))
    for before, after in zip(LINK.findall(text), LINK.findall(made), strict=True):
        relative = "://" not in before and not before.startswith("#")
        kind = "raw" if before.endswith(".png") else "blob"
        assert after == (f"https://example.org/a/b/{kind}/v1/{before}" if relative else before)
    assert absolute("[a](#b) [c](https://d) ![e](f.png)", "https://x/y/", "z") == (
        "[a](#b) [c](https://d) ![e](https://x/y/raw/z/f.png)"
    )


@pytest.mark.parametrize(
    "script", ["generate_docs.py", "generate_names.py", "generate_projection.py"]
)
def test_generated_files_are_up_to_date(script: str) -> None:
    command = [sys.executable, str(ROOT / "tools" / script), "--check"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
