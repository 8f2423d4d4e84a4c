"""No lost suns.

A sun of one texel, in forty places, on its way into a cube of 16²: how much of its
light arrives, by way of converting.
"""

import matplotlib.pyplot as plt
import numpy as np
import spheremap as sm

weight, texel = sm.solid_angle("cube", 16), sm.solid_angle("latlong", 128)
arrived = {"nearest": [], "bilinear": [], "area": []}
for row, column in np.random.default_rng(2).integers([16, 0], [112, 256], (40, 2)):
    sky = np.zeros((128, 256))
    sky[row, column] = 1 / texel[row, column]
    for name, sums in arrived.items():
        antialias = {} if name == "area" else {"antialias": False}
        cube = sm.convert(sky, "latlong", "cube", size=16, filter=name, **antialias)
        sums.append((cube * weight).sum())
figure, ax = plt.subplots(figsize=(8, 3.2), layout="constrained")
for k, (name, sums) in enumerate(arrived.items()):
    ax.scatter(sums, np.full(40, k) + np.linspace(-0.3, 0.3, 40), 12, label=name)
ax.set(yticks=range(3), yticklabels=arrived, xlabel="light that arrives; 1 is all of it")
figure.savefig("10_sun.png", dpi=90)
