"""Adapters to other programs, one a file. Each looks directions up with the program's own code."""

from __future__ import annotations

import os
from types import ModuleType

import pytest


def need(name: str) -> ModuleType:
    """Import a peer; skip where it is absent, but fail in CI, where it must be there."""
    try:
        return __import__(name)
    except ImportError as error:
        if os.environ.get("CI"):
            pytest.fail(f"{name} must be importable in CI: {error}")
        pytest.skip(f"{name} cannot be imported: {error}")
