"""Whole skies of equal area.

Parallels and meridians by `graticule=`, on any map. The first two are ellipses; the last
is a square.
"""

import matplotlib.pyplot as plt
import spheremap as sm

sky = sm.io.read("sky.exr")
figure, places = plt.subplots(2, 2, figsize=(10, 6), layout="constrained")
for ax, name in zip(places.flat, ["mollweide", "hammer", "sinusoidal", "equal_area"], strict=True):
    image = sm.convert(sky, "latlong", name, size=400)
    sm.plot.show(image, name, ax=ax, graticule=30, labels=False)
    ax.set_title(name)
figure.savefig("04_graticule.png", dpi=90)
