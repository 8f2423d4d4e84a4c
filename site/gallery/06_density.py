"""How much sky a texel sees.

Steradians per unit of the image. A latlong spends half its texels on what few look at.
"""

import matplotlib.pyplot as plt
import spheremap as sm

figure, places = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
for ax, name in zip(places, ["latlong", "octahedral", "cube_equiangular"], strict=True):
    sm.plot.density_map(name, ax=ax)
    ax.set_title(name)
figure.savefig("06_density.png", dpi=90)
