"""A mirror that grows rough.

Levels of a chain that is prefiltered with GGX, as engines load it, and irradiance at the end.
"""

import matplotlib.pyplot as plt
import spheremap as sm

sky = sm.io.read("sky.exr")
chain = sm.light.prefilter_chain(sky, "latlong", "octahedral", size=128, levels=5)
levels = [*chain, sm.light.irradiance(sky, "latlong", "octahedral", size=64) / 3.1416]
figure, places = plt.subplots(1, 6, figsize=(11, 2.2), layout="constrained")
for k, (ax, level) in enumerate(zip(places, levels, strict=True)):
    sm.plot.show(sm.convert(level, "octahedral", "sphere", size=128), "sphere", ax=ax, labels=False)
    ax.set_title(f"level {k}" if k < 5 else "diffuse")
figure.savefig("07_rough.png", dpi=90)
