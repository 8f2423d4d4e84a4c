"""The calls of `python -m bits`, at every level of instructions of this machine."""

from __future__ import annotations

import pytest
from spheremap import _core

from . import calls, inputs
from .__main__ import digest


@pytest.mark.slow
def test_every_call_has_the_same_bits_at_every_level():
    given = inputs.make()
    want = None
    for level in _core.simd_levels():
        _core.set_simd_level(level)
        got = {name: digest(a) for name, a in calls.results(given)}
        want = want or got
        assert list(got) == list(want)
        assert [name for name in got if got[name] != want[name]] == [], level
