"""The notebooks: kept without outputs, listed, and each runs to its last assert."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))

# Runs the code of all cells in one namespace, without Jupyter. Warnings are errors, as in pytest.
RUN = """
import json, sys, warnings
warnings.simplefilter("error")
cells = json.loads(open(sys.argv[1], encoding="utf-8").read())["cells"]
names = {"__name__": "__main__"}
for cell in cells:
    if cell["cell_type"] == "code":
        exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
"""

each = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)


def read(path: Path) -> dict[str, Any]:
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return notebook


def test_there_are_eight() -> None:
    assert [path.name[:2] for path in NOTEBOOKS] == [f"{k}_" for k in range(1, 9)]


@each
def test_the_format(path: Path) -> None:
    notebook = read(path)
    assert set(notebook) == {"cells", "metadata", "nbformat", "nbformat_minor"}
    # 4.5 is the first in which cells have ids.
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert notebook["metadata"]["kernelspec"]["name"] == "python3"
    ids = [cell["id"] for cell in notebook["cells"]]
    assert len(set(ids)) == len(ids)
    assert all(re.fullmatch(r"[a-zA-Z0-9_-]{1,64}", name) for name in ids)
    for cell in notebook["cells"]:
        assert cell["cell_type"] in ("code", "markdown")
        assert all(isinstance(line, str) for line in cell["source"])


@each
def test_no_outputs_are_kept(path: Path) -> None:
    for cell in read(path)["cells"]:
        assert cell["metadata"] == {}
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [] and cell["execution_count"] is None
        else:
            assert "outputs" not in cell


@each
def test_it_proves_its_point(path: Path) -> None:
    notebook = read(path)
    assert notebook["cells"][0]["cell_type"] == "markdown"
    code = [c for c in notebook["cells"] if c["cell_type"] == "code"]
    assert any("\nassert " in "\n" + "".join(c["source"]) for c in code)


def test_each_is_listed() -> None:
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^- \[(.+)\]\((\S+\.ipynb)\): \S", text, re.MULTILINE)
    titles = [("".join(read(p)["cells"][0]["source"]).split("\n")[0], p.name) for p in NOTEBOOKS]
    assert [(f"# {title}", name) for title, name in listed] == titles


@pytest.mark.slow
@each
def test_it_runs(path: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    if path.name.startswith("3"):
        pytest.importorskip("skimage")
    if path.name.startswith("8"):
        pytest.importorskip("scipy")
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    environment.pop("SPHEREMAP_DATA", None)
    run = subprocess.run(
        [sys.executable, "-c", RUN, str(path)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert run.returncode == 0, run.stderr
