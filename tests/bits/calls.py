"""What is computed of the inputs, by name: every verb, every row of a registry, every type."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import spheremap as sm
from spheremap import _core

from .inputs import Arrays, image

IMAGE_DTYPES = ("uint8", "uint16", "float16", "float32", "float64")
FLOATS = ("float32", "float64")
FILTERS: list[dict[str, Any]] = _core.filters()
LOOKUPS = [f["name"] for f in FILTERS if f["method"] == "lookup"]
MIPMAPPED = [f["name"] for f in FILTERS if f["method"] == "mipmapped"]
# An ellipse takes derivatives alone.
BY_LEVEL = [name for name in MIPMAPPED if name != "ewa"]
CONVERTS = [f["name"] for f in FILTERS]
LABELS = [f["name"] for f in FILTERS if f["takes_labels"]]

Call = tuple[str, Callable[[], Any]]


def results(inputs: Arrays) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the name and the arrays of every call."""
    # Packings without a bound say so.
    warnings.simplefilter("ignore")
    for rooms in (maps, images, means, codes, pixels, harmonics, light):
        for name, call in rooms(inputs):
            found = call()
            if isinstance(found, tuple | list):
                for k, value in enumerate(found):
                    yield f"{name} [{k}]", np.asarray(value)
            else:
                yield name, np.asarray(found)


def variants() -> Iterator[tuple[str, sm.Projection]]:
    """Yield every projection as it is, in every layout, and at other parameters."""
    for entry in _core.registry():
        name = entry["name"]
        yield name, sm.projection(name)
        for layout in entry["layouts"]:
            yield f"{name} {layout}", sm.projection(name, layout=layout)
        for p in entry["parameters"]:
            for part in (0.125, 0.5, 0.75):
                value = p["minimum"] + (p["maximum"] - p["minimum"]) * part
                try:
                    yield (
                        f"{name} {p['name']}={value:g}",
                        sm.projection(name, **{p["name"]: value}),
                    )
                except ValueError:
                    continue  # it may not go with the others


def maps(inputs: Arrays) -> Iterator[Call]:
    """Directions and coordinates."""
    turn = inputs["turn"]
    for dtype in FLOATS:
        d = inputs[f"directions {dtype}"]
        yield f"reflect {dtype}", lambda d=d: sm.reflect(d, d[::-1].copy())
        angles = inputs[f"uv {dtype}"] * 720 - 360
        yield f"directions_to_lonlat {dtype}", lambda d=d: sm.directions_to_lonlat(d)
        yield f"lonlat_to_directions {dtype}", lambda a=angles: sm.lonlat_to_directions(a)
    for k, angles in enumerate(inputs["angles"]):
        yield f"rotation: {k}", lambda angles=angles: sm.rotation(*angles)
    for what, p in variants():
        for dtype in FLOATS:
            d, uv = inputs[f"directions {dtype}"], inputs[f"uv {dtype}"]
            if p.faces > 1:
                face = (inputs["words"][: len(uv)] % p.faces).astype(dtype)
                # Now and then what is no face.
                face[::32] = np.resize(np.array([-1, p.faces, 0.5, np.nan], dtype), len(uv[::32]))
                uv = np.concatenate([uv, face[:, None]], axis=-1)
            known = np.ascontiguousarray(p.encode(d))
            for verb, call in {
                "encode": lambda p=p, d=d: p.encode(d),
                "encode turned": lambda p=p, d=d: p.encode(d, rotation=turn),
                "covers": lambda p=p, d=d: p.covers(d),
                "decode": lambda p=p, uv=uv: p.decode(uv),
                "decode turned": lambda p=p, uv=uv: p.decode(uv, rotation=turn),
                "decode encoded": lambda p=p, uv=known: p.decode(uv),
                "jacobian": lambda p=p, uv=uv: p.jacobian(uv),
                "jacobian encoded": lambda p=p, uv=known: p.jacobian(uv),
                "density": lambda p=p, uv=uv: p.density(uv),
                "valid": lambda p=p, uv=uv: p.valid(uv),
                "directions": lambda p=p, t=dtype: p.directions(17, dtype=t),
            }.items():
                yield f"{verb}: {what} {dtype}", call
        yield f"solid_angle: {what}", lambda p=p: p.solid_angle(17)
        yield f"weights: {what}", lambda p=p: sm.light.weights(p, 17)


def images(inputs: Arrays) -> Iterator[Call]:
    """Images of every type, by every filter."""
    words, unit = inputs["words"], inputs["unit"]
    single = unit.astype(np.float32)
    for what, p in variants():
        plain = " " not in what
        for dtype in IMAGE_DTYPES if plain else ("uint8", "float32"):
            x = image(words, (*p.shape(12), 2), dtype)
            for f in LOOKUPS if plain else ("bilinear", "lanczos3"):
                yield (
                    f"sample {f}: {what} {dtype}",
                    lambda x=x, p=p, f=f: p.sample(x, unit, filter=f),
                )
            for f in CONVERTS if plain else ("bilinear", "area"):
                # Those of labels have one channel.
                y = np.ascontiguousarray(x[..., 0]) if f in LABELS else x
                yield (
                    f"convert {f}: {what} to octahedral {dtype}",
                    lambda x=y, p=p, f=f: sm.convert(x, p, "octahedral", size=9, filter=f),
                )
        if not plain:
            continue
        for dtype in FLOATS:
            x = image(words, (*p.shape(12), 3), dtype)
            yield (
                f"sample float32 directions: {what} {dtype}",
                lambda x=x, p=p: p.sample(x, single, fill=np.nan),
            )
            for f in BY_LEVEL:
                yield (
                    f"sample lod {f}: {what} {dtype}",
                    lambda x=x, p=p, f=f: p.sample(x, unit, filter=f, lod=inputs["lod"]),
                )
            for f in MIPMAPPED:
                yield (
                    f"sample derivatives {f}: {what} {dtype}",
                    lambda x=x, p=p, f=f: p.sample(
                        x, unit, filter=f, derivatives=tuple(inputs["derivatives"])
                    ),
                )
            yield f"mipmaps: {what} {dtype}", lambda x=x, p=p: sm.mipmaps(x, p)
            yield f"pad: {what} {dtype}", lambda x=x, p=p: sm.pad(x, p, 2)
            depth = np.abs(x[..., 0])
            yield (
                f"convert_depth: {what} {dtype}",
                lambda x=depth, p=p: sm.convert_depth(x, p, target="z"),
            )
            yield (
                f"remap_plan: {what} {dtype}",
                lambda p=p, t=dtype: sm.remap_plan(
                    p, "latlong", size=9, rotation=inputs["turn"]
                ).maps(p.shape(12), dtype=t),
            )
        yield (
            f"mipmaps: {what} uint8",
            lambda p=p: sm.mipmaps(image(words, (*p.shape(12), 3), "uint8"), p),
        )
        for f in CONVERTS:
            x = image(words, sm.projection("latlong").shape(10), "float32")
            yield (
                f"convert {f}: latlong to {what} float32",
                lambda x=x, p=p, f=f: sm.convert(
                    x, "latlong", p, size=8, filter=f, rotation=inputs["turn"]
                ),
            )
    places = inputs["uv float64"]
    places = np.ascontiguousarray(places[np.isfinite(places).all(-1)])
    for dtype in IMAGE_DTYPES:
        x = image(words, (11, 14, 3), dtype)
        for f in LOOKUPS:
            for address in ("clamp", "wrap", "mirror", "border"):
                yield (
                    f"sample_uv {f}: {address} {dtype}",
                    lambda x=x, f=f, a=address: sm.sample_uv(x, places, filter=f, address=a),
                )


def means(inputs: Arrays) -> Iterator[Call]:
    """Images that are large enough for polynomials, made smaller: of few texels and of many."""
    for channels in (1, 3):
        for dtype in IMAGE_DTYPES:
            x = image(inputs["words"], (512, 1024, channels), dtype)
            for size in (64, 160):
                for f in ("bilinear", "lanczos3") if dtype == "float32" else ("bilinear",):
                    yield (
                        f"convert {f}: {channels} numbers to 6 x {size} {dtype}",
                        lambda x=x, n=size, f=f: sm.convert(
                            x, "latlong", "cube", size=n, filter=f, rotation=inputs["turn"]
                        ),
                    )


def codes(inputs: Arrays) -> Iterator[Call]:
    """Every packing, in every rounding."""
    words = inputs["words"].astype(np.uint64)
    words = words << np.uint64(32) | words[::-1]
    for name in sm.packing.packings():
        about = sm.packing.packing(name)
        for dtype in FLOATS:
            d = inputs[f"directions {dtype}"]
            for rounding in about.roundings:
                yield (
                    f"pack {rounding}: {name} {dtype}",
                    lambda d=d, n=name, r=rounding: sm.packing.pack(d, n, r, invalid="zero"),
                )
        if about.shape:
            some = words[: 400 * about.shape[0]].astype(about.dtype).reshape(400, -1)
        else:
            some = (words[:400] % np.uint64(min(about.codes, 1 << 63))).astype(about.dtype)
        each = about.bits // about.shape[0] if about.shape else 0
        if about.shape and each < 8 * about.dtype.itemsize:
            # Fields that do not fill their numbers.
            low = -(1 << each - 1) if about.dtype.kind == "i" else 0
            some = ((some.astype(np.int64) % (1 << each)) + low).astype(about.dtype)
        for dtype in FLOATS:
            yield (
                f"unpack: {name} {dtype}",
                lambda c=some, n=name, t=dtype: sm.packing.unpack(c, n, dtype=t),
            )
        yield f"canonical: {name}", lambda c=some, n=name: sm.packing.canonical(c, n)
    normals, tangents = inputs["unit"], np.ascontiguousarray(inputs["unit"][::-1])
    for name, dtype in (("frame32", np.uint32), ("frame64", np.uint64)):
        yield (
            f"pack_frame: {name}",
            lambda n=name: sm.packing.pack_frame(normals, tangents, n, invalid="zero"),
        )
        yield (
            f"unpack_frame: {name}",
            lambda n=name, t=dtype: sm.packing.unpack_frame(words[:400].astype(t), n),
        )


def pixels(inputs: Arrays) -> Iterator[Call]:
    """HEALPix."""
    d = inputs["directions float64"]
    d = np.ascontiguousarray(d[np.isfinite(d).all(-1) & d.any(-1)])
    for nside in (1, 2, 64, 1 << 20, 1 << 29):
        count = 12 * nside * nside
        some = (inputs["words"][:4000].astype(np.int64) * 3037000507) % count
        theta = (some % 31416) / 1e4
        phi = (some % 62831) / 1e4
        for nest in (False, True):
            for verb, call in {
                "vec2pix": lambda n=nside, t=nest: sm.healpix.vec2pix(n, d, nest=t),
                "pix2vec": lambda n=nside, t=nest, s=some: sm.healpix.pix2vec(n, s, nest=t),
                "pix2ang": lambda n=nside, t=nest, s=some: sm.healpix.pix2ang(n, s, nest=t),
                "ang2pix": lambda n=nside, t=nest, a=theta, b=phi: sm.healpix.ang2pix(
                    n, a, b, nest=t
                ),
                "boundaries": lambda n=nside, t=nest, s=some: sm.healpix.boundaries(
                    n, s[:200], step=3, nest=t
                ),
                "neighbors": lambda n=nside, t=nest, s=some: sm.healpix.neighbors(n, s, nest=t),
                "interpolation_weights": lambda n=nside, t=nest, a=theta, b=phi: (
                    sm.healpix.interpolation_weights(n, a, b, nest=t)
                ),
            }.items():
                yield f"{verb}: nside {nside} {'nest' if nest else 'ring'}", call
        yield f"ring2nest: nside {nside}", lambda n=nside, s=some: sm.healpix.ring2nest(n, s)
        yield f"nest2ring: nside {nside}", lambda n=nside, s=some: sm.healpix.nest2ring(n, s)


def harmonics(inputs: Arrays) -> Iterator[Call]:
    """Spherical harmonics."""
    words, unit = inputs["words"], inputs["unit"]
    c = image(words, (25, 2), "float64")
    yield "sh.evaluate", lambda: sm.sh.evaluate(c, unit)
    yield "sh.rotate", lambda: sm.sh.rotate(c, inputs["turn"])
    for lobe, own in (
        ("cosine", {}),
        ("cone", {"half_angle": 33}),
        ("phong", {"exponent": 7.5}),
        ("vmf", {"kappa": 9}),
    ):
        yield f"sh.lobe: {lobe}", lambda name=lobe, o=own: sm.sh.lobe(name, order=8, **o)
    for window in ("hann", "lanczos", "gauss"):
        yield f"sh.window: {window}", lambda w=window: sm.sh.window(c, window=w)
    for row in sm.sh.conventions():
        small = c[:9] if row["name"].startswith("filament") else c
        yield f"sh.convert: {row['name']}", lambda x=small, n=row["name"]: sm.sh.convert(x, dst=n)
    for entry in _core.registry():
        p = sm.projection(entry["name"])
        x = image(words, (*p.shape(12), 2), "float32")
        for texels in ("means", "points"):
            yield (
                f"sh.project {texels}: {p.name}",
                lambda x=x, p=p, t=texels: sm.sh.project(x, p, order=3, texels=t),
            )


def light(inputs: Arrays) -> Iterator[Call]:
    """Sums, lobes, reflections, sampling, lights."""
    words, unit = inputs["words"], inputs["unit"]
    for entry in _core.registry():
        p = sm.projection(entry["name"])
        for dtype in FLOATS:
            x = image(words, (*p.shape(10), 3), dtype)
            yield f"integrate: {p.name} {dtype}", lambda x=x, p=p: sm.light.integrate(x, p)
            yield (
                f"average_direction: {p.name} {dtype}",
                lambda x=x, p=p: sm.light.average_direction(x, p),
            )
            yield (
                f"irradiance_at: {p.name} {dtype}",
                lambda x=x, p=p: sm.light.irradiance_at(x, unit[:40], p),
            )
            yield f"distribution: {p.name} {dtype}", lambda x=x, p=p: drawn(x, p, inputs)
            yield f"lights: {p.name} {dtype}", lambda x=x, p=p: suns(x, p)
    x = image(words, (16, 32, 3), "float32")
    for method in ("exact", "sh"):
        yield (
            f"irradiance: {method}",
            lambda m=method: sm.light.irradiance(x, "latlong", "cube", size=4, method=m, order=4),
        )
    for lobe, parameter in (("cone", "half_angle"), ("phong", "exponent"), ("vmf", "kappa")):
        yield (
            f"convolve: {lobe}",
            lambda n=lobe, k=parameter: sm.light.convolve(
                x, "latlong", "octahedral", lobe=n, size=6, **{k: 20.5}
            ),
        )
    for method in ("exact", "sampled"):
        for kind in ("ggx", "charlie"):
            yield (
                f"prefilter: {method} {kind}",
                lambda m=method, k=kind: sm.light.prefilter(
                    x,
                    "latlong",
                    "cube",
                    roughness=0.4,
                    size=4,
                    method=m,
                    distribution=k,
                    samples=64,
                ),
            )
    yield "dfg: ggx", lambda: sm.light.dfg(4)
    yield "dfg: charlie", lambda: sm.light.dfg(4, distribution="charlie")


def drawn(x: np.ndarray, p: sm.Projection, inputs: Arrays) -> list[Any]:
    """Return samples in both types, their density, and that of given directions."""
    distribution = sm.light.Distribution(x, p)
    xi = inputs["xi"]
    single = xi.astype(np.float32)
    single[single == 1] = 0  # what rounded up
    return [
        distribution.integral,
        distribution.pdf(inputs["unit"]),
        *distribution.sample(xi, weights=True),
        *distribution.sample(single),
    ]


def suns(x: np.ndarray, p: sm.Projection) -> list[Any]:
    """Return the lights of an image, and what its sun is."""
    found = sm.light.lights(x, p, count=7)
    sun = sm.light.sun(x, p)
    said = [found.directions, found.irradiance, found.solid_angle]
    return said if sun is None else [*said, sun.direction, sun.solid_angle, sun.irradiance]
