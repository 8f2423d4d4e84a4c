"""The wheel: it builds, installs into an empty environment, imports, and needs numpy alone."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.slow

PROGRAM = """
import sys
import numpy as np
import spheremap as sm

assert "site-packages" in sm.__file__, sm.__file__
d = np.random.default_rng(0).normal(size=(100_000, 3)).astype(np.float32)
d /= np.linalg.norm(d, axis=1, keepdims=True)
for name in sm.projections():
    p = sm.projection(name)
    back = p.decode(p.encode(d))
    seen = p.covers(d)
    assert seen.any()
    assert np.abs(back - d)[seen].max() < 2e-3, name
extras = {"typer", "rich", "matplotlib", "OpenImageIO"} & set(sys.modules)
assert not extras, extras
print(sm.__version__)
"""


def run(*command: object, **options: object) -> str:
    """Run a command outside the checkout and return what it says."""
    # What an outer make or an active environment left behind would mislead the inner ones.
    drop = ("MAKEFLAGS", "MAKELEVEL", "MFLAGS", "PYTHONPATH", "VIRTUAL_ENV")
    environment = {k: v for k, v in os.environ.items() if k not in drop}
    done = subprocess.run(
        [str(part) for part in command],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
        **options,  # type: ignore[call-overload]
    )
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if sys.prefix == sys.base_prefix or shutil.which("make") is None:
        pytest.skip("needs make and a virtual environment")
    place = tmp_path_factory.mktemp("dist")
    run("make", "-C", ROOT, "wheel", f"VENV={sys.prefix}", f"DIST={place}", cwd=ROOT)
    (built,) = place.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the interpreter of an environment that holds the wheel and what it asks for."""
    home = tmp_path_factory.mktemp("empty")
    venv.create(home, with_pip=True)
    interpreter = home / ("Scripts" if os.name == "nt" else "bin") / "python"
    run(interpreter, "-m", "pip", "install", "--quiet", wheel, cwd=home)
    return interpreter


def test_the_wheel_is_one_for_all_pythons_and_holds_no_more_than_it_should(wheel: Path) -> None:
    assert "-cp311-abi3-" in wheel.name
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (metadata,) = (n for n in names if n.endswith(".dist-info/METADATA"))
        about = archive.read(metadata).decode()
    for wanted in (
        "__init__.py",
        "_core.pyi",
        "py.typed",
        "_names.py",
        "viewer/viewer.js",
        "tiles/pages/hips.html",
    ):
        assert f"spheremap/{wanted}" in names
    assert sum(n.startswith("spheremap/_core.") and not n.endswith(".pyi") for n in names) == 1
    assert all(n.startswith(("spheremap/", "spheremap-")) for n in names)
    assert not any("__pycache__" in n for n in names)
    for license in ("LICENSE", "LICENSE-MIT", "LICENSE-APACHE"):
        assert any(n.endswith(f"licenses/{license}") for n in names)
    assert "Requires-Python: >=3.11" in about
    required = [x for x in about.splitlines() if x.startswith("Requires-Dist:")]
    assert [x for x in required if "extra ==" not in x] == ["Requires-Dist: numpy>=2"]


def test_the_wheel_names_the_crates_that_are_linked(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (bill,) = (n for n in archive.namelist() if ".dist-info/sboms/" in n)
        said = json.loads(archive.read(bill))
    assert said["bomFormat"] == "CycloneDX"
    assert said["metadata"]["component"]["name"] == "spheremap"
    named = {(x["name"], x["version"]) for x in said["components"] if x["scope"] == "required"}
    # Every crate that this machine's library is made of; the bill may name more.
    machine = next(x[6:] for x in run("rustc", "-vV").splitlines() if x.startswith("host: "))
    metadata = json.loads(
        run(
            *("cargo", "metadata", "--format-version", "1", "--features", "python"),
            *("--filter-platform", machine),
            cwd=ROOT,
        )
    )
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    linked: set[str] = set()
    left = [metadata["resolve"]["root"]]
    while left:
        for dependency in nodes[left.pop()]["deps"]:
            # Neither what tests need nor what runs while it is built.
            normal = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if normal and dependency["pkg"] not in linked:
                linked.add(dependency["pkg"])
                left.append(dependency["pkg"])
    crates = {(packages[x]["name"], packages[x]["version"]) for x in linked}
    assert {"pyo3", "numpy", "rayon", "fearless_simd"} <= {name for name, _ in crates}
    assert crates <= named


def test_the_wheel_works_in_an_empty_environment(python: Path, tmp_path: Path) -> None:
    said = run(python, "-W", "error", "-c", PROGRAM, cwd=tmp_path)
    assert said.strip()


def test_the_command_without_its_extra_says_what_is_missing(python: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [python.parent / "spheremap", "projections"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert done.returncode != 0
    assert "pip install" in done.stderr
    assert "Traceback" not in done.stderr
