"""Peak memory of any call: inputs + outputs + 2 MiB, or what the page of decisions says.

Each call runs in a process of its own. The kernel's own counters are read: resident memory before
the call, and its highest value during the call (the mark is reset just before). Pages of code that
the call is the first to run are no memory of its own: where they lie in a library, and how many
come with one, is the linker's choice.
"""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from conftest import some_fast
from test_signatures import FUNCTIONS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "decisions" / "memory.md"

SETUP = """
import gc, sys
import numpy as np
import spheremap as sm

def status(key):
    with open("/proc/self/status") as f:
        for line in f:
            if line.startswith(key):
                return int(line.split()[1]) * 1024

def fresh(shape, dtype):
    a = np.empty(shape, dtype)
    a.reshape(-1).view(np.uint8)[::4096] = 0
    return a

def code():
    total, library = 0, False
    with open("/proc/self/smaps") as f:
        for line in f:
            if line.startswith("Rss:"):
                total += library * int(line.split()[1]) * 1024
            elif "-" in line.split()[0]:
                library = ".so" in line
    return total

def measure(call, warm):
    warm()  # the pool's threads, lazy imports
    gc.collect()
    with open("/proc/self/clear_refs", "w") as f:
        f.write("5")
    before, known = status("VmRSS"), code()
    out = call()
    peak = status("VmHWM") - (code() - known)
    parts = out if isinstance(out, (list, tuple)) else [out]
    owned = sum(part.nbytes for part in parts if isinstance(part, np.ndarray))
    print(peak - before - owned)

sm.set_num_threads(2)
N = 2_000_000
rng = np.random.default_rng(0)
def directions(dtype, n=N):
    d = fresh((n, 3), dtype)
    d[...] = 1
    d[::3, 0] = -2
    d[::7, 1] = 3
    return d
def uvs(dtype, n=N):
    d = fresh((n, 2), dtype)
    d[:, 0] = 0.3
    d[:, 1] = 0.6
    return d
few = np.ones((200_000, 3), np.float32)
"""

CALLS = {
    "encode f32": (
        "d = directions(np.float32)",
        "sm.encode(d, 'latlong')",
        "sm.encode(few, 'latlong')",
    ),
    "encode f64": ("d = directions(np.float64)", "sm.encode(d, 'octahedral')", None),
    "encode strided": (
        "d = np.zeros((N, 8), np.float32); d[...] = 1; d = d[:, 1:4]",
        "sm.encode(d, 'octahedral')",
        None,
    ),
    "encode reversed": ("d = directions(np.float64)[::-1]", "sm.encode(d, 'angular')", None),
    "encode fortran": (
        "d = np.asfortranarray(directions(np.float32))",
        "sm.encode(d, 'sphere')",
        None,
    ),
    "encode half": ("d = directions(np.float16)", "sm.encode(d, 'cube')", None),
    "encode integers": ("d = directions(np.int32)", "sm.encode(d, 'octahedral')", None),
    "encode into out": (
        "d = directions(np.float32); o = fresh((N, 2), np.float32)",
        "(sm.encode(d, 'octahedral', out=o), None)[1]",
        None,
    ),
    "encode turned": (
        "d = directions(np.float32); R = sm.rotation(1, 2, 3)",
        "sm.encode(d, 'latlong', rotation=R)",
        None,
    ),
    "encode other byte order": (
        "d = directions(np.dtype(np.float64).newbyteorder('S'))",
        "sm.encode(d, 'octahedral')",
        None,
    ),
    "encode transposed": (
        "d = fresh((3, 2000, 1000), np.float32); d[...] = 1; d = d.T",
        "sm.encode(d, 'octahedral')",
        None,
    ),
    "encode few rows": (
        "d = directions(np.float32).reshape(2, -1, 3)[::-1]",
        "sm.encode(d, 'latlong')",
        None,
    ),
    "encode strided into out": (
        "d = directions(np.float64)[::-1]; o = fresh((N, 2), np.float64)",
        "(sm.encode(d, 'octahedral', out=o), None)[1]",
        None,
    ),
    "decode": ("x = uvs(np.float32)", "sm.decode(x, 'latlong')", None),
    "pixels_to_directions": (
        "x = uvs(np.float32)",
        "sm.pixels_to_directions(x, 'latlong', 64)",
        "sm.pixels_to_directions(few[:, :2], 'latlong', 64)",
    ),
    "pixels_to_directions on corners": (
        "x = uvs(np.float64)[::-1]; p = sm.projection('cube', layout='cross', grid='corners')",
        "p.pixels_to_directions(x, 64)",
        "p.pixels_to_directions(few[:, :2], 64)",
    ),
    "directions_to_pixels": (
        "d = directions(np.float32)",
        "sm.directions_to_pixels(d, 'latlong', 64)",
        "sm.directions_to_pixels(few, 'latlong', 64)",
    ),
    "jacobian": ("x = uvs(np.float64, 1_000_000)", "sm.jacobian(x, 'octahedral')", None),
    "density": ("x = uvs(np.float64)", "sm.density(x, 'octahedral')", None),
    "valid": ("x = uvs(np.float64)", "sm.valid(x, 'octahedral')", None),
    "covers": ("d = directions(np.float64)", "sm.covers(d, 'matcap')", None),
    "decode strided": ("x = uvs(np.float32)[::-1]", "sm.decode(x, 'latlong')", None),
    "jacobian half": ("x = uvs(np.float16, 1_000_000)", "sm.jacobian(x, 'octahedral')", None),
    "density strided": ("x = uvs(np.float64)[::-1]", "sm.density(x, 'octahedral')", None),
    "valid strided": ("x = uvs(np.float64)[::-1]", "sm.valid(x, 'octahedral')", None),
    "covers strided": ("d = directions(np.float64)[::-1]", "sm.covers(d, 'matcap')", None),
    "solid_angle latlong": (
        "pass",
        "sm.solid_angle('latlong', 1500)",
        "sm.solid_angle('latlong', 400)",
    ),
    "solid_angle angular": (
        "pass",
        "sm.solid_angle('angular', 1500)",
        "sm.solid_angle('angular', 400)",
    ),
    "solid_angle octahedral": (
        "pass",
        "sm.solid_angle('octahedral', 1500)",
        "sm.solid_angle('octahedral', 400)",
    ),
    "directions": ("pass", "sm.directions('cube', 700)", "sm.directions('cube', 200)"),
    "reflect": (
        "d = directions(np.float32); n = d[0].copy()",
        "sm.reflect(d, n)",
        "sm.reflect(few, few[0])",
    ),
    "reflect strided": (
        "d = directions(np.float32); n = d[::-1]",
        "sm.reflect(d, n)",
        "sm.reflect(few, few[::-1])",
    ),
    "reflect both strided": (
        "d = directions(np.float64); n = d[::-1]",
        "sm.reflect(d[:, ::-1], n)",
        "sm.reflect(few[:, ::-1], few[::-1])",
    ),
    "reflect mixed": (
        "d = directions(np.float32); n = np.ones(3)",
        "sm.reflect(d, n)",
        "sm.reflect(few, np.ones(3))",
    ),
    "reflect broadcast": (
        "d = directions(np.float64).reshape(2, -1, 3); n = d[0]",
        "sm.reflect(d, n)",
        "sm.reflect(few[None], few)",
    ),
    "sample strided directions": (
        "d = directions(np.float32)[::-1]; i = np.ones((512, 1024, 3), np.float32)",
        "sm.sample(i, d, 'latlong')",
        "sm.sample(i, few[::-1], 'latlong')",
    ),
    "sample": (
        "d = directions(np.float32); i = np.ones((512, 1024, 3), np.float32)",
        "sm.sample(i, d, 'latlong')",
        "sm.sample(i, few, 'latlong')",
    ),
    "sample_uv": (
        "x = uvs(np.float32); i = np.ones((512, 1024, 3), np.float32)",
        "sm.sample_uv(i, x)",
        "sm.sample_uv(i, few[:, :2])",
    ),
    "sample derivatives": (
        "d = directions(np.float32); i = np.ones((16, 32, 3), np.float32)",
        "sm.sample(i, d, 'latlong', derivatives=(d[:1], d))",
        "sm.sample(i, few, 'latlong', derivatives=(few, few))",
    ),
    "sample bytes": (
        "d = directions(np.float32); i = np.ones((512, 1024, 3), np.uint8)",
        "sm.sample(i, d, 'latlong')",
        "sm.sample(i, few, 'latlong')",
    ),
    "sample half": (
        "d = directions(np.float32); i = np.ones((1024, 2048, 3), np.float16)",
        "sm.sample(i, d, 'latlong')",
        "sm.sample(i, few, 'latlong')",
    ),
    "sample disk": (
        "d = directions(np.float32); i = np.ones((1500, 1500, 3), np.float32)",
        "sm.sample(i, d, 'angular')",
        "sm.sample(i[:100, :100], few, 'angular')",
    ),
    "convert": (
        "i = np.ones((800, 1600, 3), np.float32)",
        "sm.convert(i, 'latlong', 'cube', size=800)",
        "sm.convert(i, 'latlong', 'cube', size=200)",
    ),
    "convert bytes": (
        "i = np.ones((1500, 1500, 4), np.uint8)",
        "sm.convert(i, 'angular', 'latlong', size=1500)",
        "sm.convert(i, 'angular', 'latlong', size=200)",
    ),
    "convert f64 turned": (
        "i = np.ones((6, 400, 400, 3)); R = sm.rotation(1, 2, 3)",
        "sm.convert(i, 'cube', 'octahedral', size=1200, rotation=R)",
        "sm.convert(i, 'cube', 'octahedral', size=300, rotation=R)",
    ),
    "reorder": (
        "a = np.ones(12*256**2)",
        "sm.healpix.reorder(a, nest=True)",
        "sm.healpix.reorder(a[:12], nest=True)",
    ),
    "to_image": (
        "a = np.ones(12*256**2)",
        "sm.healpix.to_image(a)",
        "sm.healpix.to_image(a[:12])",
    ),
    "from_image": (
        "a = np.ones((12,256,256))",
        "sm.healpix.from_image(a)",
        "sm.healpix.from_image(a[:,:2,:2].copy())",
    ),
}

# The others that take arrays, one of each; `docs/decisions/memory.md` has what takes more.
OTHERS = {
    "mipmaps": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.mipmaps(i, 'latlong')",
        "sm.mipmaps(i[:64, :128], 'latlong')",
    ),
    "convert trilinear": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.convert(i, 'latlong', 'cube', size=256, filter='trilinear')",
        "sm.convert(i[:64,:128].copy(), 'latlong', 'cube', size=32, filter='trilinear')",
    ),
    "convert area": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.convert(i, 'latlong', 'cube', size=256, filter='area')",
        "sm.convert(i[:64,:128].copy(), 'latlong', 'cube', size=32, filter='area')",
    ),
    "convert skipna": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.convert(i, 'latlong', 'cube', size=256, skipna=True)",
        "sm.convert(i[:64,:128].copy(), 'latlong', 'cube', size=32, skipna=True)",
    ),
    "convert alpha": (
        "i = np.ones((1024, 2048, 4), np.float32)",
        "sm.convert(i, 'latlong', 'cube', size=256, alpha=3)",
        "sm.convert(i[:64,:128].copy(), 'latlong', 'cube', size=32, alpha=3)",
    ),
    "embed": (
        "i = np.ones((1024, 2048, 3), np.float32); v = np.ones((512,512,3),np.float32)",
        "sm.embed(v, 'perspective', i, 'latlong')",
        "sm.embed(v[:64,:64], 'perspective', i[:64,:128].copy(), 'latlong')",
    ),
    "pad": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.pad(i, 'latlong', 16)",
        "sm.pad(i[:64,:128].copy(), 'latlong', 2)",
    ),
    "convert_depth": (
        "i = np.ones((1024, 2048), np.float32)",
        "sm.convert_depth(i, 'latlong')",
        "sm.convert_depth(i[:64,:128].copy(), 'latlong')",
    ),
    "whole_map": (
        "p = np.arange(0, 12 * 512**2, 2); i = np.ones(p.size, np.float32)",
        "sm.healpix.whole_map(512, p, i)",
        "sm.healpix.whole_map(8, p[:100], i[:100])",
    ),
    "seen_pixels": (
        "i = np.ones(12 * 512**2, np.float32); i[::2] = sm.healpix.UNSEEN",
        "sm.healpix.seen_pixels(i)",
        "sm.healpix.seen_pixels(i[: 12 * 64])",
    ),
    "integrate": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.light.integrate(i, 'latlong')",
        "sm.light.integrate(i[:64,:128].copy(), 'latlong')",
    ),
    "mean": (
        "i = np.ones((1024, 2048, 3), np.float32); i[3,3]=np.nan",
        "sm.light.mean(i, 'latlong', skipna=True)",
        "sm.light.mean(i[:64,:128].copy(), 'latlong', skipna=True)",
    ),
    "energy": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "(sm.light.energy(i, 'latlong'), None)[1]",
        "sm.light.energy(i[:64,:128].copy(), 'latlong')",
    ),
    "sun": (
        "i = np.ones((1024, 2048, 3), np.float32); i[500,500]=1e5",
        "(sm.light.sun(i, 'latlong'), None)[1]",
        "sm.light.sun(i[:64,:128].copy(), 'latlong')",
    ),
    "remove_sun": (
        "i = np.ones((1024, 2048, 3), np.float32); i[500,500]=1e5",
        "sm.light.remove_sun(i, 'latlong')[0]",
        "sm.light.remove_sun(i[:64,:128].copy(), 'latlong')",
    ),
    "lights": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "(sm.light.lights(i, 'latlong', count=8), None)[1]",
        "sm.light.lights(i[:64,:128].copy(), 'latlong', count=8)",
    ),
    "Distribution": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.light.Distribution(i, 'latlong')",
        "sm.light.Distribution(i[:64,:128].copy(), 'latlong')",
    ),
    "irradiance": (
        "i = np.ones((256, 512, 3), np.float32)",
        "sm.light.irradiance(i, 'latlong', 'cube', size=4)",
        "sm.light.irradiance(i[:64,:128].copy(), 'latlong', 'cube', size=4)",
    ),
    "prefilter": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.light.prefilter(i, 'latlong', 'cube', size=8, roughness=0.1)",
        "sm.light.prefilter(i[:64,:128].copy(), 'latlong', 'cube', size=8, roughness=0.1)",
    ),
    "ws_psnr": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.light.ws_psnr(i, i, 'latlong')",
        "sm.light.ws_psnr(i[:64,:128].copy(), i[:64,:128].copy(), 'latlong')",
    ),
    "average_direction": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "(sm.light.average_direction(i, 'latlong'),None)[1]",
        "sm.light.average_direction(i[:64,:128].copy(), 'latlong')",
    ),
    "project": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.sh.project(i, 'latlong', order=8)",
        "sm.sh.project(i[:64,:128].copy(), 'latlong', order=8)",
    ),
    "evaluate": (
        "d = directions(np.float64, 500_000); c=np.ones(16)",
        "sm.sh.evaluate(c, d)",
        "sm.sh.evaluate(c, few)",
    ),
    "rotate": (
        "c=np.ones((65**2,3)); R=sm.rotation(1,2,3)",
        "sm.sh.rotate(c, R)",
        "sm.sh.rotate(c[:81], R)",
    ),
    "irradiance_at": (
        "i = np.ones((32, 64, 3), np.float32); d=directions(np.float64, 20_000)",
        "sm.light.irradiance_at(i, d, 'latlong')",
        "sm.light.irradiance_at(i, d[:100], 'latlong')",
    ),
    "shade_matcap": (
        "i = np.ones((64, 64, 3), np.float32); d=directions(np.float64,500_000)",
        "sm.light.shade_matcap(d, i)",
        "sm.light.shade_matcap(d[:1000], i)",
    ),
    "shade_environment": (
        "i = np.ones((64, 128, 3), np.float32); d=directions(np.float64,500_000)",
        "sm.light.shade_environment(d, d, [0,0,9.], i)",
        "sm.light.shade_environment(d[:1000], d[:1000], [0,0,9.], i)",
    ),
    "pack": (
        "d = directions(np.float32)",
        "sm.packing.pack(d, 'oct32')",
        "sm.packing.pack(few, 'oct32')",
    ),
    "pack fields": (
        "d = directions(np.float32)",
        "sm.packing.pack(d, 'oct16x2')",
        "sm.packing.pack(few, 'oct16x2')",
    ),
    "unpack": (
        "c = np.arange(2_000_000, dtype=np.uint32)",
        "sm.packing.unpack(c, 'oct32')",
        "sm.packing.unpack(c[:1000], 'oct32')",
    ),
    "pack_frame": (
        "d = directions(np.float64, 500_000); e=d[:,::-1].copy()",
        "sm.packing.pack_frame(d, e+[3,1,0], invalid='zero')",
        "sm.packing.pack_frame(few, few[:,::-1]+[3,1,0], invalid='zero')",
    ),
    "vec2pix": (
        "d = directions(np.float64)",
        "sm.healpix.vec2pix(64, d)",
        "sm.healpix.vec2pix(64, few)",
    ),
    "ang2pix": (
        "a = np.ones(2_000_000); b=a.copy()",
        "sm.healpix.ang2pix(64, a, b)",
        "sm.healpix.ang2pix(64, a[:1000], b[:1000])",
    ),
    "pix2vec": (
        "a = np.arange(2_000_000) % 1000",
        "sm.healpix.pix2vec(64, a)",
        "sm.healpix.pix2vec(64, a[:1000])",
    ),
    "boundaries": (
        "a = np.arange(100_000) % 1000",
        "sm.healpix.boundaries(64, a)",
        "sm.healpix.boundaries(64, a[:1000])",
    ),
    "view": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.view(i, 'latlong')",
        "sm.view(i[:64, :128], 'latlong')",
    ),
    "tonemap": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.io.tonemap(i)",
        "sm.io.tonemap(i[:64])",
    ),
    "convert of many channels": (
        "i = np.ones((4, 8, 100_000), np.float32)",
        "sm.convert(i, 'latlong', 'cube', size=2)",
        "sm.convert(i[..., :3].copy(), 'latlong', 'cube', size=2)",
    ),
    "bake_matcap": (
        "i = np.ones((256, 512, 3), np.float32)",
        "sm.light.bake_matcap(i, 'latlong', size=64)",
        "sm.light.bake_matcap(i[:64,:128].copy(), 'latlong', size=8)",
    ),
    "render": (
        "i = np.ones((256, 512, 3), np.float32)",
        "sm.ball.render(i, 'latlong', size=128)",
        "sm.ball.render(i[:64,:128].copy(), 'latlong', size=16)",
    ),
    "add_sun": (
        "i = np.ones((1024, 2048, 3), np.float32); d = np.array([0, 1, 0.1])\n"
        "s = sm.light.Sun(d, 1e-3, np.ones(3), np.zeros(3), 0.1)",
        "sm.light.add_sun(i, s, 'latlong')",
        "sm.light.add_sun(i[:64, :128].copy(), s, 'latlong')",
    ),
    "convolve": (
        "i = np.ones((256, 512, 3), np.float32)",
        "sm.light.convolve(i, 'latlong', 'cube', lobe='vmf', kappa=9, size=4)",
        "sm.light.convolve(i[:64, :128].copy(), 'latlong', 'cube', lobe='vmf', kappa=9, size=4)",
    ),
    "prefilter_chain": (
        "i = np.ones((1024, 2048, 3), np.float32)",
        "sm.light.prefilter_chain(i, 'latlong', 'cube', size=8, samples=16)",
        "sm.light.prefilter_chain(i[:64, :128].copy(), 'latlong', 'cube', size=8, samples=16)",
    ),
    "bake": (
        "i = np.ones((256, 512, 3), np.float32)",
        "(sm.light.bake(i, 'latlong', size=8, samples=16, diffuse_size=4), None)[1]",
        "sm.light.bake(i[:64, :128].copy(), 'latlong', size=8, samples=16, diffuse_size=4)",
    ),
    "window": (
        "c = np.ones((65**2, 3))",
        "sm.sh.window(c)",
        "sm.sh.window(c[:81])",
    ),
    "sh convolve": (
        "c = np.ones((65**2, 3))",
        "sm.sh.convolve(c, lobe='cosine')",
        "sm.sh.convolve(c[:81], lobe='cosine')",
    ),
    "sh convert": (
        "c = np.ones((65**2, 3))",
        "sm.sh.convert(c, dst='graphics')",
        "sm.sh.convert(c[:81], dst='graphics')",
    ),
    "canonical": (
        "c = np.arange(2_000_000, dtype=np.uint32)",
        "sm.packing.canonical(c, 'oct32')",
        "sm.packing.canonical(c[:1000], 'oct32')",
    ),
    "unpack_frame": (
        "c = np.arange(500_000, dtype=np.uint32)",
        "sm.packing.unpack_frame(c)",
        "sm.packing.unpack_frame(c[:1000])",
    ),
    "pix2ang": (
        "a = np.arange(2_000_000) % 1000",
        "sm.healpix.pix2ang(64, a)",
        "sm.healpix.pix2ang(64, a[:1000])",
    ),
    "nest2ring": (
        "a = np.arange(2_000_000) % 1000",
        "sm.healpix.nest2ring(64, a)",
        "sm.healpix.nest2ring(64, a[:1000])",
    ),
    "ring2nest": (
        "a = np.arange(2_000_000) % 1000",
        "sm.healpix.ring2nest(64, a)",
        "sm.healpix.ring2nest(64, a[:1000])",
    ),
    "neighbors": (
        "a = np.arange(300_000) % 1000",
        "sm.healpix.neighbors(64, a)",
        "sm.healpix.neighbors(64, a[:1000])",
    ),
    "npix2nside": (
        "a = np.full(100_000, 48)",
        "sm.healpix.npix2nside(a)",
        "sm.healpix.npix2nside(a[:1000])",
    ),
    "directions_to_lonlat": (
        "d = directions(np.float64, 500_000)",
        "sm.directions_to_lonlat(d)",
        "sm.directions_to_lonlat(few)",
    ),
    "lonlat_to_directions": (
        "x = uvs(np.float64, 500_000)",
        "sm.lonlat_to_directions(x)",
        "sm.lonlat_to_directions(few[:, :2])",
    ),
    "depth_to_points": (
        "i = np.ones((1024, 2048), np.float32)",
        "sm.depth_to_points(i, 'latlong')",
        "sm.depth_to_points(i[:64,:128].copy(), 'latlong')",
    ),
    "points_to_depth": (
        "d = directions(np.float32, 500_000)",
        "sm.points_to_depth(d, 'latlong', size=256)",
        "sm.points_to_depth(few, 'latlong', size=8)",
    ),
    "stitch": (
        "i = [np.ones((1024, 1024, 3), np.uint8)] * 2; c = ['angular(fov=200)'] * 2",
        "sm.cameras.stitch(i, c, 'latlong', size=1024)",
        "sm.cameras.stitch([k[:64, :64] for k in i], c, 'latlong', size=64)",
    ),
    "gains": (
        "i = [np.ones((1024, 1024, 3), np.uint8)] * 2; c = ['angular(fov=200)'] * 2",
        "sm.cameras.gains(i, c)",
        "sm.cameras.gains([k[:64, :64] for k in i], c)",
    ),
    "masks": (
        "r = sm.cameras.rig(1600, n=12)",
        "sm.cameras.masks(r)",
        "sm.cameras.masks(sm.cameras.rig(16, n=12))",
    ),
    "ud_grade": (
        "a = np.ones(12*256**2)",
        "sm.healpix.ud_grade(a, 32)",
        "sm.healpix.ud_grade(a[:12], 2)",
    ),
    "query_disc": (
        "d = np.array([1.0, 0, 0])",
        "sm.healpix.query_disc(256, d, 1.0, inclusive=True)",
        "sm.healpix.query_disc(4, d, 1.0, inclusive=True)",
    ),
    "query_polygon": (
        "d = np.eye(3) + 0.1",
        "sm.healpix.query_polygon(256, d)",
        "sm.healpix.query_polygon(4, d)",
    ),
    "interpolation_weights": (
        "a = np.linspace(0, 3, 200_000)",
        "sm.healpix.interpolation_weights(64, a, a)",
        "sm.healpix.interpolation_weights(64, a[:1000], a[:1000])",
    ),
}

# Their memory is that of what they look for in photos, and of other programs.
NOT_MEASURED = {
    "energy_file",
    "write_file",
    "camera",
    "code",
    "effect",
    "from_linear",
    "to_linear",
    "find",
    "gopro",
    "merge",
    "unwrap",
    "identify",
    "write",
    "write_dds",
    "write_ktx2",
    "lobe",
}

needs_proc = pytest.mark.skipif(
    not Path("/proc/self/clear_refs").exists(), reason="needs Linux's /proc counters"
)


def extra_bytes(prepare: str, call: str, warm: str | None) -> int:
    warm = warm or "sm.encode(few, 'latlong')"
    lines = [SETUP, prepare, f"measure(lambda: {call}, lambda: {warm})"]
    script = "\n".join(textwrap.dedent(x) for x in lines)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script], capture_output=True, text=True, timeout=120
    )
    if "clear_refs" in done.stderr and "PermissionError" in done.stderr:
        pytest.skip("/proc/self/clear_refs may not be written here")
    assert done.returncode == 0, done.stderr
    return int(done.stdout)


# Layouts of memory and types of what a plain call takes.
OTHERWISE = re.compile(
    "strided|reversed|fortran|half|integers|order|transposed|few rows|mixed|broadcast|bytes|f64"
)


@needs_proc
@some_fast("what", CALLS, fast=[what for what in CALLS if not OTHERWISE.search(what)])
def test_peak_is_inputs_and_outputs_and_two_mib(what):
    extra = extra_bytes(*CALLS[what])
    # The design's number. What passes here stays below one mebibyte: the blocks that numpy
    # converts, and what malloc keeps of them.
    assert extra <= 2 << 20, f"{what}: {extra / 2**20:.2f} MiB above in + out"


STRIDED_IMAGES = {
    "sample every other channel": (
        "d = directions(np.float32, 500_000); i = np.ones((1024, 2048, 6), np.float32)[..., ::2]",
        "sm.sample(i, d, 'latlong')",
        "sm.sample(i[:64, :128], few, 'latlong')",
    ),
    "sample three of four channels": (
        "d = directions(np.float32, 500_000); i = np.ones((2048, 4096, 4), np.uint8)[..., :3]",
        "sm.sample(i, d, 'latlong')",
        "sm.sample(i[:64, :128], few, 'latlong')",
    ),
    "convert upside down": (
        "i = np.ones((1024, 2048, 3), np.float32)[::-1]",
        "sm.convert(i, 'latlong', 'octahedral', size=512)",
        "sm.convert(i[:256, :512], 'latlong', 'octahedral', size=200)",
    ),
    "convert fortran": (
        "i = np.asfortranarray(np.ones((1024, 2048, 3), np.float32))",
        "sm.convert(i, 'latlong', 'octahedral', size=512)",
        "sm.convert(i[:256, :512], 'latlong', 'octahedral', size=200)",
    ),
}


@needs_proc
@pytest.mark.parametrize("what", STRIDED_IMAGES)
def test_a_strided_image_costs_one_copy_of_it(what):
    # The docstrings of sample and convert say so. Every image here is a view of 24 MiB.
    extra = extra_bytes(*STRIDED_IMAGES[what])
    assert extra <= 26 << 20, f"{what}: {extra / 2**20:.2f} MiB above in + out"


@needs_proc
def test_the_measure_sees_a_copy():
    # The same harness must notice a hidden copy, or the tests above say nothing.
    extra = extra_bytes("d = directions(np.float64)", "d.copy() + 0 * d", None)
    assert extra > 40e6


def stated() -> dict[str, float]:
    """Return what the page says that each call takes more, in MiB."""
    text = PAGE.read_text(encoding="utf-8").partition("<!-- memory:")[2].partition("<!-- end")[0]
    rows = re.findall(r"^\| `([^`]+)` \| [^|]+ \| (\d+) \|", text, re.M)
    return {name: float(more) for name, more in rows}


@pytest.mark.slow
@needs_proc
@pytest.mark.parametrize("what", OTHERS)
def test_peak_is_what_the_page_says(what):
    more = stated().get(what, 0)
    extra = extra_bytes(*OTHERS[what])
    # Two MiB as everywhere; a twentieth for what malloc keeps of large blocks and pages of threads.
    assert extra <= (2 << 20) + 1.05 * more * 2**20, f"{what}: {extra / 2**20:.2f} MiB"


def test_every_function_that_takes_an_array_is_measured():
    measured = {word for name in (*CALLS, *OTHERS) for word in name.split()}
    takes = set()
    for name, function in FUNCTIONS.items():
        hints = [str(p.annotation) for p in inspect.signature(function).parameters.values()]
        room, _, last = name.rpartition(".")
        if room != "plot" and any("ArrayLike" in hint for hint in hints):
            takes.add(last)
    assert takes - measured - NOT_MEASURED == set()
    assert set(stated()) <= set(OTHERS)
