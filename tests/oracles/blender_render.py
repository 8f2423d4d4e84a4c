"""Blender's Cycles looks into an environment texture. Run by a Python that has bpy.

Arguments: the projection as Blender calls it, the image, a folder, and the side of the pictures.
Writes 0.exr, 1.exr, ... of a camera of 90° turned as in VIEWS.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

# Degrees about x, then about z; without either a camera looks along -z, y up.
VIEWS = [(90, 0), (90, 90), (90, 180), (90, 270), (180, 0), (0, 0)]


def main(projection: str, image: str, folder: str, size: int) -> None:
    """Render all views."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    # A sample anywhere in a pixel but at its center would be another direction.
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 0.01
    scene.view_settings.view_transform = "Raw"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"

    world = scene.world = bpy.data.worlds.new("world")
    tree = world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(image)
    texture.image.colorspace_settings.name = "Non-Color"
    texture.projection = projection
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])

    lens = bpy.data.cameras.new("camera")
    lens.angle = math.radians(90)
    camera = scene.camera = bpy.data.objects.new("camera", lens)
    scene.collection.objects.link(camera)
    for k, (about_x, about_z) in enumerate(VIEWS):
        camera.rotation_euler = (math.radians(about_x), 0, math.radians(about_z))
        scene.render.filepath = str(Path(folder) / f"{k}.exr")
        bpy.ops.render.render(write_still=True)
    print("Blender", bpy.app.version_string)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4]))
