"""Integrals, irradiance and lobes: against plain sums, closed forms, and bad input."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import (
    DEFAULTS,
    LAYOUTS,
    Case,
    assert_same_bits,
    assert_same_bits_everywhere,
    each,
    random_directions,
)
from reference import light as reference
from reference.atlas import LENSES

WHOLE = [c for c in LAYOUTS if c.make().coverage == "sphere"]
LOBES: list[tuple[str, float]] = [("cone", 40.0), ("phong", 12.5), ("phong", 0.0), ("vmf", 30.0)]
OPTION = {"cone": "half_angle", "phong": "exponent", "vmf": "kappa"}


def texels(p: sm.Projection, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Give the directions and weights of the texels that count."""
    w = sm.light.weights(p, shape).ravel()
    return p.directions(shape).reshape(-1, 3)[w > 0], w[w > 0]


def picture(p: sm.Projection, size: int, seed: int = 3) -> np.ndarray:
    shape = p.shape(size)
    return np.random.default_rng(seed).random((*shape, 3)).astype(np.float32)


@each(LAYOUTS)
@pytest.mark.parametrize("size", [2, 17, 40])
def test_a_constant_integrates_to_the_coverage(case: Case, size: int) -> None:
    p = case.make()
    shape = p.shape(size)
    total = p.covered_solid_angle
    # Texels of lens models have no closed form, and are good to 1e-10.
    limit = 1e-10 * total if case.name in LENSES else 1e-12
    assert abs(float(sm.light.integrate(np.ones(shape), p)) - total) < limit
    w = sm.light.weights(p, shape)
    assert abs(w.sum() - total) < limit and w.min() >= 0
    assert not np.isnan(p.directions(shape)[w > 0]).any()
    # Rim texels alone differ from the plain solid angle.
    same = w == sm.solid_angle(p, shape)
    assert same.all() or np.isnan(p.directions(shape)).any()
    assert same.mean() > 0.5 or size == 2


@each(DEFAULTS)
def test_what_lies_outside_never_leaks_in(case: Case) -> None:
    p = case.make()
    image = picture(p, 33)
    printed = np.where(np.isnan(p.directions(p.shape(33))), np.float32(1e6), image)
    assert_same_bits(sm.light.integrate(image, p), sm.light.integrate(printed, p))
    a, b = (sm.light.irradiance(x, p, "latlong", size=4) for x in (image, printed))
    assert_same_bits(a, b)
    assert_same_bits(sm.sh.project(image, p, order=2), sm.sh.project(printed, p, order=2))


@each(WHOLE)
def test_first_moments_are_those_of_the_sphere(case: Case) -> None:
    p = case.make()
    d = np.nan_to_num(p.directions(64))
    # ∫ (ω + 1) dω and ∫ ω (y + 1) dω: what is left is the midpoint rule's error.
    assert np.abs(sm.light.integrate(d + 1, p) - 4 * math.pi).max() < 5e-3
    toward = sm.light.average_direction(d[..., 1] + 1, p)
    # The same error over 4π, 4e-4, and a quotient of two such sums.
    assert np.abs(toward - [0, 1 / 3, 0]).max() < 2e-3
    assert np.allclose(sm.light.mean(d + 1, p), 1, atol=5e-4)


@each(DEFAULTS)
def test_irradiance_is_the_plain_sum(case: Case) -> None:
    p = case.make()
    image = picture(p, 40)
    d, w = texels(p, p.shape(40))
    values = image.reshape(-1, 3)[sm.light.weights(p, 40).ravel() > 0].astype(float)
    n = random_directions(50, 1)
    got = sm.light.irradiance_at(image.astype(float), 3 * n, p)
    want = (np.maximum(n @ d.T, 0) * w) @ values
    if p.coverage == "sphere":
        want *= math.pi / (np.maximum(n @ d.T, 0) @ w)[:, None]
    # Sums of a few thousand f64 numbers.
    assert np.abs(got - want).max() < 1e-12


@each(WHOLE)
@pytest.mark.parametrize(("lobe", "parameter"), LOBES)
def test_lobes_are_the_plain_sum(case: Case, lobe: str, parameter: float) -> None:
    p = case.make()
    # No texel of 35 rows is square to one of these directions, where rounding decides.
    image = picture(p, 35).astype(float)
    d, w = texels(p, p.shape(35))
    values = image.reshape(-1, 3)[sm.light.weights(p, 35).ravel() > 0]
    n = sm.directions("latlong", 4).reshape(-1, 3)
    got = sm.light.convolve(image, p, "latlong", lobe=lobe, size=4, **{OPTION[lobe]: parameter})  # type: ignore[arg-type]
    want = reference.under_lobe(values, w, d, n, lobe, parameter)
    # Sums of a few thousand doubles, and a quotient of two.
    assert np.abs(got.reshape(-1, 3) - want).max() < 1e-12


@each(WHOLE)
def test_a_constant_gives_pi_and_lobes_give_it_back(case: Case) -> None:
    white = np.full((*case.make().shape(9), 2), 0.25)
    for n in (1, 5):
        # Normalized by the sum of the same weights: doubles.
        assert (
            np.abs(
                sm.light.irradiance(white, case.make(), "latlong", size=n) / math.pi - 0.25
            ).max()
            < 1e-12
        )
    for lobe, parameter in LOBES:
        got = sm.light.convolve(
            white, case.make(), "cube", lobe=lobe, size=2, **{OPTION[lobe]: parameter}
        )  # type: ignore[arg-type]
        # Normalized by the sum of the same weights: doubles.
        assert np.abs(got - 0.25).max() < 1e-12


def test_a_narrow_lobe_is_a_lookup() -> None:
    image = picture(sm.projection("latlong"), 16)
    got = sm.light.convolve(image, "latlong", "cube", lobe="cone", half_angle=1e-3, size=5)
    want = sm.sample(image, sm.directions("cube", 5), "latlong")
    # Narrower than a texel, a cone is a lookup; float32 texels below 1 round by 6e-8.
    assert np.allclose(got, want, atol=1e-6)


def test_half_a_sphere_of_light_is_the_closed_form() -> None:
    """A hemisphere about +y gives π (1 + n·y)/2; the discretization is that of its edge."""
    sky = (sm.directions("latlong", 256)[..., 1] > 0).astype(np.float64)
    n = random_directions(200, 5)
    # The midpoint rule's (π/256)² is 1.5e-4; the edge lies between two rows and adds nothing.
    assert (
        np.abs(sm.light.irradiance_at(sky, n, "latlong") - math.pi * (1 + n[:, 1]) / 2).max() < 1e-4
    )


def test_a_partial_coverage_is_black_beyond() -> None:
    """A full hemisphere image about +z lights +z with π and -z with nothing.

    MatCap's rim texels see much sphere, and count at the directions of their neighbors.
    """
    for name, bound in (("hemioctahedral", 1e-3), ("matcap", 0.06)):
        white = np.ones(sm.projection(name).shape(64))
        up, down = sm.light.irradiance_at(white, [[0, 0, 1], [0, 0, -1]], name)
        assert abs(up - math.pi) < bound and down == 0


@pytest.mark.parametrize(("order", "bound"), [(2, 0.094), (4, 0.059), (8, 0.034), (16, 0.0183)])
def test_harmonics_keep_their_bound(order: int, bound: float) -> None:
    """|E - E_sh| ≤ Φ max |K - K_order|: the bound itself by Legendre series, then a lone sun."""
    t = np.linspace(-1, 1, 20001)
    factors = sm.sh.lobe("cosine", order=order)
    series = [(2 * k + 1) / (4 * math.pi) * a for k, a in enumerate(factors)]
    assert np.abs(np.polynomial.legendre.legval(t, series) - np.maximum(t, 0)).max() <= bound
    sun = np.zeros((64, 128))
    sun[20, 31] = 1000.0
    exact = sm.light.irradiance(sun, "latlong", "octahedral", size=24)
    fast = sm.light.irradiance(sun, "latlong", "octahedral", size=24, method="sh", order=order)
    # The exact one is normalized: it differs from the plain sum by 1e-3 at this size.
    assert np.abs(exact - fast).max() < (bound + 2e-3) * float(sm.light.integrate(sun, "latlong"))


def test_real_light(data_folder: Any) -> None:
    """Both ways agree on environments and on a probe, and suns do not break the sum."""
    pytest.importorskip("OpenImageIO")
    from spheremap import io

    for name, p in (
        ("venice.exr", "latlong"),
        ("night.exr", "latlong"),
        ("grace_probe.hdr", "angular"),
    ):
        image = io.read(data_folder / name)[..., :3]
        exact = sm.light.irradiance(image, p, "latlong", size=8)
        fast = sm.light.irradiance(image, p, "latlong", size=8, method="sh", order=8)
        flux = sm.light.integrate(np.abs(image), p)
        assert np.all(np.abs(exact - fast).max((0, 1)) < 0.034 * flux), name


def test_neither_threads_nor_levels_change_a_bit() -> None:
    cube = sm.projection("cube")
    image = picture(cube, 64)

    def all_of_it() -> list[np.ndarray]:
        sums = [
            sm.light.integrate(image, cube),
            sm.light.irradiance(image, cube, "latlong", size=16),
        ]
        sums += [sm.sh.project(image, cube, order=6)]
        lat = picture(sm.projection("latlong"), 65)
        sums += [sm.sh.project(lat, "latlong", order=9)]
        for lobe, parameter in LOBES:
            option: Any = {OPTION[lobe]: parameter}
            sums.append(sm.light.convolve(image, cube, "latlong", lobe=lobe, size=4, **option))  # type: ignore[arg-type]
        for kind in ("ggx", "charlie"):
            sums.append(
                sm.light.prefilter(
                    image,
                    cube,
                    "latlong",
                    roughness=0.4,
                    size=8,
                    samples=64,
                    method="sampled",
                    distribution=kind,
                )
            )  # type: ignore[arg-type]
            sums.append(sm.light.dfg(8, distribution=kind))  # type: ignore[arg-type]
        return sums

    assert_same_bits_everywhere(all_of_it)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
def test_dtypes(dtype: str) -> None:
    image = np.full((8, 16, 1), 3, dtype)
    result = sm.light.irradiance(image, "latlong", "latlong", size=2)
    assert result.dtype == (np.float32 if dtype in ("float16", "float32") else np.float64)
    # float32 for float16 and float32 images: 6e-8, below `allclose`'s own 1e-5.
    assert result.shape == (2, 4, 1) and np.allclose(result, 3 * math.pi)
    assert sm.light.integrate(image, "latlong").dtype == np.float64
    assert sm.light.integrate(image[..., 0], "latlong").shape == ()


def test_strided_and_read_only_images() -> None:
    image = picture(sm.projection("latlong"), 8)
    want = sm.light.integrate(image, "latlong")
    view = np.asfortranarray(image)[:, :, :]
    view.flags.writeable = False
    assert_same_bits(sm.light.integrate(view, "latlong"), want)
    assert_same_bits(sm.light.integrate(np.repeat(image, 2, -1)[..., ::2], "latlong"), want)


def test_bad_texels_are_counted_unless_skipped() -> None:
    image = np.ones((8, 16, 3))
    image[2, 3, 1] = np.nan
    image[0, 0, 0] = -5.0
    for call in (
        lambda **k: sm.light.integrate(image, "latlong", **k),
        lambda **k: sm.light.mean(image, "latlong", **k),
        lambda **k: sm.light.irradiance(image, "latlong", "cube", size=2, **k),
        lambda **k: sm.sh.project(image, "latlong", order=1, **k),
        lambda **k: sm.light.prefilter(image, "latlong", "cube", roughness=0.5, size=2, **k),
        lambda **k: (
            sm.light.bake(image, "latlong", size=2, levels=1, diffuse_size=2, samples=4, **k).sh
        ),
    ):
        with pytest.raises(ValueError, match=r"1 NaN or infinite value, at \(2, 3, 1\)"):
            call()
        assert np.isfinite(call(skipna=True)).all()
    with pytest.raises(ValueError, match=r"counts them as 0\.$"):
        sm.light.integrate(image, "latlong")
    with pytest.raises(ValueError, match=r"`skipna=True` leaves them out\.$"):
        sm.light.mean(image, "latlong")
    image[0, 0, 0] = 1.0
    # The mean leaves the texel out; the integral counts it as 0.
    assert np.allclose(sm.light.mean(image, "latlong", skipna=True), 1, atol=1e-12)
    assert sm.light.integrate(image, "latlong", skipna=True)[1] < 4 * math.pi - 1e-3


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("image", lambda x: sm.light.ws_psnr(x, np.nan_to_num(x), "latlong")),
        ("reference", lambda x: sm.light.ws_psnr(np.nan_to_num(x), x, "latlong")),
        ("image", lambda x: sm.light.bake_matcap(x, material="diffuse", size=4)),
        ("image", lambda x: sm.light.bake_matcap(x, material="rough", size=4, pose=np.eye(3))),
    ],
)
def test_what_has_no_skipna_does_not_recommend_it(name, call) -> None:
    image = np.ones((8, 16, 3), np.float32)
    image[2, 3, 1] = np.nan
    with pytest.raises(ValueError) as caught:
        call(image)
    assert str(caught.value) == f"`{name}` has 1 NaN or infinite value, at (2, 3, 1)."


@pytest.mark.parametrize("angles", [(0, 45, 0), (30, 60, 0), (13, 27, 5)])
def test_a_matcap_in_any_pose_has_the_light_of_every_texel(angles) -> None:
    pose = sm.rotation(*angles)
    d, w = sm.directions("latlong", 32), sm.solid_angle("latlong", 32)
    normals = sm.directions("matcap", 12)
    held = ~np.isnan(normals[..., 0])
    for texel in ((0, 5), (1, 40), (16, 20), (27, 11)):
        sun = np.zeros((32, 64))
        sun[texel] = 1e4
        got = sm.light.bake_matcap(sun, material="diffuse", size=12, pose=pose)
        want = np.maximum(normals[held] @ pose.T @ d[texel], 0) * 1e4 * w[texel] / math.pi
        # A texel of 5.6° stands for its center: what it covers is half of that off, squared.
        assert np.abs(got[held] - want).max() <= 1.2e-3 * want.max()


# Of lone suns, the worst case: a level leaves room to where in a texel a sun may be, a hundredth of
# α over a texel at 10 of them, here at 16 and more.
SUMMED = 0.02


@pytest.mark.parametrize("distribution", ["ggx", "charlie"])
@pytest.mark.parametrize(("roughness", "size"), [(1.0, 8), (0.8, 16), (0.6, 16), (0.5, 16)])
def test_wide_lobes_of_a_chain_are_those_of_the_sum(distribution, roughness, size) -> None:
    rng = np.random.default_rng(5)
    sky = np.zeros((64, 128, 8))
    sky.reshape(-1, 8)[rng.choice(64 * 128, 8, replace=False), np.arange(8)] = 1e4
    options = {"roughness": roughness, "size": size, "distribution": distribution}
    exact, found = (
        sm.light.prefilter(sky, "latlong", "cube", method=method, **options)
        for method in ("exact", "sampled")
    )
    off = np.sqrt(((found - exact) ** 2).mean((0, 1, 2)) / (exact**2).mean((0, 1, 2)))
    assert off.max() < SUMMED
    kept, light = (sm.light.integrate(x, "cube") for x in (found, exact))
    assert np.abs(kept / light - 1).max() < SUMMED


@pytest.mark.parametrize("distribution", ["ggx", "charlie"])
@pytest.mark.parametrize("roughness", [0.15, 0.2, 0.3, 0.4])
def test_narrow_lobes_of_a_chain_keep_the_light(distribution, roughness) -> None:
    rng = np.random.default_rng(6)
    sky = np.zeros((64, 128, 8))
    sky.reshape(-1, 8)[rng.choice(64 * 128, 8, replace=False), np.arange(8)] = 1e4
    found = sm.light.prefilter(
        sky,
        "latlong",
        "cube",
        roughness=roughness,
        size=32,
        distribution=distribution,
        method="sampled",
    )
    kept = sm.light.integrate(found, "cube") / sm.light.integrate(sky, "latlong")
    # The bound that docs/decisions/light.md states.
    assert np.abs(kept - 1).max() < 0.05


def test_two_images_have_one_largest_value() -> None:
    light = np.full((8, 16), 0.5, np.float32)
    codes = np.full((8, 16), 128, np.uint8)
    for a, b in ((light, codes), (codes, light), (codes, codes.astype(np.uint16))):
        with pytest.raises(TypeError, match=r"of one dtype, or `peak`.*got (float32|uint8) and"):
            sm.light.ws_psnr(a, b, "latlong")
    # Floats of any width are to 1.
    assert sm.light.ws_psnr(light, light.astype(np.float64), "latlong") == math.inf
    assert sm.light.ws_psnr(codes, 256 * light, "latlong", peak=255) == math.inf


def test_errors_name_what_was_expected() -> None:
    white = np.ones((8, 16))
    with pytest.raises(ValueError, match=r"'cube' .*shape .*\(F, N, N\).*got \(8, 16\)"):
        sm.light.integrate(white, "cube")
    with pytest.raises(ValueError, match="did you mean 'octahedral'"):
        sm.light.integrate(white, "octahedrel")
    with pytest.raises(TypeError, match="complex128"):
        sm.light.integrate(white.astype(complex), "latlong")
    with pytest.raises(ValueError, match="`order` to be a whole number from 0 to 64, got -4"):
        sm.light.irradiance(white, "latlong", "cube", size=2, order=-4)
    with pytest.raises(ValueError, match="'exact' or 'sh'"):
        sm.light.irradiance(white, "latlong", "cube", method="magic")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="needs `kappa`"):
        sm.light.convolve(white, "latlong", "cube", lobe="vmf")
    with pytest.raises(ValueError, match="takes `kappa`, got `exponent`"):
        sm.light.convolve(white, "latlong", "cube", lobe="vmf", kappa=1, exponent=2)
    with pytest.raises(ValueError, match=r"`half_angle` must be in \(0, 180\]"):
        sm.light.convolve(white, "latlong", "cube", lobe="cone", half_angle=np.nan)
    with pytest.raises(ValueError, match=r"shape \(\.\.\., 3\), got \(4, 2\)"):
        sm.light.irradiance_at(white, np.ones((4, 2)), "latlong")
    assert np.isnan(
        sm.light.irradiance_at(white, [[0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 0]], "latlong")
    ).all()
    assert sm.light.irradiance_at(white, np.ones((0, 3)), "latlong").shape == (0,)


def test_ws_psnr() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.random((2, 16, 32, 3))
    error = (sm.light.weights("latlong", 16)[..., None] * (a - b) ** 2).sum() / (12 * math.pi)
    # The mean of 1536 doubles.
    assert math.isclose(sm.light.ws_psnr(a, b, "latlong"), -10 * math.log10(error), rel_tol=1e-12)
    assert sm.light.ws_psnr(a, a, "latlong") == math.inf
    gray = np.full((8, 16), 100, np.uint8)
    # A mean of ones; `isclose`'s own 1e-9 is far above.
    assert math.isclose(sm.light.ws_psnr(gray, gray + np.uint8(1), "latlong"), 20 * math.log10(255))
    with pytest.raises(ValueError, match="one shape"):
        sm.light.ws_psnr(a, a[..., 0], "latlong")
