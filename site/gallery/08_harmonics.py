"""A sky in a few numbers.

Spherical harmonics of order 1 to 16, and what remains of the sky.
"""

import matplotlib.pyplot as plt
import numpy as np
import spheremap as sm

sky = np.minimum(sm.io.read("sky.exr"), 4.0)
around = sm.directions("latlong", 128)
figure, places = plt.subplots(2, 2, figsize=(10, 5.4), layout="constrained")
for ax, order in zip(places.flat, [1, 2, 6, 16], strict=True):
    coefficients = sm.sh.project(sky, "latlong", order=order)
    image = np.maximum(sm.sh.evaluate(coefficients, around), 0)
    sm.plot.show(image, "latlong", ax=ax, labels=False)
    ax.set_title(f"order {order}: {len(coefficients)} numbers a channel")
figure.savefig("08_harmonics.png", dpi=90)
