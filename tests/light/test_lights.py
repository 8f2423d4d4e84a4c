"""Directional lights by two cuts, and the sun found, removed and put back."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import spheremap as sm
from conftest import DEFAULTS, LAYOUTS, each, random_directions, some_fast
from spheremap import _core

METHODS = ("median", "variance")
# Texels of float32 are off by 6e-8 each, and their sum by less.
SINGLE = 1e-6


def sky(p: sm.Projection, n: int, seed: int = 0) -> np.ndarray:
    """Noise over two decades, with texels below 0 as compression makes them."""
    rng = np.random.default_rng(seed)
    image = 10.0 ** rng.uniform(-1, 1, (*p.shape(n), 3))
    image.reshape(-1)[::50] *= -0.01
    return image


def integral(p: sm.Projection, image: np.ndarray) -> np.ndarray:
    weight = _core.texel_weights(p, image.shape[:-1])
    return np.tensordot(weight, image, weight.ndim)


@each(LAYOUTS)
@pytest.mark.parametrize("method", METHODS)
def test_energy_and_solid_angle_are_kept(case, method):
    p = case.make()
    image = np.nan_to_num(sky(p, 24))
    lights = sm.light.lights(image, p, count=37, method=method)
    assert len(lights) == 37
    # Sums of doubles keep twelve digits.
    np.testing.assert_allclose(lights.irradiance.sum(0), integral(p, image), rtol=1e-11)
    assert lights.solid_angle.sum() == pytest.approx(p.covered_solid_angle, rel=1e-9)
    assert (lights.solid_angle > 0).all()
    np.testing.assert_allclose(np.linalg.norm(lights.directions, axis=-1), 1, atol=1e-14)
    brightness = lights.irradiance @ [0.2126, 0.7152, 0.0722]
    assert brightness[0] >= brightness[-1]


def test_median_cut_halves_the_light():
    # On a sky without lamps, 2ⁿ lights carry nearly the same energy each.
    p = sm.projection("latlong")
    image = 1 + 0.5 * p.directions(256)[..., 1]
    lights = sm.light.lights(image, p, count=64)
    energy = lights.irradiance[:, 0]
    # Six cuts, each to within half a row of 256 of a region that is 16 or more of them long.
    assert np.abs(energy / energy.mean() - 1).max() < 0.2
    assert energy.sum() == pytest.approx(4 * np.pi, rel=1e-4)


def test_variance_gives_each_lamp_a_light_of_its_own():
    # The example of the method's paper: two lamps of different intensity. The median cut goes
    # through the brighter one.
    p = sm.projection("latlong")
    d = p.directions(128)
    # The dimmer one is a third as bright: then half the light lies inside the brighter one.
    lamps = np.array([[0.3, 0.1, -1.0], [-0.8, 0.2, -1.0]])
    lamps /= np.linalg.norm(lamps, axis=-1, keepdims=True)
    near = d @ lamps.T > np.cos(0.1)
    image = near @ [3.0, 1.0]
    two = sm.light.lights(image, p, count=2, method="variance")
    # Lamps are cut out of texels of 0.025 rad: a centroid is off by a fifth of one at most.
    np.testing.assert_allclose(two.directions, lamps, atol=5e-3)
    split = sm.light.lights(image, p, count=2, method="median")
    assert np.abs(split.directions - lamps).max() > 0.02


@pytest.mark.parametrize("method", METHODS)
def test_irradiance_converges(method):
    # What lights are for: the irradiance of a surface, against the sum over texels.
    p = sm.projection("octahedral")
    image = sky(p, 64)
    weight, d = _core.texel_weights(p, 64), p.directions(64)
    normals = random_directions(40, 1)
    exact = np.einsum("ijn,ij,ijc->nc", np.maximum(d @ normals.T, 0), weight, image)

    def error(n):
        lights = sm.light.lights(image, p, count=n, method=method)
        got = np.maximum(normals @ lights.directions.T, 0) @ lights.irradiance
        return np.abs(got / exact - 1).max()

    assert error(16) < 0.15
    assert error(256) < 0.01 < error(4)


@each(DEFAULTS)
def test_any_projection_gives_nearly_the_same_lights(case):
    p = case.make()
    covered = sm.projection("latlong").directions(128)
    bright = np.array([0.2, 0.4, 0.9])
    if not p.covers(bright):
        bright = -bright

    def light(d):
        d = np.nan_to_num(d)
        return np.where(
            p.covers(np.where(np.any(d, -1, keepdims=True), d, bright)),
            0.05 + (d @ bright > 0.97) * 20.0,
            0,
        )

    a = sm.light.lights(light(p.directions(160)), p, count=8, method="variance")
    b = sm.light.lights(light(covered), "latlong", count=8, method="variance")
    # The lamp: its energy and its place, within the texels on its edge. Into how many lights it is
    # split depends on where cuts fall.
    near, same = (lights.directions @ bright > 0.95 for lights in (a, b))
    lamp = a.irradiance[near].sum()
    # 14° of radius, texels of up to 3°: 29 of 68 on the edge, 0.3·√29 of 68 is 2 %; four of that.
    assert lamp == pytest.approx(b.irradiance[same].sum(), rel=0.1)
    assert near.any() and lamp > 0.6 * a.irradiance.sum()


def test_rotation_and_axes():
    p = sm.projection("cube", axes="-z -x +y")
    image = sky(p, 16)
    turn = sm.rotation(50, 60, 70)
    whole = sm.light.lights(image, p, count=1)
    turned = sm.light.lights(image, p, count=1, rotation=turn)
    # Sums of 1536 doubles that cancel in part, turned before or after.
    np.testing.assert_allclose(turned.directions, whole.directions @ turn.T, atol=1e-12)
    other = sm.light.lights(image, "cube", count=1, axes="-z -x +y")
    assert np.array_equal(other.directions, whole.directions)


def test_lights_are_a_sequence_of_light():
    lights = sm.light.lights(sky(sm.projection("latlong"), 16), "latlong", count=5)
    assert len(list(lights)) == 5
    first = lights[0]
    # A quotient times its divisor: two roundings.
    np.testing.assert_allclose(first.radiance * first.solid_angle, lights.irradiance[0])
    assert isinstance(lights[-1], sm.light.Light) and isinstance(lights, sm.light.Lights)
    with pytest.raises(IndexError):
        lights[5]
    with pytest.raises(dataclasses.FrozenInstanceError):
        first.solid_angle = 1.0
    some = lights[-2:]
    assert isinstance(some, sm.light.Lights) and len(some) == 2 and len(lights[9:]) == 0
    assert np.array_equal(some[1].direction, lights[4].direction)


def test_few_places_and_no_light():
    image = np.zeros((16, 32, 3))
    one = sm.light.lights(image, "latlong", count=10)
    assert len(one) == 1 and not one.irradiance.any()
    image[3, 4] = 5
    image[12, 20] = 1
    for method in METHODS:
        two = sm.light.lights(image, "latlong", count=10, method=method)
        assert len(two) == 2
        # The texel's own direction, made unit once more.
        np.testing.assert_allclose(two.directions[0], sm.directions("latlong", 16)[3, 4])
    single = sm.light.lights(np.full((1, 1), 2.0), "octahedral", count=3)
    # One product.
    assert single.irradiance.sum() == pytest.approx(8 * np.pi, rel=1e-9)


def test_bad_input():
    image = np.ones((4, 8, 3))
    for bad in (0, -1):
        with pytest.raises(ValueError, match=f"`count` to be at least 1, got {bad}"):
            sm.light.lights(image, "latlong", count=bad)
    for bad in (1.5, "two", None, [1, 2], True):
        with pytest.raises(TypeError, match="`count` to be a whole number, got"):
            sm.light.lights(image, "latlong", count=bad)
    # There are as many as places that the light comes from.
    most = len(sm.light.lights(image, "latlong", count=32))
    assert len(sm.light.lights(image, "latlong", count=10**30)) == most
    with pytest.raises(ValueError, match=r"unknown method 'mean'; there are 'median' and"):
        sm.light.lights(image, "latlong", count=2, method="mean")
    image[1, 1, 0] = np.nan
    for verb in (sm.light.sun, sm.light.energy, sm.light.remove_sun):
        with pytest.raises(ValueError, match=r"1 NaN or infinite value, at \(1, 1, 0\)"):
            verb(image, "latlong")
    with pytest.raises(ValueError, match="1 NaN or infinite value"):
        sm.light.lights(image, "latlong", count=2)
    assert np.isfinite(sm.light.lights(image, "latlong", count=2, skipna=True).irradiance).all()
    with pytest.raises(ValueError, match=r"shape \(6, N, N\)"):
        sm.light.lights(image, "cube", count=2)
    with pytest.raises(TypeError, match="dtype"):
        sm.light.sun(image.astype(complex), "latlong")


# --- the sun


def disc(p: sm.Projection, n: int, d: np.ndarray, radius: float, light=(900.0, 800.0, 600.0)):
    """A sky of 0.2 with a disc of light, sampled at texel centers."""
    inside = np.nan_to_num(p.directions(n)) @ d > np.cos(radius)
    return np.where(inside[..., None], light, 0.2)


@each(DEFAULTS, slow=[c for c in DEFAULTS if "thin_prism" in c.name])
def test_a_wide_sun(case):
    # 3° of radius are many texels. Sampled at centers, its area is known to a texel of its edge.
    p = case.make()
    n = 200
    d = np.array([0.3, 0.2, 0.8])
    d = d / np.linalg.norm(d) * (1 if p.covers(d) else -1)
    image = disc(p, n, d, np.radians(3.0))
    found = sm.light.sun(image, p)
    assert found is not None
    assert found.direction @ d > np.cos(np.radians(0.3))
    # 17 of some 22 texels on the edge: 0.3·√17 of 22 is 6 % of the area, half of it of this.
    assert found.angular_diameter == pytest.approx(6.0, rel=0.1)
    # Medians of equal numbers are exact; the radiance is a quotient of sums of doubles.
    np.testing.assert_allclose(found.surround, 0.2)
    np.testing.assert_allclose(found.radiance, np.subtract([900, 800, 600], 0.2), rtol=1e-3)
    dull, same = sm.light.remove_sun(image, p)
    # The same sums once more.
    assert same.irradiance == pytest.approx(found.irradiance)
    held = _core.texel_weights(p, n) > 0
    # The surround's median, which is exact.
    np.testing.assert_allclose(dull[held], 0.2)
    assert sm.light.sun(dull, p) is None
    kept = integral(p, np.where(held[..., None], image, 0))
    # Some 10⁵ doubles in other orders; what is taken out cancels to 1e-11.
    np.testing.assert_allclose(integral(p, dull) + found.irradiance, kept, rtol=1e-9)
    back = sm.light.add_sun(dull, found, p)
    # The disc is scaled to the sun's irradiance: sums of doubles.
    np.testing.assert_allclose(integral(p, back), kept, rtol=1e-6)
    again = sm.light.sun(back, p)
    assert again.direction @ found.direction > 1 - 1e-5
    # The disc put back has an edge one texel wide, a sixth of its diameter.
    assert again.angular_diameter == pytest.approx(found.angular_diameter, rel=0.15)


@each(DEFAULTS)
def test_a_sun_in_one_texel(case):
    p = case.make()
    d = p.directions(48)
    weight = _core.texel_weights(p, 48)
    middle = np.argwhere(weight > 0)[int(np.count_nonzero(weight) * 0.37)]
    at = tuple(middle)
    image = np.full((*p.shape(48), 3), 0.1, np.float32)
    image[at] = [6e4, 5e4, 4e4]
    found = sm.light.sun(image, p)
    # The texel's own direction, made unit once more.
    np.testing.assert_allclose(found.direction, d[at], atol=1e-12)
    # Even float32 around it cancels to the bit: sums of doubles.
    assert found.solid_angle == pytest.approx(weight[at], rel=1e-6)
    want = (image[at].astype(float) - image.min()) * weight[at]
    # The same cancellation and one product.
    np.testing.assert_allclose(found.irradiance, want, rtol=1e-6)
    dull, _ = sm.light.remove_sun(image, p)
    back = sm.light.add_sun(dull, found, p)
    assert back.dtype == np.float32
    np.testing.assert_allclose(integral(p, np.nan_to_num(back)), integral(p, image), rtol=SINGLE)


@each(DEFAULTS)
@some_fast("degrees", [0.001, 0.53, 12.0], fast=(0.53,))
def test_a_sun_of_any_size_is_put_back_whole(case, degrees):
    # Narrower than a texel and wider than many, anywhere: the energy is that of the sun.
    p = case.make()
    rng = np.random.default_rng(3)
    solid_angle = 4 * np.pi * np.sin(np.radians(degrees) / 4) ** 2
    dark = np.zeros((*p.shape(40), 2), np.float32)
    directions = random_directions(400, 4)
    for toward in directions[p.covers(directions)][:6]:
        irradiance = rng.uniform(1, 2, 2)
        sun = sm.light.Sun(toward, solid_angle, irradiance, np.zeros(2), 0.0)
        lit = sm.light.add_sun(dark, sun, p)
        np.testing.assert_allclose(integral(p, lit.astype(float)), irradiance, rtol=SINGLE)
        mean = integral(p, lit[..., :1] * np.nan_to_num(p.directions(40)))
        texel = np.sqrt(_core.texel_weights(p, 40).max())
        away = np.arccos(min(1.0, mean @ toward / np.linalg.norm(mean)))
        assert away < 2 * texel


def test_no_sun():
    p = sm.projection("latlong")
    assert sm.light.sun(np.ones((16, 32, 3)), p) is None
    assert sm.light.sun(np.zeros((16, 32)), p) is None
    assert sm.light.sun(1.5 + p.directions(32)[..., 1], p) is None
    # Bright, but no disc: a whole hemisphere.
    assert sm.light.sun(np.where(p.directions(64)[..., 1] > 0, 100.0, 0.1), p) is None
    # A bright texel among negative ones, as compression makes them: noise.
    noise = np.ones((32, 64))
    noise[10:13, 20:23] = -50
    noise[11, 21] = 60
    assert sm.light.sun(noise, p) is None
    image = np.ones((8, 16), np.float32)
    same, none = sm.light.remove_sun(image, p)
    assert none is None and np.array_equal(same, image) and same is not image


def test_what_lies_around_a_disk_stays_as_it_was():
    image = np.full((32, 32, 4), 0.5)
    image[12, 10, :3] = 1000
    for name in ("angular", "sphere", "mollweide"):
        p = sm.projection(name, layout=None)
        given = image if name != "mollweide" else np.repeat(image, 2, axis=1)
        outside = np.isnan(p.directions(given.shape[:2])[..., 0])
        dull, sun = sm.light.remove_sun(given, p)
        assert sun is not None and np.all(dull[outside] == 0.5)
        assert np.all(sm.light.add_sun(dull, sun, p)[outside] == 0.5)
        assert np.all(sm.light.add_sun(dull, None, p) == dull)


def test_sun_with_rotation_and_layouts():
    turn = sm.rotation(30, 20, 10)
    d = np.array([0.0, 0.6, -0.8])
    p = sm.projection("cube", layout="cross")
    image = disc(p, 40, d, np.radians(4))
    found = sm.light.sun(image, p, rotation=turn)
    assert found.direction @ (turn @ d) > np.cos(np.radians(0.7))
    dull, _ = sm.light.remove_sun(image, p, rotation=turn)
    back = sm.light.add_sun(dull, found, p, rotation=turn)
    assert sm.light.sun(back, p).direction @ d > np.cos(np.radians(1.0))


@pytest.mark.parametrize("solid_angle", [-1e-4, np.nan, np.inf])
def test_a_sun_has_a_solid_angle(solid_angle):
    sun = sm.light.Sun(np.array([0.0, 1.0, 0.0]), solid_angle, np.ones(1), np.zeros(1), 0.0)
    with pytest.raises(ValueError, match=r"`sun\.solid_angle` to be at least 0 and finite, got"):
        sm.light.add_sun(np.zeros((8, 16)), sun, "latlong")


def test_a_sun_without_extent_has_no_radiance():
    point = sm.light.Sun(np.array([0.0, 1.0, 0.0]), 0.0, np.ones(3), np.zeros(3), 0.1)
    assert not point.radiance.any()


def test_sun_that_does_not_fit():
    sun = sm.light.Sun(np.array([0.0, 0.0, -1.0]), 1e-4, np.ones(3), np.zeros(3), 0.0)
    with pytest.raises(ValueError, match="does not cover the sun"):
        sm.light.add_sun(np.zeros((8, 8, 3)), sun, "matcap")
    with pytest.raises(ValueError, match="Expected a sun of 1 channels, got 3"):
        sm.light.add_sun(np.zeros((8, 16)), sun, "latlong")


def test_real_suns(data_folder):
    oiio = pytest.importorskip("OpenImageIO")
    for name in ("venice", "park", "studio", "night"):
        pixels = oiio.ImageBuf(str(data_folder / f"{name}.exr")).get_pixels("float")
        image = np.asarray(pixels)[..., :3]
        p = sm.projection("latlong")
        for method in METHODS:
            lights = sm.light.lights(image, p, count=32, method=method)
            want = integral(p, image.astype(float))
            # Sums of doubles in other orders, some of them negative.
            np.testing.assert_allclose(lights.irradiance.sum(0), want, rtol=1e-6)
        dull, sun = sm.light.remove_sun(image, p)
        if sun is not None:
            back = sm.light.add_sun(dull, sun, p)
            np.testing.assert_allclose(integral(p, back.astype(float)), want, rtol=SINGLE)


def test_a_moat_takes_nothing_from_a_sun():
    # What is darker than the surround had a negative weight: 19.4° off, and less than no red.
    sky = np.full((400, 800, 3), [2.4, 0.6, 0.1])
    sky[197:204, 400:409] = 0.4
    sky[200, 400:409] = 3
    sky[200, 400] = 15
    sun = sm.light.sun(sky, "latlong")
    assert sun is not None and sun.irradiance.min() >= 0
    peak = sm.directions("latlong", 400)[200, 400]
    assert np.arccos(sun.direction @ peak) <= sun.reach
    dull, taken = sm.light.remove_sun(sky, "latlong")
    assert (dull <= sky).all()
    lost = sm.light.integrate(sky, "latlong") - sm.light.integrate(dull, "latlong")
    # Differences of sums of 320,000 doubles.
    np.testing.assert_allclose(lost, taken.irradiance, rtol=1e-9, atol=0)


def test_a_suns_direction_may_have_any_length() -> None:
    def lit(direction: list[float]) -> np.ndarray:
        sun = sm.light.Sun(np.array(direction), 0.5, np.array([1.5]), np.zeros(1), 0.01)
        return sm.light.add_sun(np.zeros((32, 64)), sun, "latlong")

    unit = np.array([0.1, 0.7, 0.2]) / np.linalg.norm([0.1, 0.7, 0.2])
    for length in (3.0, 1e-300, 1e300):
        # A rounding of the direction, which the disk's radiance follows.
        np.testing.assert_allclose(lit((length * unit).tolist()), lit(unit.tolist()), rtol=1e-12)
    for none in ([0.0, 0.0, 0.0], [np.nan, 0.0, 1.0], [np.inf, 0.0, 0.0]):
        with pytest.raises(ValueError, match=r"`sun\.direction` to be finite and not zero"):
            lit(none)
