"""Blender's own importer and one of its renderers.   blender --background --python blender.py -- SCENE.glb SHOT.png ENGINE
Suns get the file's strength, whose unit is not Blender's; shadows and light from other patches are left out."""
import sys

import addon_utils
import bpy
import numpy

numpy.bool = bool  # the importer of 3.4 uses this name, which Debian's NumPy no longer has
source, target, engine = sys.argv[-3:]
bpy.ops.wm.read_factory_settings(use_empty=True)
addon_utils.enable("io_scene_gltf2")
bpy.ops.import_scene.gltf(filepath=source)
for light in bpy.data.lights:
    light.energy = 2.8
    light.use_shadow = engine == "CYCLES"
scene = bpy.context.scene
scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA" and o.data.type == "ORTHO")
render = scene.render
render.engine, render.filepath = engine, target
render.resolution_x, render.resolution_y = 800, 600
scene.view_settings.view_transform = "Standard"
scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.use_denoising = 200, 0, False
scene.eevee.taa_render_samples = 1  # in software each takes seconds
scene.eevee.use_soft_shadows = False
bpy.ops.render.render(write_still=True)
