"""Rough reflections, their table, and the files that renderers load."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import spheremap as sm
from conftest import LAYOUTS, Case, each
from reference import light as reference
from spheremap import cli


def environment(size: int = 64) -> np.ndarray:
    """Give a sky with a small sun, three channels."""
    d = sm.directions("latlong", size)
    sky = 1 + np.maximum(d[..., 1], 0) + 0.3 * np.sin(6 * d[..., 0]) * np.cos(5 * d[..., 2])
    image = np.stack([sky, 0.5 * sky, sky**2], -1)
    image[size // 4, size // 3] += 100
    return image.astype(np.float32)


@pytest.mark.parametrize(("kind", "roughness"), [("ggx", 0.4), ("ggx", 1.0), ("charlie", 0.6)])
def test_the_exact_sum_is_the_plain_one(kind: Any, roughness: float) -> None:
    image = environment(32)
    got = sm.light.prefilter(
        image, "latlong", "cube", roughness=roughness, size=3, method="exact", distribution=kind
    )
    d, w = sm.directions("latlong", 32).reshape(-1, 3), sm.light.weights("latlong", 32).ravel()
    n = sm.directions("cube", 3).reshape(-1, 3)
    values = image.reshape(-1, 3).astype(float)
    want = reference.under_lobe(values, w, d, n, kind, roughness**2)
    # The result is float32, which rounds by 6e-8; both sums are of doubles.
    assert np.allclose(got.reshape(-1, 3), want, rtol=1e-6)


@pytest.mark.parametrize(
    ("kind", "roughness", "bound"),
    # Near the sun one lookup in a thousand carries most of the light: relative to the mean.
    [("ggx", 0.5, 0.015), ("ggx", 0.8, 0.006), ("ggx", 1.0, 0.006), ("charlie", 0.7, 0.02)],
)
def test_samples_come_near_the_exact_sum(kind: Any, roughness: float, bound: float) -> None:
    image = environment(64)
    both = [
        sm.light.prefilter(
            image,
            "latlong",
            "octahedral",
            roughness=roughness,
            size=16,
            method=m,
            distribution=kind,
        )
        for m in ("exact", "sampled")
    ]
    rms = float(np.sqrt(np.mean((both[0] - both[1]) ** 2)))
    assert rms < bound * float(both[0].mean())


@each([c for c in LAYOUTS if c.make().coverage == "sphere"])
def test_a_constant_stays(case: Case) -> None:
    p = case.make()
    white = np.full((*p.shape(16), 5), 0.25, np.float32)
    for kind, roughness in (("ggx", 0.0), ("ggx", 0.3), ("charlie", 0.5)):
        got = sm.light.prefilter(
            white,
            p,
            "latlong",
            roughness=roughness,
            size=4,
            method="sampled",
            samples=64,
            distribution=kind,  # type: ignore[arg-type]
        )
        # 64 terms in float32, each off by 6e-8 of 0.25.
        assert got.shape == (4, 8, 5) and np.abs(got - 0.25).max() < 1e-6


def test_a_chain_keeps_its_light_and_begins_with_the_image() -> None:
    d = sm.directions("cube", 32)
    image = (1 + d[..., :1] * 0.5 + d[..., 1:2] ** 2).astype(np.float32)
    chain = sm.light.prefilter_chain(image, "cube", "cube", size=32, levels=4, samples=256)
    assert [level.shape for level in chain] == [(6, 32 >> k, 32 >> k, 1) for k in range(4)]
    assert np.abs(chain[0] - image).max() < 0.01
    total = sm.light.integrate(image, "cube")
    for level in chain:
        # 256 Hammersley points err by 1/256 of what varies in a sky, which is half of it.
        assert np.allclose(sm.light.integrate(level, "cube"), total, rtol=3e-3)
    assert np.ptp(chain[-1]) < 0.6 * np.ptp(image)


@pytest.mark.parametrize("name", ["latlong", "octahedral", "angular", "cube"])
def test_a_mirror_shows_the_image(name: str) -> None:
    p = sm.projection(name)
    light = np.random.default_rng(3).random((*p.shape(24), 2))
    held = ~np.isnan(p.directions(24)[..., 0])
    (mirror,) = sm.light.prefilter_chain(light, p, p, size=24, roughness=[0])
    # A copy by area is the quotient of a sum by a weight: two roundings.
    assert mirror.dtype == light.dtype and np.abs(mirror - light)[held].max() < 4e-16
    for size in (7, 60):
        mirror = sm.light.prefilter(light.astype(np.float32), p, "latlong", size=size, roughness=0)
        assert np.array_equal(
            mirror,
            sm.convert(
                light.astype(np.float32),
                p,
                "latlong",
                size=size,
                filter="area" if size == 7 else "bilinear",
            ),
        )


def test_a_chain_has_a_level_for_each_roughness() -> None:
    white = np.ones((8, 16), np.float32)

    def sizes(**options: Any) -> list[int]:
        chain = sm.light.prefilter_chain(white, "latlong", "cube", size=4, samples=4, **options)
        return [level.shape[-1] for level in chain]

    assert sizes() == [4, 2, 1]
    assert sizes(roughness=[0, 0.5]) == [4, 2]
    assert sizes(roughness=iter([0.5])) == [4]
    for roughness, levels, says in (
        ([], None, "`roughness` to have 1 to 3 numbers, one a level of `size` 4, got 0"),
        ([0.1] * 4, None, "`roughness` to have 1 to 3 numbers, one a level of `size` 4, got 4"),
        ([0.1] * 2, 3, "`roughness` to have 3 numbers, got 2"),
    ):
        with pytest.raises(ValueError, match=says):
            sizes(roughness=roughness, levels=levels)


def test_a_large_source_is_reduced_and_keeps_a_lone_sun() -> None:
    sun = np.zeros((1100, 2200), np.float32)
    sun[700, 1234] = 1e6
    (level,) = sm.light.prefilter_chain(sun, "latlong", "cube", size=16, levels=1, roughness=[1.0])
    # One texel, looked up bilinearly by a cube of not quite twice its density: ±4 %.
    assert np.allclose(
        sm.light.integrate(level, "cube"), sm.light.integrate(sun, "latlong"), rtol=0.05
    )


@pytest.mark.parametrize(
    ("kind", "literal"), [("ggx", reference.dfg_ggx), ("charlie", reference.dfg_charlie)]
)
def test_the_table_is_its_integrals(kind: Any, literal: Any) -> None:
    n = 32
    table = sm.light.dfg(n, distribution=kind)
    places = [
        (0, 0),
        (0, n - 1),
        (n - 1, 0),
        (n - 1, n - 1),
        (2, 0),
        (3, n - 2),
        (9, 8),
        (20, 14),
        (28, 3),
    ]
    for j, i in places:
        e, b = literal((j + 0.5) / n, (i + 0.5) / n, 3000, 300)
        # The entries are float32, and Charlie's lowest rows go up to 10.
        assert abs(table[j, i, 1] - e) < 1e-4 * max(e, 1), (j, i)
        assert abs(table[j, i, 0] - b) < 1e-4, (j, i)
    pair = sm.light.dfg(n, distribution=kind, multiscatter=False)
    # Entries are float32, rounded one by one: 6e-8 each, far below `allclose`'s own 1e-5.
    assert np.allclose(pair.sum(-1), table[..., 1]) and np.allclose(pair[..., 1], table[..., 0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"roughness": 1.5}, r"`roughness` must be in \[0, 1\]"),
        ({"roughness": float("nan")}, "`roughness`"),
        ({"roughness": 0.0, "distribution": "charlie"}, "above 0"),
        ({"roughness": 0.5, "distribution": "beckmann"}, "unknown distribution"),
        ({"roughness": 0.5, "samples": 0}, "`samples`"),
        ({"roughness": 0.5, "method": "best"}, "`method`"),
        ({"roughness": 0.0, "method": "exact"}, "mirror"),
    ],
)
def test_bad_requests(options: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sm.light.prefilter(np.ones((8, 16)), "latlong", "cube", size=2, **options)


# --- files, read by what their specifications say


def code(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as left:
        cli.main(arguments)
    return int(left.value.code or 0)


def read_ktx2(path: Path) -> list[np.ndarray]:
    data = path.read_bytes()
    assert data[:12] == bytes([0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32, 0x30, 0xBB, 13, 10, 26, 10])
    fields = struct.unpack_from("<13I2Q", data, 12)
    form, size, width, height, depth, layers, faces, count, scheme = fields[:9]
    assert (form, size, depth, layers, scheme) == (97, 2, 0, 0, 0)
    dfd_at, dfd_size, kvd_at, kvd_size, sgd_at, sgd_size = fields[9:]
    assert dfd_at == 80 + 24 * count and kvd_at == dfd_at + dfd_size and sgd_at == sgd_size == 0
    assert struct.unpack_from("<I", data, dfd_at)[0] == dfd_size == 4 + 24 + 4 * 16
    model, primaries, transfer, _ = data[dfd_at + 12 : dfd_at + 16]
    assert (model, primaries, transfer) == (1, 1, 1)
    assert data[dfd_at + 20] == 8
    for k, channel in enumerate((0, 1, 2, 15)):
        offset, bits, kind = struct.unpack_from("<HBB", data, dfd_at + 28 + 16 * k)
        assert (offset, bits, kind) == (16 * k, 15, 0xC0 | channel)
    assert b"KTXorientation\0rd\0" in data[kvd_at : kvd_at + kvd_size]
    levels, end = [], kvd_at + kvd_size
    for k in reversed(range(count)):
        at, stored, plain = struct.unpack_from("<3Q", data, 80 + 24 * k)
        w, h = max(width >> k, 1), max(height >> k, 1)
        assert at % 8 == 0 and end <= at < end + 8 and stored == plain == faces * w * h * 8
        end = at + stored
        levels.insert(0, np.frombuffer(data, "<f2", stored // 2, at).reshape(faces, h, w, 4))
    assert end == len(data)
    return levels


def read_dds(path: Path) -> list[np.ndarray]:
    data = path.read_bytes()
    assert data[:4] == b"DDS "
    head = struct.unpack_from("<31I", data, 4)
    assert head[0] == 124 and head[1] & 0x1007 == 0x1007
    height, width, count = head[2], head[3], max(head[6], 1)
    assert head[18:21] == (32, 4, 113)
    caps, caps2 = head[26], head[27]
    assert caps & 0x1000 and (count == 1 or caps & 0x400008 == 0x400008)
    faces = 6 if caps2 & 0x200 else 1
    assert caps2 in (0, 0xFE00)
    levels: list[list[np.ndarray]] = [[] for _ in range(count)]
    at = 128
    for _ in range(faces):
        for k in range(count):
            w, h = max(width >> k, 1), max(height >> k, 1)
            levels[k].append(np.frombuffer(data, "<f2", 4 * w * h, at).reshape(h, w, 4))
            at += 8 * w * h
    assert at == len(data)
    return [np.stack(level) for level in levels]


@pytest.mark.parametrize("mips", [1, 3, 5])
def test_textures_come_back(tmp_path: Path, mips: int) -> None:
    rng = np.random.default_rng(0)
    levels = [rng.random((6, 16 >> k, 16 >> k, 3)) for k in range(mips)]
    for name, write, read in (
        ("a.ktx2", sm.io.write_ktx2, read_ktx2),
        ("a.dds", sm.io.write_dds, read_dds),
    ):
        assert write(tmp_path / name, levels) == 0
        for got, want in zip(read(tmp_path / name), levels, strict=True):
            assert np.array_equal(got[..., :3], want.astype(np.float16)) and np.all(
                got[..., 3] == 1
            )
    assert len(list(tmp_path.iterdir())) == 2


def test_files_are_those_that_other_readers_read(tmp_path: Path) -> None:
    """Check the files that tests/textures.rs gives to other people's readers."""
    levels = [
        np.arange(6.0)[:, None] * 256 + 64 * k + np.arange(4.0 * side * side)
        for k, side in enumerate((4, 2, 1))
    ]
    levels = [
        level.reshape(6, side, side, 4) for level, side in zip(levels, (4, 2, 1), strict=True)
    ]
    for name, write in (("cube.ktx2", sm.io.write_ktx2), ("cube.dds", sm.io.write_dds)):
        assert write(tmp_path / name, levels) == 0
        kept = Path(__file__).parents[1] / "data" / name
        assert (tmp_path / name).read_bytes() == kept.read_bytes()


def test_faces_are_in_the_order_of_opengl(tmp_path: Path) -> None:
    """Face k holds the directions that its major axis says, each row where it should be."""
    d = sm.directions("cube", 8).astype(np.float32)
    sm.io.write_dds(tmp_path / "d.dds", [d])
    (cube,) = read_dds(tmp_path / "d.dds")
    for face, (axis, sign) in enumerate([(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)]):
        assert np.all(cube[face, ..., axis] * sign > 0.5)
    # OpenGL 4.6, table 8.19: +x has s along -z and t along -y; +y has s along +x, t along +z.
    assert np.all(np.diff(cube[0, 4, :, 2].astype(float)) < 0)
    assert np.all(np.diff(cube[0, :, 4, 1].astype(float)) < 0)
    assert np.all(np.diff(cube[2, :, 4, 2].astype(float)) > 0)


def test_what_half_floats_cannot_hold_is_counted(tmp_path: Path) -> None:
    image = np.ones((4, 4, 1))
    image[0, 0], image[1, 1] = 1e6, -np.inf
    assert sm.io.write_ktx2(tmp_path / "a.ktx2", [image]) == 6
    (got,) = read_ktx2(tmp_path / "a.ktx2")
    assert got[0, 0, 0, 0] == 65504 and got[0, 1, 1, 2] == -65504


@pytest.mark.parametrize(
    "levels",
    [
        [],
        [np.ones((5, 4, 4, 3))],
        [np.ones((4, 4))],
        [np.ones((4, 4, 3)), np.ones((3, 2, 3))],
        [np.ones((4, 4, 5))],
    ],
)
def test_what_is_no_texture(tmp_path: Path, levels: list[np.ndarray]) -> None:
    with pytest.raises(ValueError, match="Expected"):
        sm.io.write_ktx2(tmp_path / "a.ktx2", levels)
    assert not list(tmp_path.iterdir())


def test_the_command_bakes_and_lists(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("OpenImageIO")
    from spheremap import io

    image = environment(16)
    io.write(tmp_path / "sky.exr", image)
    out = tmp_path / "out"
    small = ["--size", "8", "--levels", "3", "--diffuse-size", "4", "--samples", "16"]
    assert code(["bake", str(tmp_path / "sky.exr"), str(out), *small]) == 0
    said = capsys.readouterr().out
    names = {
        "diffuse.ktx2",
        "diffuse.dds",
        "specular.ktx2",
        "specular.dds",
        "dfg.ktx2",
        "dfg.dds",
        "sh.json",
    }
    assert {f.name for f in out.iterdir()} == names and all(name in said for name in names)
    (diffuse,) = read_ktx2(out / "diffuse.ktx2")
    want = sm.light.irradiance(image, "latlong", "cube", size=4) / np.pi
    # Half floats round by 2⁻¹¹ = 5e-4.
    assert np.allclose(diffuse[..., :3], want, rtol=2e-3)
    assert [level.shape[1] for level in read_dds(out / "specular.dds")] == [8, 4, 2]
    sh = json.loads((out / "sh.json").read_text())
    # JSON holds doubles to their last digit; `allclose`'s own 1e-5 is ample.
    assert np.allclose(sh["orthonormal"], sm.sh.project(image, "latlong", order=2))
    assert code(["bake", str(tmp_path / "sky.exr"), str(tmp_path / "only"), "--sh"]) == 0
    assert [f.name for f in (tmp_path / "only").iterdir()] == ["sh.json"]
    assert code(["bake", str(tmp_path / "sky.exr"), str(out), "--size", "8", "--levels", "9"]) == 2
    # A small size has fewer levels than the default, and nobody asked for more.
    assert code(["bake", str(tmp_path / "sky.exr"), str(out), "--specular", "--size", "4"]) == 0
    assert [level.shape[1] for level in read_dds(out / "specular.dds")] == [4, 2, 1]
    assert code(["bake", str(tmp_path / "none.exr"), str(out)]) == 1
    assert code(["bake", str(tmp_path / "sky.exr"), str(out / "sh.json")]) == 1


def test_integers_are_fractions_in_textures(tmp_path: Path) -> None:
    for dtype in (np.uint8, np.uint16):
        codes = np.full((2, 2, 3), np.iinfo(dtype).max, dtype)
        codes[0, 0] = 0
        assert sm.io.write_ktx2(tmp_path / "a.ktx2", [codes]) == 0
        (got,) = read_ktx2(tmp_path / "a.ktx2")
        assert got[0, 0, 0].tolist() == [0, 0, 0, 1] and np.all(got[0, 1] == 1)
    with pytest.raises(TypeError, match="uint8, uint16 or floats, got dtype int64"):
        sm.io.write_dds(tmp_path / "a.dds", [np.ones((2, 2, 3), np.int64)])


def test_textures_have_the_suffix_of_their_format(tmp_path: Path) -> None:
    level = np.ones((2, 2, 3))
    for name, write, suffix in (
        ("a.png", sm.io.write_ktx2, ".ktx2"),
        ("a", sm.io.write_ktx2, ".ktx2"),
        ("a.ktx2", sm.io.write_dds, ".dds"),
    ):
        with pytest.raises(OSError, match=f"cannot write '.*{name}': it ends in .*; use {suffix}"):
            write(tmp_path / name, [level])
    assert not list(tmp_path.iterdir())
    sm.io.write_dds(tmp_path / "A.DDS", [level])


def test_masked_texels_are_missing_in_textures(tmp_path: Path) -> None:
    level = np.ma.masked_array(np.ones((2, 2, 1)), [[[True], [False]]] * 2)
    sm.io.write_ktx2(tmp_path / "a.ktx2", [level])
    texels = np.frombuffer((tmp_path / "a.ktx2").read_bytes()[-32:], "<f2").reshape(2, 2, 4)
    assert np.isnan(texels[:, 0, :3]).all() and (texels[:, 1] == 1).all()


def test_a_bake_is_of_the_precision_of_its_image() -> None:
    sky = np.full((8, 16, 3), 3.0)
    made = sm.light.bake(sky, "latlong", specular=False, diffuse_size=4)
    # Sums of some hundred weights of float64.
    np.testing.assert_allclose(made.diffuse, 3.0, rtol=1e-14)
    # Arrays have no one truth: bakes are equal to themselves alone.
    assert made == made and made != sm.light.bake(sky, "latlong", specular=False, diffuse_size=4)
    assert len({made, made}) == 1
