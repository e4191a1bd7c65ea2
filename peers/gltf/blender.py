#!/usr/bin/env python3
"""Renders a model with Blender: blender.py MODEL.glb PICTURE.png WIDTHxHEIGHT [--samples 64] [--threads 2]; compare.py runs it.

Blender's own importer reads the model, Cycles renders it from the model's camera. All materials are emissive, so that there are no
lights and no world, and the only view transform is that to sRGB ("Standard"). Prints one line of JSON."""

import argparse
import contextlib
import json
import pathlib
import sys

import bpy

parser = argparse.ArgumentParser()
parser.add_argument("model", type=pathlib.Path)
parser.add_argument("picture", type=pathlib.Path)
parser.add_argument("size", help="pixels, such as 640x480")
parser.add_argument("--samples", type=int, default=64)
parser.add_argument("--threads", type=int, default=2)
asked = parser.parse_args()

bpy.ops.wm.read_factory_settings(use_empty=True)
# The importer prints messages, and standard output is reserved for the result.
with contextlib.redirect_stdout(sys.stderr):
    bpy.ops.import_scene.gltf(filepath=str(asked.model.resolve()))
scene = bpy.context.scene
scene.camera = next(thing for thing in scene.objects if thing.type == "CAMERA")

render, cycles, view = scene.render, scene.cycles, scene.view_settings
render.engine = "CYCLES"
render.resolution_x, render.resolution_y = map(int, asked.size.split("x"))
render.resolution_percentage = 100
render.threads_mode, render.threads = "FIXED", asked.threads
cycles.device, cycles.samples = "CPU", asked.samples
cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
cycles.use_adaptive_sampling = cycles.use_denoising = False
view.view_transform, view.look, view.exposure, view.gamma = "Standard", "None", 0, 1
render.dither_intensity = 0
render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGB"
render.image_settings.color_depth = "8"
render.filepath = str(asked.picture.resolve())
with contextlib.redirect_stdout(sys.stderr):
    bpy.ops.render.render(write_still=True)

meshes = [thing.data for thing in scene.objects if thing.type == "MESH"]
print(json.dumps({"blender": bpy.app.version_string, "meshes": len(meshes),
                  "triangles": sum(len(mesh.polygons) for mesh in meshes)}))
