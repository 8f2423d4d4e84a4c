"""The examples in the docstrings and the page of spheremap.torch run."""

from __future__ import annotations

import doctest
from importlib import import_module

import pytest

pytest.importorskip("torch")
import spheremap.torch as smt

pytestmark = pytest.mark.programs


@pytest.mark.parametrize("name", smt.__all__)
def test_the_example_runs(name: str) -> None:
    function = getattr(smt, name)
    module = import_module(function.__module__)
    (found,) = doctest.DocTestFinder(recurse=False).find(function, name, module)
    assert found.examples
    said: list[str] = []
    assert doctest.DocTestRunner().run(found, out=said.append).failed == 0, "".join(said)
