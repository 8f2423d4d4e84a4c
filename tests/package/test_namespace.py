"""What a person finds by `dir` and by completion: the public names, and nothing else."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module
from types import ModuleType

import pytest
import spheremap as sm

SUBJECTS = (
    "align",
    "ball",
    "cameras",
    "healpix",
    "io",
    "light",
    "packing",
    "plot",
    "sh",
    "tiles",
    "video",
)
# What moved into a subject, or was called otherwise before.
MOVED = ("irradiance", "sh_project", "pack", "unwrap_ball", "identify", "lights", "write_dds")


def python(code: str) -> str:
    """Return what a fresh interpreter prints."""
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_dir_is_what_is_public() -> None:
    assert dir(sm) == sorted(sm.__all__)
    assert set(SUBJECTS) < set(dir(sm))
    assert [name for name in dir(sm) if name.startswith("_")] == ["__version__"]


@pytest.mark.parametrize("name", SUBJECTS)
def test_dir_of_a_subject_is_what_is_public(name: str) -> None:
    subject = getattr(sm, name)
    assert subject is import_module(f"spheremap.{name}")
    assert dir(subject) == sorted(subject.__all__)
    for public in dir(subject):
        assert not public.startswith("_")
        value = getattr(subject, public)
        assert not isinstance(value, ModuleType), f"{name}.{public}"
        assert value.__doc__, f"{name}.{public}"


@pytest.mark.parametrize("name", sorted(set(sm.__all__) - set(SUBJECTS)))
def test_every_name_at_the_top_is_there(name: str) -> None:
    assert not isinstance(getattr(sm, name), ModuleType)


def test_no_name_is_in_two_places() -> None:
    """The same word may name two things (`sh.convert`), but no thing has two names."""
    places: dict[int, str] = {}
    spaces = {"": sm, **{name: getattr(sm, name) for name in SUBJECTS}}
    for space, module in spaces.items():
        for name in dir(module):
            value = getattr(module, name)
            if not isinstance(value, ModuleType):
                assert places.setdefault(id(value), space) == space, (space, name)


@pytest.mark.parametrize("name", MOVED)
def test_old_names_are_gone(name: str) -> None:
    with pytest.raises(AttributeError, match=f"no attribute '{name}'"):
        getattr(sm, name)


def test_subjects_are_imported_when_they_are_first_used() -> None:
    code = (
        "import sys, spheremap as sm; "
        f"loaded = [s for s in {SUBJECTS} if f'spheremap.{{s}}' in sys.modules]; "
        "sm.light.irradiance; print(loaded, 'spheremap.light' in sys.modules)"
    )
    assert python(code) == "[] True"


def test_everything_can_be_imported_by_a_star() -> None:
    assert python("from spheremap import *; print(sh.project.__name__, encode.__name__)") == (
        "project encode"
    )


def test_a_plot_without_its_extra_says_what_to_install() -> None:
    code = (
        "import sys; sys.modules['matplotlib'] = None; import spheremap as sm, numpy as np\n"
        "try: sm.plot.show(np.zeros((4, 8)), 'latlong')\n"
        "except ImportError as error: print(error)"
    )
    assert "pip install spheremap[plot]" in python(code)
