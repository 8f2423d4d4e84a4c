"""Normals in 16 bits.

The error on a ball, of one octahedral code of 16 bits: rounded plainly, by the best of four
neighbors, and with texels at centers.
"""

import matplotlib.pyplot as plt
import numpy as np
import spheremap as sm

normals = sm.directions("orthographic", 400)
inside = np.isfinite(normals[..., 0])
figure, places = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
ways = [("oct16", "nearest"), ("oct16", "precise"), ("oct16-centers", "precise")]
for ax, (name, rounding) in zip(places, ways, strict=True):
    codes = sm.packing.pack(normals[inside], name, rounding=rounding)
    back = sm.packing.unpack(codes, name)
    error = np.full(inside.shape, np.nan)
    error[inside] = np.degrees(np.arccos(np.clip((back * normals[inside]).sum(-1), -1, 1)))
    sm.plot.show(error, "orthographic", ax=ax, labels=False, vmin=0, vmax=1)
    ax.set_title(f"{name}, {rounding}: at most {np.nanmax(error):.2f}°")
figure.savefig("12_packing.png", dpi=90)
