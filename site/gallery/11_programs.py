"""One sky, as four programs store it.

`convert` keeps up up; the arrays differ. `sm.align.identify` finds out which is which.
"""

import matplotlib.pyplot as plt
import spheremap as sm

sky = sm.io.read("sky.exr")
figure, places = plt.subplots(2, 2, figsize=(10, 5.4), layout="constrained")
for ax, program in zip(places.flat, ["blender", "mitsuba", "unreal", "healpy"], strict=True):
    image = sm.convert(sky, "latlong", f"latlong:{program}", size=256)
    sm.plot.show(image, f"latlong:{program}", ax=ax)
    ax.set_title(program)
figure.savefig("11_programs.png", dpi=90)
