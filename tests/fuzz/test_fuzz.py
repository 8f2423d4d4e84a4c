"""Whatever a public function is given, it returns or raises an error of ours, and soon."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from conftest import some_fast

from .calls import call, targets
from .campaign import run
from .worker import verdict_on

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory and signals")

# Fixed, so that a change of the library and not of luck makes a test fail.
SEED = 20
PIECES = 4


def test_every_public_function_is_called():
    # Those that take long are drawn more seldom.
    count = 60 * len(targets())
    seen = {call(SEED, k).partition("(first")[0] for k in range(count)}
    missing = [t.name for t in targets() if not any(f".{t.name}(" in text for text in seen)]
    assert len(targets()) > 100 and not missing


def test_a_call_is_the_same_every_time():
    assert [call(3, k) for k in range(50)] == [call(3, k) for k in range(50)]


@some_fast("piece", range(PIECES), fast=(0,))
def test_hostile_calls_return_or_raise(piece):
    findings = run(SEED, 750 * piece, 750 * (piece + 1))
    assert not findings, "\n".join(map(str, findings))


@pytest.mark.slow
@pytest.mark.parametrize("piece", range(PIECES))
def test_twenty_thousand_hostile_calls_return_or_raise(piece):
    findings = run(SEED + 1, 5000 * piece, 5000 * (piece + 1))
    assert not findings, "\n".join(map(str, findings))


@pytest.mark.parametrize(
    "expression, what",
    [
        ("(1 for _ in ()).throw(KeyError(1))", "exception"),
        ("np.ones(()).argmax(3)", "another library's message"),
        ("np.divide(1, 0)", "warning"),
        ("[][0]", "exception"),
    ],
)
def test_a_fault_is_seen(expression, what):
    got = verdict_on(f"(lambda: {expression})()", {"np": np})
    assert got is not None and got[0] == what
