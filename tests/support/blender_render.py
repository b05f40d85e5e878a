"""Render frames of a USD film as Blender shows it: for Blender's own Python, which has ``bpy`` and nothing of ours.

python blender_render.py FILM.usdc FOLDER FRAME... writes FOLDER/FRAME.png for each frame, and FOLDER/objects.json.
"""

import json
import sys
from pathlib import Path

import bpy


def main(film, folder, *frames):
    """The start-up file without its objects, the film imported with all defaults, and its camera."""
    bpy.ops.wm.read_factory_settings(use_empty=False)
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    bpy.ops.wm.usd_import(filepath=film)
    Path(folder, "objects.json").write_text(json.dumps({thing.name: thing.type for thing in bpy.data.objects}))
    scene = bpy.context.scene
    scene.camera = bpy.data.objects["camera"]
    # Cycles on the CPU needs no display
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 8
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 240, 160, 100
    scene.render.image_settings.file_format = "PNG"
    for frame in frames:
        scene.frame_set(int(frame))
        scene.render.filepath = str(Path(folder, f"{frame}.png"))
        bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
