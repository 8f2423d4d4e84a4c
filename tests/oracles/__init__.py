"""Adapters to other programs, one a file. Each looks directions up with the program's own code."""

from __future__ import annotations

import os
import warnings
from types import ModuleType

import pytest


def need(name: str) -> ModuleType:
    """Import a peer; skip where it is absent, but fail in CI, where it must be there."""
    try:
        # Of a string that is badly written Python warns when it compiles the file, the first time.
        with warnings.catch_warnings():
            for kind in (DeprecationWarning, SyntaxWarning):
                warnings.simplefilter("ignore", kind)
            return __import__(name)
    except ImportError as error:
        if os.environ.get("CI"):
            pytest.fail(f"{name} must be importable in CI: {error}")
        pytest.skip(f"{name} cannot be imported: {error}")
