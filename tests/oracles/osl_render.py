"""Cycles shades a plane, a pixel a row of numbers. Run by a Python that has bpy.

Reads lines "shader.osl picture.exr", compiles the shader with Blender's oslc, renders, and says
"rendered". A pixel (i, j) from the lower left sees the plane's P at (i + 0.5, j + 0.5, 0).
"""

from __future__ import annotations

import sys
from pathlib import Path

SIZE = 256


def scene() -> tuple[object, object, object]:
    """Return the scene, its material's tree and the node of the shader."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 0.01
    scene.view_settings.view_transform = "Raw"
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "NONE"

    lens = bpy.data.cameras.new("camera")
    lens.type = "ORTHO"
    lens.ortho_scale = SIZE
    camera = scene.camera = bpy.data.objects.new("camera", lens)
    camera.location = (SIZE / 2, SIZE / 2, 1)
    scene.collection.objects.link(camera)

    mesh = bpy.data.meshes.new("plane")
    corners = [(-1, -1, 0), (SIZE + 1, -1, 0), (SIZE + 1, SIZE + 1, 0), (-1, SIZE + 1, 0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    scene.collection.objects.link(bpy.data.objects.new("plane", mesh))
    material = bpy.data.materials.new("material")
    mesh.materials.append(material)
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeScript")
    node.mode = "EXTERNAL"
    return scene, tree, node


def main() -> None:
    """Render until nothing more is asked for."""
    import bpy

    # What Blender asks about shaders with lies where its own Python would find it.
    sys.path.extend(
        map(str, Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/*/site-packages"))
    )
    import _cycles

    where, tree, node = scene()
    surface = tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]
    for line in sys.stdin:
        shader, picture = line.split()
        compiled = shader.replace(".osl", ".oso")
        if not _cycles.osl_compile(shader, compiled):
            raise SystemExit(f"oslc refuses {shader}")
        node.filepath = compiled
        tree.links.new(node.outputs[0], surface)
        where.render.filepath = picture
        bpy.ops.render.render(write_still=True)
        print("rendered", flush=True)


if __name__ == "__main__":
    main()
