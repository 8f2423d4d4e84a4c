"""A little planet.

A stereographic view of nearly everything, looking down. Outside the disk it is white.
"""

import spheremap as sm

sky = sm.io.read("sky.exr")
down = sm.projection("stereographic", fov=280).turned(sm.rotation(0, -90, 0))
planet = sm.convert(sky, "latlong", down, size=600, fill=100)
sm.io.write("02_planet.png", sm.io.tonemap(planet))
