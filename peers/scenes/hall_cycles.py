#!/usr/bin/env python3
"""Renders the hall of hall.py with Cycles, by Blender's module bpy: SCENE.json OUT.exr SIZE SAMPLES SEED THREADS tree|all"""

import json
import math
import sys

import bpy
import mathutils


def material(name, colour, emission=None):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    out, surface = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    surface.inputs["Color"].default_value = (*colour, 1)
    if emission:
        # The front alone emits; the rest of the light is black.
        nodes.remove(surface)
        surface, back, front = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeMath")
        strength = max(emission)
        surface.inputs["Color"].default_value = (*(e / strength for e in emission), 1)
        front.operation = "MULTIPLY_ADD"
        front.inputs[1].default_value, front.inputs[2].default_value = -strength, strength
        links.new(back.outputs["Backfacing"], front.inputs[0])
        links.new(front.outputs[0], surface.inputs["Strength"])
        made.cycles.emission_sampling = "FRONT"
    links.new(surface.outputs[0], out.inputs["Surface"])
    return made


def squares(name, quads, made):
    data = bpy.data.meshes.new(name)
    data.from_pydata([p for quad in quads for p in quad], [], [[4 * i + j for j in range(4)] for i in range(len(quads))])
    data.materials.append(made)
    bpy.context.collection.objects.link(bpy.data.objects.new(name, data))


def main():
    scene_file, out, size, samples, seed, threads, tree = sys.argv[1:]
    with open(scene_file) as file:
        hall = json.load(file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    squares("walls", hall["walls"], material("grey", [0.6] * 3))
    for number, (quad, emission) in enumerate(hall["lights"]):
        squares(f"light{number}", [quad], material(f"light{number}", [0] * 3, emission))
    for number, (position, intensity) in enumerate(hall["points"]):
        light = bpy.data.lights.new(f"point{number}", "POINT")
        # Its unit is so that a power of 4 pi is an intensity of 1.
        strength = max(intensity)
        light.energy, light.color, light.shadow_soft_size = 4 * math.pi * strength, [i / strength for i in intensity], 0
        made = bpy.data.objects.new(f"point{number}", light)
        made.location = position
        bpy.context.collection.objects.link(made)
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.clip_start, data.clip_end = "VERTICAL", 1e-3, 1e3
    data.angle_y = math.radians(hall["fov"])
    camera = bpy.data.objects.new("camera", data)
    eye, target = mathutils.Vector(hall["eye"]), mathutils.Vector(hall["target"])
    back = (eye - target).normalized()
    right = mathutils.Vector((0, 1, 0)).cross(back).normalized()
    axes = mathutils.Matrix((right, back.cross(right), back)).transposed().to_4x4()
    camera.matrix_world = mathutils.Matrix.Translation(eye) @ axes
    bpy.context.collection.objects.link(camera)
    scene = bpy.context.scene
    scene.camera = camera
    scene.world = bpy.data.worlds.new("black")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x = render.resolution_y = int(size)
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", int(threads)
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.filepath = out
    cycles.device, cycles.seed, cycles.samples = "CPU", int(seed), int(samples)
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.use_light_tree = tree == "tree"
    cycles.light_sampling_threshold = 0
    cycles.max_bounces = cycles.diffuse_bounces = int(hall["bounces"])
    bpy.ops.render.render(write_still=True)


main()
