"""Lights and samples that stand for a sky.

32 directional lights, each the size of its light, and 500 directions drawn by importance.
"""

import matplotlib.pyplot as plt
import numpy as np
import spheremap as sm

sky = sm.io.read("sky.exr")
lights = sm.light.lights(sky, "latlong", count=32)
drawn = sm.light.Distribution(sky, "latlong").sample(np.random.default_rng(1).random((500, 2)))[0]

figure, places = plt.subplots(1, 2, figsize=(11, 3.2), layout="constrained")
for ax in places:
    sm.plot.show(sky, "latlong", ax=ax, labels=False, exposure=-1)
size = sm.projection("latlong").shape(sky.shape[:2])
x, y = sm.directions_to_pixels(lights.directions, "latlong", size).T
places[0].scatter(x, y, 60 * lights.irradiance.mean(-1) ** 0.5, "gold", edgecolors="black")
x, y = sm.directions_to_pixels(drawn, "latlong", size).T
places[1].scatter(x, y, 3, "red")
figure.savefig("09_lights.png", dpi=90)
