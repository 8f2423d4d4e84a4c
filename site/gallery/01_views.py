"""Views out of a panorama.

What a pinhole camera sees that turns to the left and looks up: yaw, pitch, roll in degrees.
"""

import numpy as np
import spheremap as sm

sky = sm.io.read("sky.exr")
camera = sm.projection("perspective", fov=75, aspect=4 / 3)
looks = [(90, 0, 0), (0, 0, 0), (-38, 30, 0), (-90, 0, 15)]
views = [sm.convert(sky, "latlong", camera.turned(sm.rotation(*k)), size=225) for k in looks]
gap = np.full((225, 6, 3), 100.0, np.float32)
sheet = np.hstack([views[0], gap, views[1], gap, views[2], gap, views[3]])
sm.io.write("01_views.png", sm.io.tonemap(sheet))
