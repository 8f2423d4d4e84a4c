"""The examples in the docstrings of spheremap.torch and spheremap.jax run."""

from __future__ import annotations

import doctest
from importlib import import_module
from types import ModuleType

import pytest

pytestmark = pytest.mark.programs


@pytest.mark.parametrize("module", ["torch", "jax"])
def test_the_examples_run(module: str) -> None:
    pytest.importorskip(module)
    verbs = import_module(f"spheremap.{module}")
    public = [(name, getattr(verbs, name)) for name in verbs.__all__]
    for group in [one for _, one in public if isinstance(one, ModuleType)]:
        public += [(name, getattr(group, name)) for name in group.__all__]
    for name, function in public:
        if isinstance(function, ModuleType):
            continue
        home = import_module(function.__module__)
        (found,) = doctest.DocTestFinder(recurse=False).find(function, name, home)
        assert found.examples
        said: list[str] = []
        assert doctest.DocTestRunner().run(found, out=said.append).failed == 0, "".join(said)
