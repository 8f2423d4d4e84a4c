"""What a map does to circles.

Tissot's indicatrices: circles of 5° on the sphere, as they come out in the image.
"""

import matplotlib.pyplot as plt
import spheremap as sm

names = ["latlong", "mollweide", "octahedral", "angular", "cube", "stereographic"]
figure, places = plt.subplots(2, 3, figsize=(10, 6), layout="constrained")
for ax, name in zip(places.flat, names, strict=True):
    sm.plot.tissot(name, ax=ax)
    ax.set_title(name)
figure.savefig("05_tissot.png", dpi=90)
