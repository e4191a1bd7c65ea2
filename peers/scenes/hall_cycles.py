#!/usr/bin/env python3
"""Renders the hall of hall.py with Cycles, by Blender's module bpy: SCENE.json OUT.exr SIZE SAMPLES SEED THREADS tree|all"""

import json
import math
import sys

import bpy
import mathutils


def grey(reflectance):
    made = bpy.data.materials.new("grey")
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    out, surface = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    surface.inputs["Color"].default_value = (*[reflectance] * 3, 1)
    links.new(surface.outputs[0], out.inputs["Surface"])
    return made


def light(name, kind, power, place):
    """`power`: of red, green and blue."""
    data = bpy.data.lights.new(name, kind)
    strength = max(power)
    data.energy, data.color = strength, [p / strength for p in power]
    made = bpy.data.objects.new(name, data)
    made.matrix_world = place
    bpy.context.collection.objects.link(made)
    return data


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
    squares("walls", hall["walls"], grey(0.6))
    for number, (to_world, radiance) in enumerate(hall["lights"]):
        # A square from (-1, -1) to (1, 1) in z = 0 that emits towards z; Blender's emits towards -z, with power pi times area times radiance.
        place = mathutils.Matrix(to_world)
        half = place.to_scale()[0]
        place = place @ mathutils.Matrix.Diagonal((1 / half, -1 / half, -1, 1))
        data = light(f"square{number}", "AREA", [math.pi * (2 * half) ** 2 * r for r in radiance], place)
        data.shape, data.size = "SQUARE", 2 * half
    for number, (position, intensity) in enumerate(hall["points"]):
        data = light(f"point{number}", "POINT", [4 * math.pi * i for i in intensity], mathutils.Matrix.Translation(position))
        data.shadow_soft_size = 0
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
