"""What the tests share: the registry turned into cases, the profiles, the data folder."""

from __future__ import annotations

import gc
import os
import signal
from collections.abc import Callable, Collection, Generator, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ran
import reference
import spheremap as sm
from hypothesis import settings
from spheremap import _core

settings.register_profile(
    "spheremap", derandomize=True, database=None, deadline=None, max_examples=60
)
settings.load_profile("spheremap")

REGISTRY: list[dict[str, Any]] = _core.registry()
NAMES: list[str] = [entry["name"] for entry in REGISTRY]

# The claims of every filter, by name, and the names of those of each method.
FILTERS: dict[str, dict[str, Any]] = {entry["name"]: entry for entry in _core.filters()}
LOOKUPS, MIPMAPPED, AREA = (
    tuple(name for name, entry in FILTERS.items() if entry["method"] == method)
    for method in ("lookup", "mipmapped", "area")
)
# Lookups that weight texels.
MEANS = tuple(name for name in LOOKUPS if not FILTERS[name]["takes_labels"])
# Those of a texel and its neighbor at most, and those of more.
NARROW = tuple(name for name in LOOKUPS if FILTERS[name]["support"] <= 1)
WIDE = tuple(name for name in LOOKUPS if FILTERS[name]["support"] > 1)

# What cameras have beside their lenses.
SENSOR = ("fx", "fy", "cx", "cy", "aspect")

# Axes that no default uses: a cyclic one, a mirrored one, and one with every sign negative.
ODD_AXES = ("+y +z +x", "-z -x +y", "-x -y -z")


# A shell that starts the tests in the background lets them, and what they start, ignore Ctrl-C.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--no-skips", action="store_true", help="a test that skips fails")
    whole = "bring the record of what ran printed code up to date; run whole files, in one process"
    parser.addoption("--record-languages", action="store_true", help=whole)


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("record_languages"):
        if getattr(config.option, "numprocesses", None):
            raise pytest.UsageError("--record-languages wants one process, without -n")
        config.pluginmanager.register(ran.Recorder())


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Keep some 40000 collected tests out of the garbage collector's way: nearly all live on."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()


def pytest_unconfigure() -> None:
    """Let go of them: nanobind prints what is left of its modules at the end as leaks."""
    gc.unfreeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if report.skipped and item.config.getoption("no_skips"):
        report.outcome, report.longrepr = "failed", f"skipped: {report.longrepr}"
    return report


# One of a kind, so that what is computed for a case can be kept for other tests (functools.cache).
@dataclass(frozen=True, eq=False)
class Case:
    """One projection to be tested, and how its test is called."""

    name: str
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def id(self) -> str:
        words = [f"{key}={value}" for key, value in self.options.items()]
        return ",".join([self.name, *words]).replace(" ", "")

    def make(self, **more: Any) -> sm.Projection:
        return sm.projection(self.name, **{**self.options, **more})

    def reference(self, **more: Any) -> reference.Reference:
        return reference.of(self.make(**more))


def _cases() -> list[Case]:
    out: list[Case] = []
    known: set[tuple[str, ...]] = set()
    for number, entry in enumerate(REGISTRY):
        name = entry["name"]
        out.append(Case(name))
        default_layout = sm.projection(name).layout
        layouts = [x for x in entry["layouts"] if x != default_layout]
        # Arrangements of faces know no projection: every layout is tested with the first
        # projection that has it, and further ones take turns.
        if layouts and tuple(layouts) in known:
            layouts = [layouts[number % len(layouts)]]
        known.add(tuple(layouts))
        out += [Case(name, {"layout": x}) for x in layouts]
        # Conventions that differ in axes, grid and layout alone are tested in test_conventions.
        seen = {(tuple(sm.projection(name).parameters.items()), None)}
        for x in entry["conventions"]:
            p = sm.projection(name, convention=x)
            shape = tuple(p.parameters.items()), reference.STORED.get((name, x))
            if shape not in seen and (name, x) not in reference.TURNED:
                seen.add(shape)
                out.append(Case(name, {"convention": x}))
        # Axes know no projection either.
        out.append(Case(name, {"axes": ODD_AXES[number % len(ODD_AXES)]}))
        for k, p in enumerate(entry["parameters"]):
            # Sensors of cameras know no lens: they are tested with the first of them.
            if p["name"] in SENSOR and name.startswith("camera_") and name != "camera_pinhole":
                continue
            lo, hi = p["minimum"], p["maximum"]
            # The first one, nearly always the angle of view, decides on coverage and rims.
            tried = [{p["name"]: lo + (hi - lo) * f} for f in ((0.125, 0.5, 0.75), (0.75,))[k > 0]]
            if name.startswith("camera_") and p["name"] not in SENSOR:
                # Coefficients of no lens are allowed: a hundredth of the way to them.
                tried = [{p["name"]: p["default"] + (hi - lo) * 0.01}]
            out += [Case(name, options) for options in tried if together(name, options)]
    return out


def together(name: str, options: dict[str, Any]) -> bool:
    """Tell whether a projection takes these parameters; some may not go with the others.

    Cameras whose lens ends inside the image have tests of their own, in map/test_cameras.py.
    """
    try:
        made = sm.projection(name, **options)
        if name.startswith("camera_"):
            t = np.linspace(0, 1, 65)
            return bool(made.valid(np.stack(np.meshgrid(t, t), -1)).all())
    except ValueError as error:
        assert str(error).startswith(f"projection '{name}': Expected"), error
        return False
    return True


CASES: list[Case] = _cases()
DEFAULTS: list[Case] = [c for c in CASES if not c.options]
LAYOUTS: list[Case] = [c for c in CASES if set(c.options) <= {"layout"}]
PARAMETERS: list[Case] = [
    c for c in CASES if c.options and not set(c.options) & {"layout", "convention", "axes"}
]
GRIDS: tuple[str, ...] = ("centers", "corners", "corners-v")
ROUND_TRIP: dict[str, tuple[float, float]] = {x["name"]: x["round_trip"] for x in REGISTRY}


def round_trip_limit(name: str, dtype: Any) -> float:
    """Give the radians that the registry claims for angle(d, decode(encode(d)))."""
    return ROUND_TRIP[name][0 if dtype == np.float32 else 1]


def each(cases: list[Case], *, slow: Sequence[Case] = ()) -> pytest.MarkDecorator:
    """Parametrize a test over cases, each under a name that can be read; over some only if slow."""
    rare = [c for c in cases if is_rare(c) and c not in slow]
    usual = [pytest.param(c, id=c.id) for c in cases if c not in rare and c not in slow]
    marked = [pytest.param(c, marks=pytest.mark.slow, id=c.id) for c in (*rare, *slow)]
    return pytest.mark.parametrize("case", [*usual, *marked])


def is_rare(case: Case) -> bool:
    """Tell cases that differ from others in what other projections have tests of."""
    # The six cameras have as many parameters as all others together.
    if case.name.startswith("camera_") and case.options:
        return True
    # Axes know no projection: those of every fourth are each of the odd ones in turn.
    return "axes" in case.options and NAMES.index(case.name) % 4 != 0


def some_fast(
    names: str | Sequence[str], values: Iterable[Any], *, fast: Collection[Any], **options: Any
) -> pytest.MarkDecorator:
    """Parametrize a test over values, of which only those that are named are not slow."""
    several = not isinstance(names, str)
    rows = [
        pytest.param(
            *(value if several else (value,)), marks=() if value in fast else pytest.mark.slow
        )
        for value in values
    ]
    assert all(value in list(values) for value in fast), "a value that there is not"
    return pytest.mark.parametrize(names, rows, **options)


def random_directions(n: int, seed: int, dtype: Any = np.float64) -> np.ndarray:
    d = np.random.default_rng(seed).normal(size=(n, 3))
    return (d / np.linalg.norm(d, axis=-1, keepdims=True)).astype(dtype)


def valid_uv(r: reference.Reference, n: int, seed: int, margin: float = 1e-6) -> np.ndarray:
    """Random uv inside the valid image, none within `margin` of a border, rim or cell edge."""
    rng = np.random.default_rng(seed)
    found: list[np.ndarray] = []
    # No image is less than a quarter valid; most are whole, and need one part only.
    for _ in range(4):
        uv = rng.random((n + n // 8, 2))
        if r.faces > 1:
            uv = np.concatenate([uv, rng.integers(0, r.faces, (len(uv), 1)).astype(float)], -1)
        ok, face = r.valid(uv), r.local(uv)[2]
        for du, dv in ((margin, 0), (-margin, 0), (0, margin), (0, -margin)):
            moved = uv.copy()
            moved[:, 0] += du
            moved[:, 1] += dv
            # Still on the same face: a neighbor in another cell is not a neighbor on the sphere.
            ok &= r.valid(moved) & (r.local(moved)[2] == face)
        found.append(uv[ok])
        if sum(len(part) for part in found) >= n:
            break
    return np.concatenate(found)[:n]


def bits(a: Any) -> np.ndarray:
    """Give the bytes of an array, to compare NaN and signed zero too."""
    a = np.ascontiguousarray(a)
    return a.view(np.uint8) if a.ndim else a.reshape(1).view(np.uint8)


def assert_same_bits(a: Any, b: Any, what: str = "") -> None:
    a, b = np.asarray(a), np.asarray(b)
    assert a.dtype == b.dtype and a.shape == b.shape, (what, a.dtype, b.dtype, a.shape, b.shape)
    # All NaN are one value here: which payload a NaN carries is nobody's promise.
    if a.dtype.kind == "f":
        same = (np.isnan(a) & np.isnan(b)) | ((a == b) & (np.signbit(a) == np.signbit(b)))
        assert np.all(same), f"{what}: {np.count_nonzero(~same)} of {same.size} values differ"
    else:
        assert np.array_equal(a, b), what


def assert_same_bits_everywhere(
    work: Callable[[], Sequence[np.ndarray]], threads: Sequence[int] = (1, 2, 3)
) -> None:
    """Compare what `work` gives at every level of instructions and with every number of threads."""
    want = None
    for level in _core.simd_levels():
        _core.set_simd_level(level)
        for n in threads:
            sm.set_num_threads(n)
            got = work()
            want = got if want is None else want
            for k, (a, b) in enumerate(zip(got, want, strict=True)):
                assert_same_bits(a, b, f"result {k} at {level} with {n} threads")


def find_data() -> Path | None:
    """Give the folder of real HDR images, or None."""
    places = [os.environ.get("SPHEREMAP_DATA")]
    places.append(str(Path(__file__).resolve().parents[1].parent / "shared" / "data"))
    for place in places:
        if place and (Path(place) / "grace_probe.hdr").is_file():
            return Path(place)
    return None


@pytest.fixture(scope="session")
def data_folder() -> Path:
    folder = find_data()
    if folder is None:
        pytest.skip("no real HDR images: set SPHEREMAP_DATA to the folder that has them")
    return folder


@pytest.fixture(autouse=True)
def _settings_restored() -> Any:
    """No test leaves another thread count or SIMD level behind."""
    threads = sm.get_num_threads()
    yield
    if sm.get_num_threads() != threads:
        sm.set_num_threads(threads)
    _core.set_simd_level(None)
