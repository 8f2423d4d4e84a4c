"""Run by test_tensor_peers.py, apart: mitsuba's envmap, and the gradient of its texels.

python mitsuba_gradient.py given.npz found.npz
"""

from __future__ import annotations

import sys

import numpy as np


def main(given: str, found: str) -> None:
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    import drjit as dr

    with np.load(given) as arrays:
        image, directions, weights = (arrays[name] for name in ("image", "directions", "weights"))
    emitter = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(image)})
    parameters = mi.traverse(emitter)
    data = mi.TensorXf(parameters["data"])
    dr.enable_grad(data)
    parameters["data"] = data
    parameters.update()
    si = dr.zeros(mi.SurfaceInteraction3f, len(directions))
    # Asked from inside: wi points away from the light that arrives.
    si.wi = mi.Vector3f(*(mi.Float(np.ascontiguousarray(column)) for column in -directions.T))
    seen = emitter.eval(si)
    total = sum(dr.sum(one * mi.Float(row)) for one, row in zip(seen, weights, strict=True))
    dr.backward(total)
    np.savez(found, values=np.array(seen).reshape(3, -1), gradient=np.array(dr.grad(data)))


if __name__ == "__main__":
    main(*sys.argv[1:])
