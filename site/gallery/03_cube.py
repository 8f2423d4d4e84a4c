"""A skybox, as a cross.

With these axes it reads as seen from inside; OpenGL's faces, the default, are mirrored. Without a
layout it is an array of six images, and `"cube:unity"` is a program's own.
"""

import spheremap as sm

sky = sm.io.read("sky.exr")
cross = sm.projection("cube", layout="cross", axes="+x -y -z")
sm.io.write("03_cube.png", sm.io.tonemap(sm.convert(sky, "latlong", cross, size=200, fill=100)))
