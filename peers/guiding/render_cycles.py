#!/usr/bin/env python3
"""Renders a scene exported by glanz.rs with Cycles, by Blender's module bpy; compare.py runs it. `--guided`: with path guiding.

Clamping, filters of glossy paths and denoising are off. The time limit is Cycles' own; the time counted is that of the whole call
minus that of the same call with one sample per pixel."""

import math
import pathlib
import tempfile

import bpy
import mathutils
import numpy

from exported import Clock, Scene, arguments, report

ENOUGH = 1 << 24


def material(mesh):
    """A diffuse surface or a mirror, which emits on the front only."""
    made = bpy.data.materials.new(mesh["file"])
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    surface = nodes.new("ShaderNodeBsdfAnisotropic" if mesh["kind"] == "mirror" else "ShaderNodeBsdfDiffuse")
    surface.inputs["Color"].default_value = (*mesh["colour"], 1)
    surface.inputs["Roughness"].default_value = 0
    out = surface.outputs[0]
    if mesh["emission"]:
        strength = max(mesh["emission"])
        emission, back = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeNewGeometry")
        emission.inputs["Color"].default_value = (*(e / strength for e in mesh["emission"]), 1)
        front = nodes.new("ShaderNodeMath")
        front.operation = "MULTIPLY_ADD"
        front.inputs[1].default_value, front.inputs[2].default_value = -strength, strength
        links.new(back.outputs["Backfacing"], front.inputs[0])
        links.new(front.outputs[0], emission.inputs["Strength"])
        both = nodes.new("ShaderNodeAddShader")
        links.new(out, both.inputs[0])
        links.new(emission.outputs[0], both.inputs[1])
        out = both.outputs[0]
        made.cycles.emission_sampling = "FRONT"
    links.new(out, output.inputs["Surface"])
    return made


def put(scene, mesh):
    positions, normals, triangles = scene.arrays(mesh)
    data = bpy.data.meshes.new(mesh["file"])
    data.from_pydata(positions, [], triangles)
    data.polygons.foreach_set("use_smooth", numpy.ones(len(data.polygons), dtype=bool))
    data.normals_split_custom_set_from_vertices(normals)
    data.materials.append(material(mesh))
    bpy.context.collection.objects.link(bpy.data.objects.new(mesh["file"], data))


def camera(scene):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(scene.field_of_view)
    data.clip_start, data.clip_end = 1e-3, 1e3
    made = bpy.data.objects.new("camera", data)
    # Blender's camera looks along -z.
    made.matrix_world = mathutils.Matrix((scene.camera_to_world @ numpy.diag([1, 1, -1, 1])).tolist())
    bpy.context.collection.objects.link(made)
    bpy.context.scene.camera = made


def settings(scene, asked):
    render, cycles = bpy.context.scene.render, bpy.context.scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = asked.width, asked.height, 100
    render.threads_mode, render.threads = "FIXED", asked.threads
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    cycles.device, cycles.seed = "CPU", asked.seed
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    for name in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, name + "_bounces", scene.max_depth)
    cycles.use_guiding = cycles.use_surface_guiding = asked.guided
    return cycles


def rendered():
    """Wall-clock and processor seconds of rendering a picture."""
    clock = Clock()
    bpy.ops.render.render(write_still=True)
    return clock.both()


def main():
    asked = arguments("--guided")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = Scene(asked.folder)
    cycles = settings(scene, asked)
    world = bpy.data.worlds.new("night")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    bpy.context.scene.world = world
    camera(scene)
    for mesh in scene.meshes:
        put(scene, mesh)
    with tempfile.TemporaryDirectory() as folder:
        name = pathlib.Path(folder) / "picture.exr"
        bpy.context.scene.render.filepath = str(name)
        cycles.samples = 1
        short = rendered()
        cycles.samples, cycles.time_limit = asked.samples or ENOUGH, asked.seconds or 0
        seconds = [long - short for long, short in zip(rendered(), short)]
        picture = bpy.data.images.load(str(name))
        picture.colorspace_settings.name = "Non-Color"
        values = numpy.empty(4 * asked.width * asked.height, dtype=numpy.float32)
        picture.pixels.foreach_get(values)
    values = values.reshape(asked.height, asked.width, 4)[::-1]
    report(asked, values, asked.samples, seconds, f"Blender {bpy.app.version_string} Cycles")


main()
