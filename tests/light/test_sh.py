"""Spherical harmonics: exact on band-limited images, turned, convolved, windowed, rewritten."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import LAYOUTS, Case, each, random_directions
from reference import light as reference

WHOLE = [c for c in LAYOUTS if c.make().coverage == "sphere"]


def coefficients(order: int, channels: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=((order + 1) ** 2, channels))


def shown(p: sm.Projection, size: int, c: np.ndarray) -> np.ndarray:
    """Give the image of a function, with numbers that must not matter where there is none."""
    return np.nan_to_num(sm.sh.evaluate(c, p.directions(size)), nan=1e3)


def test_the_basis_is_the_literal_one() -> None:
    d = random_directions(300, 2)
    # Six steps of a recurrence, to values up to 2: some ε each.
    assert np.abs(sm.sh.evaluate(np.eye(49), d) - reference.ylm(6, d)).max() < 1e-13
    # Legendre functions by scipy are good to 1e-11 at order 64.
    for order, bound in ((3, 1e-14), (20, 1e-12), (64, 1e-10)):
        c = np.random.default_rng(order).normal(size=((order + 1) ** 2, 3))
        got = sm.sh.evaluate(c, d)
        assert np.abs(got - reference.ylm(order, d) @ c).max() < bound * order
    poles = sm.sh.evaluate(np.eye(25), [[0, 0, 1], [0, 0, -7], [0, 0, 0]])
    zonal = [math.sqrt((2 * k + 1) / (4 * math.pi)) for k in range(5)]
    # A root each; `allclose`'s own 1e-5 would show any other factor.
    assert np.allclose(poles[0][[0, 2, 6, 12, 20]], zonal) and np.count_nonzero(poles[0]) == 5
    assert np.isnan(poles[2]).all()


@each(WHOLE)
@pytest.mark.parametrize(("order", "size"), [(0, 3), (1, 8), (2, 9), (8, 40)])
def test_band_limited_images_give_their_coefficients(case: Case, order: int, size: int) -> None:
    p = case.make()
    c = coefficients(order, 3)
    # Rounding of sums and a small solve: the 1e-12 that `project` states, ten times.
    assert (
        np.abs(sm.sh.project(shown(p, size, c), p, order=order, texels="points") - c).max() < 1e-11
    )


@each(WHOLE)
def test_no_degree_leaks_into_the_mean(case: Case) -> None:
    p = case.make()
    for degree in (1, 2):
        c = np.zeros(((degree + 1) ** 2, 1))
        c[-1] = 1.0
        # Some thousand doubles that cancel: some tens of ε.
        assert abs(sm.sh.project(shown(p, 24, c), p, order=0, texels="points")[0, 0]) < 1e-13


@pytest.mark.parametrize("grid", ["centers", "corners", "corners-v"])
@pytest.mark.parametrize("shape", [(33, 64), (34, 65)])
def test_rings_of_every_grid(grid: str, shape: tuple[int, int]) -> None:
    p = sm.projection("latlong", grid=grid)
    c = coefficients(15, 1)
    image = np.ascontiguousarray(sm.sh.evaluate(c, p.directions(shape)))
    # The rounding that `project` states.
    assert np.abs(sm.sh.project(image, p, order=15, texels="points") - c).max() < 1e-12


def test_a_high_order_on_rings() -> None:
    c = coefficients(64, 1)
    image = sm.sh.evaluate(c, sm.directions("latlong", 129))
    # Order 64 takes 64 steps of a recurrence: ten times the rounding that low orders have.
    assert np.abs(sm.sh.project(image, "latlong", order=64, texels="points") - c).max() < 1e-11


def test_an_image_holds_so_much_and_no_more() -> None:
    with pytest.raises(ValueError, match=r"\(8, 16\) holds .* up to order 3, got `order` 4"):
        sm.sh.project(np.ones((8, 16)), "latlong", order=4)
    with pytest.raises(ValueError, match="holds spherical harmonics up to order"):
        sm.sh.project(np.ones((6, 2, 2)), "cube", order=5, texels="points")
    for order in (-1, 65):
        with pytest.raises(ValueError, match="whole number from 0 to 64"):
            sm.sh.project(np.ones((8, 16)), "latlong", order=order, texels="points")


def test_part_of_a_sphere_is_black_beyond() -> None:
    white = np.ones(sm.projection("hemioctahedral").shape(64))
    got = sm.sh.project(white, "hemioctahedral", order=1)
    want = [math.sqrt(math.pi), 0, math.sqrt(3 * math.pi) / 2, 0]
    # The midpoint rule at 64 texels a side: (1/64)² of some units.
    assert np.abs(got - want).max() < 1e-3


@pytest.mark.parametrize("order", [1, 8, 64])
def test_rotation_is_exact(order: int) -> None:
    c = coefficients(order, 2)
    d = random_directions(100, 4)
    for angles in ((0, 0, 0), (90, 0, 0), (13, -77, 160), (1e-7, 180, 0)):
        r = sm.rotation(*angles)
        turned = sm.sh.rotate(c, r)
        error = sm.sh.evaluate(turned, d @ r.T) - sm.sh.evaluate(c, d)
        # 65² terms, each after 64 steps of a recurrence: a hundred of the 1e-12 of `rotate`.
        assert np.abs(error).max() < 1e-10
        assert np.abs(sm.sh.rotate(turned, r.T) - c).max() < 1e-10
    with pytest.raises(ValueError, match="rotation"):
        sm.sh.rotate(c, np.diag([1.0, 1.0, -1.0]))


def test_rotation_agrees_with_a_turned_image() -> None:
    c = coefficients(5, 3)
    r = sm.rotation(30, 40, 50)
    turned = sm.projection("octahedral").directions(24, rotation=None) @ r
    image = sm.sh.evaluate(c, turned)
    # The rounding that `project` and `rotate` state, 1e-12, ten times.
    assert (
        np.abs(
            sm.sh.project(image, "octahedral", order=5, texels="points") - sm.sh.rotate(c, r)
        ).max()
        < 1e-11
    )


@pytest.mark.parametrize(
    ("lobe", "options"),
    [
        ("cosine", {}),
        ("cone", {"half_angle": 25.0}),
        ("cone", {"half_angle": 180.0}),
        ("cone", {"half_angle": 0.01}),
        ("phong", {"exponent": 7.5}),
        ("vmf", {"kappa": 0.0}),
        ("vmf", {"kappa": 3.0}),
        ("vmf", {"kappa": 400.0}),
    ],
)
def test_lobes_multiply_degrees(lobe: str, options: dict[str, float]) -> None:
    from scipy.integrate import quad
    from scipy.special import eval_legendre

    parameter = next(iter(options.values()), 0.0)
    low = math.cos(math.radians(parameter)) if lobe == "cone" else -1.0

    def moment(k: int) -> float:
        def f(t: float) -> float:
            value = 1.0 if lobe == "cone" else reference.lobe(lobe, parameter, np.float64(t))
            return float(value) * eval_legendre(k, t)

        points = None if lobe == "cone" else [0.0, 0.9, 0.99]
        return quad(f, low, 1, points=points, epsabs=1e-13, epsrel=1e-11, limit=200)[0]

    want = np.array([moment(k) for k in range(13)])
    want *= 2 * math.pi if lobe == "cosine" else 1 / want[0]
    got = sm.sh.lobe(lobe, order=12, **options)  # type: ignore[arg-type]
    # A quotient of integrals that quad is asked for to 1e-11, of a few parts each.
    assert np.abs(got - want).max() < 1e-8


@pytest.mark.parametrize(
    ("lobe", "options", "text"),
    [
        ("cone", {}, "lobe 'cone' needs `half_angle`"),
        ("phong", {"exponent": None}, "lobe 'phong' needs `exponent`"),
        ("vmf", {"half_angle": 10}, "lobe 'vmf' takes `kappa`, got `half_angle`"),
        ("cone", {"half_angle": 10, "kappa": 1}, "lobe 'cone' takes `half_angle`, got `kappa`"),
        ("cone", {"half_angle": 0}, r"`half_angle` must be in \(0, 180\], got 0"),
        ("phong", {"exponent": -1}, "`exponent` must be at least 0 and finite, got -1"),
        ("con", {"half_angle": 10}, "unknown lobe 'con'.*'cone'"),
    ],
)
def test_a_lobe_has_one_parameter_and_needs_it(lobe, options, text) -> None:
    white = np.ones((8, 16))
    for call in (
        lambda: sm.sh.lobe(lobe, order=2, **options),
        lambda: sm.sh.convolve(np.ones(9), lobe=lobe, **options),
        lambda: sm.light.convolve(white, "latlong", "latlong", lobe=lobe, size=2, **options),
    ):
        with pytest.raises(ValueError, match=text):
            call()


@pytest.mark.parametrize("order", [2.0, 2.5, "2", True, None])
def test_an_order_is_a_whole_number(order) -> None:
    for call in (
        lambda: sm.sh.project(np.ones((8, 16)), "latlong", order=order),
        lambda: sm.sh.lobe("cosine", order=order),
    ):
        with pytest.raises(TypeError, match="`order` to be a whole number, got"):
            call()


def test_the_cosine_has_no_parameter() -> None:
    for call in (
        lambda: sm.sh.lobe("cosine", order=2, half_angle=10),
        lambda: sm.sh.convolve(np.ones(9), lobe="cosine", half_angle=10),
    ):
        with pytest.raises(ValueError, match="lobe 'cosine' takes no parameter, got `half_angle`"):
            call()
    with pytest.raises(ValueError, match="lobe 'cone' takes `half_angle`, got `halfangle`"):
        sm.sh.convolve(np.ones(9), lobe="cone", halfangle=3)
    with pytest.raises(TypeError, match="Expected `kappa` to be a number, got str"):
        sm.sh.lobe("vmf", order=2, kappa="x")


def test_convolution_is_the_lobe_of_an_image() -> None:
    """A smooth image under a cone: by harmonics and by summation (midpoint error of 96 rows)."""
    c = coefficients(4, 2)
    image = sm.sh.evaluate(c, sm.directions("latlong", 96))
    exact = sm.light.convolve(image, "latlong", "cube", lobe="vmf", kappa=20, size=6)
    fast = sm.sh.evaluate(sm.sh.convolve(c, lobe="vmf", kappa=20), sm.directions("cube", 6))
    # The midpoint rule's (π/96)²·κ/24 = 9e-4 of values up to 5.
    assert np.abs(exact - fast).max() < 5e-3
    with pytest.raises(ValueError, match=r"shape \(5,\), got \(4,\)"):
        sm.sh.convolve(c, lobe=[1, 1, 1, 1])


def test_windows_fade_and_stop_ringing() -> None:
    c = reference.ylm(8, np.array([[0.0, 0.0, 1.0]]))[0]
    d = sm.directions("latlong", 64)
    plain = sm.sh.evaluate(c, d).min()
    for window in ("hann", "lanczos", "gauss"):
        faded = sm.sh.window(c, window=window)  # type: ignore[arg-type]
        assert faded[0] == c[0] and np.all(np.abs(faded) <= np.abs(c))
        assert sm.sh.evaluate(faded, d).min() > 0.5 * plain
    assert np.count_nonzero(sm.sh.window(c, window="hann", width=2)[4:]) == 0
    with pytest.raises(ValueError, match="unknown window"):
        sm.sh.window(c, window="box")  # type: ignore[arg-type]


# --- conventions: the other programs' own formulas, literally


def gaussian_splatting(sh: np.ndarray, d: np.ndarray) -> np.ndarray:
    """The color of 3D Gaussian splatting, without its + 0.5."""
    x, y, z = np.moveaxis(d, -1, 0)
    c2 = (1.0925484305920792, -1.0925484305920792, 0.31539156525252005)
    c2 += (-1.0925484305920792, 0.5462742152960396)
    c3 = (-0.5900435899266435, 2.890611442640554, -0.4570457994644658, 0.3731763325901154)
    c3 += (-0.4570457994644658, 1.445305721320277, -0.5900435899266435)
    xx, yy, zz = x * x, y * y, z * z
    basis = [0.28209479177387814 + 0 * x]
    basis += [-0.4886025119029199 * y, 0.4886025119029199 * z, -0.4886025119029199 * x]
    quadratic = (x * y, y * z, 2 * zz - xx - yy, x * z, xx - yy)
    basis += [k * f for k, f in zip(c2, quadratic, strict=True)]
    cubic = (y * (3 * xx - yy), x * y * z, y * (4 * zz - xx - yy), z * (2 * zz - 3 * xx - 3 * yy))
    cubic += (x * (4 * zz - xx - yy), z * (xx - yy), x * (xx - 3 * yy))
    basis += [k * f for k, f in zip(c3, cubic, strict=True)]
    return np.stack(basis, -1) @ sh


def e3nn(sh: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Degrees 0 to 2 as e3nn defines them, normalization='component'."""
    x, y, z = np.moveaxis(d, -1, 0)
    r3, r5, r15 = math.sqrt(3), math.sqrt(5), math.sqrt(15)
    basis = [1 + 0 * x, r3 * x, r3 * y, r3 * z, r15 * x * z, r15 * x * y]
    basis += [r5 * (y * y - (x * x + z * z) / 2), r15 * y * z, r15 / 2 * (z * z - x * x)]
    return np.stack(basis, -1) @ sh


def threejs_irradiance(sh: np.ndarray, d: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(d, -1, 0)
    basis = [0.886227 + 0 * x, 2 * 0.511664 * y, 2 * 0.511664 * z, 2 * 0.511664 * x]
    basis += [2 * 0.429043 * x * y, 2 * 0.429043 * y * z, 0.743125 * z * z - 0.247708]
    basis += [2 * 0.429043 * x * z, 0.429043 * (x * x - y * y)]
    return np.stack(basis, -1) @ sh


def filament(sh: np.ndarray, d: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(d, -1, 0)
    basis = [1 + 0 * x, y, z, x, y * x, y * z, 3 * z * z - 1, z * x, x * x - y * y]
    return np.stack(basis, -1) @ sh


@pytest.mark.parametrize("channels", [(), (3,)])
def test_conventions_are_what_their_programs_evaluate(channels: tuple[int, ...]) -> None:
    rng = np.random.default_rng(5)
    d = random_directions(40, 6)
    nine, sixteen = rng.normal(size=(9, *channels)), rng.normal(size=(16, *channels))
    own = sm.sh.evaluate
    got = gaussian_splatting(sm.sh.convert(sixteen, dst="3dgs"), d)
    # Constants of 16 digits, 16 terms: some ε.
    assert np.allclose(got, own(sixteen, d), atol=1e-13)
    got = e3nn(sm.sh.convert(nine, dst="e3nn-component"), d)
    # Roots and products of nine terms: some ε.
    assert np.allclose(got, own(nine, d), atol=1e-13)
    got = threejs_irradiance(sm.sh.convert(nine, dst="threejs"), d)
    # three.js writes its constants with six digits: nine terms off by 1e-6 each.
    assert np.allclose(got, own(sm.sh.convolve(nine, lobe="cosine"), d), atol=2e-5)
    got = filament(sm.sh.convert(nine, dst="filament-irradiance"), d)
    # Nine terms: some ε.
    assert np.allclose(got, own(sm.sh.convolve(nine, lobe="cosine"), d) / math.pi, atol=1e-13)


@pytest.mark.parametrize("row", sm.sh.conventions(), ids=lambda row: row["name"])
@pytest.mark.parametrize("channels", [(), (3,)])
def test_conventions_come_back(row: dict[str, str], channels: tuple[int, ...]) -> None:
    order = 2 if row["name"].startswith("filament") else 6
    c = np.random.default_rng(1).normal(size=((order + 1) ** 2, *channels))
    there = sm.sh.convert(c, dst=row["name"])
    # Multiplied and divided by the same factors, turned and turned back: some ε.
    assert np.allclose(sm.sh.convert(there, src=row["name"]), c, atol=1e-12)
    assert row["note"] and row["source"]


@pytest.mark.parametrize(
    ("bad", "options", "message"),
    [
        (np.ones(5), {}, r"\(\(order \+ 1\)²,\).*got \(5,\)"),
        (np.ones((3, 3)), {"src": "pyshtools"}, r"\(2, N, N\)"),
        (np.ones(4), {"src": "healpy"}, r"N \(N \+ 1\)/2"),
        (np.ones(4), {"dst": "blender"}, "unknown convention 'blender'"),
        (np.ones(4), {"dst": "filament-irradiance"}, "needs order 2"),
    ],
)
def test_bad_coefficients(bad: np.ndarray, options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sm.sh.convert(bad, **options)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sm.sh.convert(np.full((2, 2, 2), 1j), src="pyshtools"), "real .* complex128"),
        (lambda: sm.sh.convert("abc", src="pyshtools"), "`coefficients` to be real numbers"),
        (lambda: sm.sh.convert("abc", src="healpy"), "`coefficients` to be numbers, got dtype <U3"),
        (lambda: sm.sh.convert(np.ones(4), src=3), "`src` to be a str, got int"),
        (lambda: sm.sh.convert(np.ones(4), dst=3), "`dst` to be a str, got int"),
        (lambda: sm.sh.window(np.ones(4), window=3), "`window` to be a str, got int"),
    ],
)
def test_what_is_of_another_type_is_named(call: Any, message: str) -> None:
    with pytest.raises(TypeError, match=message):
        call()


def test_masked_coefficients_are_missing() -> None:
    squares = np.ma.masked_array(np.ones((2, 2, 2)), np.ones((2, 2, 2), bool))
    assert np.isnan(sm.sh.convert(squares, src="pyshtools")).all()
    with pytest.raises(TypeError, match="`coefficients` has masked elements"):
        sm.sh.convert(np.ma.masked_array(np.ones(3, complex), [1, 0, 0]), src="healpy")


def test_order_0_of_means_is_the_light():
    # Fejér's weight of the ring beside a pole is 12 % above its solid angle, at any size.
    for name in ("latlong", "octahedral", "hammer"):
        image = np.zeros(sm.projection(name).shape(32))
        image[0, image.shape[1] // 2] = 1 if name != "hammer" else 0
        image[5, 20] = 3
        light = sm.light.integrate(image, name)
        got = sm.sh.project(image, name, order=4)[0]
        # Sums of doubles in two orders.
        assert abs(got * np.sqrt(4 * np.pi) / light - 1) < 1e-12
    with pytest.raises(ValueError, match="'means' or 'points', got 'mean'"):
        sm.sh.project(np.ones((8, 16)), "latlong", order=1, texels="mean")  # type: ignore[arg-type]


def test_means_and_points_differ_in_order_0_alone():
    rng = np.random.default_rng(3)
    for name in ("latlong", "octahedral"):
        p = sm.projection(name)
        c = rng.normal(size=(16,))
        image = shown(p, 32, c)
        means, points = (sm.sh.project(image, p, order=3, texels=x) for x in ("means", "points"))
        # The fit's stated 1e-12, with room for the largest coefficient.
        assert np.abs(means - points)[1:].max() < 1e-11
        # What degree 2 leaks: up to 0.92/H² of a coefficient, of three or so.
        assert np.abs(means - points)[0] < 3 * 0.92 / 32**2 * np.abs(c).max()


def test_printed_coefficients_of_the_grace_probe(data_folder):
    # Ramamoorthi and Hanrahan 2001, table 1, in the world of acos(+Dz); the scale is theirs.
    oiio = pytest.importorskip("OpenImageIO")
    probe = np.asarray(oiio.ImageBuf(str(data_folder / "grace_probe.hdr")).get_pixels("float"))
    printed = np.array(
        [
            (0.79, 0.44, 0.54),
            (0.39, 0.35, 0.60),
            (-0.34, -0.18, -0.27),
            (-0.29, -0.06, 0.01),
            (-0.11, -0.05, -0.12),
            (-0.26, -0.22, -0.47),
            (-0.16, -0.09, -0.15),
            (0.56, 0.21, 0.14),
            (0.21, -0.05, -0.30),
        ]
    )

    def off(convention: str) -> float:
        found = sm.sh.project(probe[..., :3], f"angular:{convention}", order=2)
        scaled = found * (found * printed).sum() / (found * found).sum()
        return float(np.abs(scaled - printed).max())

    # Half a digit of theirs, and 0.5 % of the largest for how they summed.
    assert off("openimageio") < 0.005 + 0.004
    assert off("debevec") > 0.5


def test_a_single_direction_of_a_single_channel():
    c = np.arange(1.0, 5.0)
    one = sm.sh.evaluate(c, [1, 2, 3])
    assert one.shape == () and one == sm.sh.evaluate(c, [[1, 2, 3]])[0]
    sky = np.random.default_rng(4).random((8, 16))
    one = sm.light.irradiance_at(sky, [0, 1, 0], "latlong")
    assert one.shape == () and one == sm.light.irradiance_at(sky, [[0, 1, 0]], "latlong")[0]
