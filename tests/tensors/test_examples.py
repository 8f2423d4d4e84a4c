"""The examples in the docstrings of spheremap.torch and spheremap.jax run."""

from __future__ import annotations

import doctest
from importlib import import_module

import pytest

pytestmark = pytest.mark.programs


@pytest.mark.parametrize("module", ["torch", "jax"])
def test_the_examples_run(module: str) -> None:
    pytest.importorskip(module)
    verbs = import_module(f"spheremap.{module}")
    for name in verbs.__all__:
        function = getattr(verbs, name)
        home = import_module(function.__module__)
        (found,) = doctest.DocTestFinder(recurse=False).find(function, name, home)
        assert found.examples
        said: list[str] = []
        assert doctest.DocTestRunner().run(found, out=said.append).failed == 0, "".join(said)
