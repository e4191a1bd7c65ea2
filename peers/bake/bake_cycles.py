#!/usr/bin/env python3
"""Bakes the model of compare.py with Cycles, by Blender's module bpy: MODEL.npz OUT.npy SIDE SAMPLES SEED THREADS

Prints the wall-clock and processor seconds of the bake; OUT has its irradiance. Clamping and denoising are off, and lights are
sampled however weak; bounces end with Russian roulette."""

import json
import math
import resource
import sys
import time

import bpy
import numpy

BOUNCES = 64


def material(name, colours, fields, radiance, image):
    """A diffuse surface of one colour, or of a checkerboard of two over the parameters of the surface; `radiance`: of its front."""
    diffuse = bpy.data.materials.new(name)
    diffuse.use_nodes = True
    nodes, links = diffuse.node_tree.nodes, diffuse.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    surface = nodes.new("ShaderNodeBsdfDiffuse")
    surface.inputs["Color"].default_value = (*colours[0], 1)
    if len(colours) == 2:
        parameters, cells = nodes.new("ShaderNodeUVMap"), nodes.new("ShaderNodeVectorMath")
        parameters.uv_map, cells.operation = "parameters", "MULTIPLY_ADD"
        # Blender's board is three-dimensional; in this layer of it the first colour has the even cells.
        cells.inputs[1].default_value, cells.inputs[2].default_value = (*fields, 0), (0, 0, 1.5)
        checker = nodes.new("ShaderNodeTexChecker")
        checker.inputs["Scale"].default_value = 1
        for socket, colour in zip(("Color1", "Color2"), colours):
            checker.inputs[socket].default_value = (*colour, 1)
        links.new(parameters.outputs[0], cells.inputs[0])
        links.new(cells.outputs[0], checker.inputs["Vector"])
        links.new(checker.outputs["Color"], surface.inputs["Color"])
    out = surface.outputs[0]
    if max(radiance) > 0:
        emission, back = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeNewGeometry")
        emission.inputs["Color"].default_value = (*(x / max(radiance) for x in radiance), 1)
        front, both = nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeAddShader")
        front.operation = "MULTIPLY_ADD"
        front.inputs[1].default_value, front.inputs[2].default_value = -max(radiance), max(radiance)
        links.new(back.outputs["Backfacing"], front.inputs[0])
        links.new(front.outputs[0], emission.inputs["Strength"])
        links.new(out, both.inputs[0])
        links.new(emission.outputs[0], both.inputs[1])
        out = both.outputs[0]
        diffuse.cycles.emission_sampling = "FRONT"
    links.new(out, output.inputs["Surface"])
    target = nodes.new("ShaderNodeTexImage")
    target.image = image
    nodes.active = target
    return diffuse


def add(name, model, chosen, materials):
    """An object of the chosen triangles."""
    corners = model["triangles"][chosen]
    data = bpy.data.meshes.new(name)
    data.vertices.add(3 * len(corners))
    data.vertices.foreach_set("co", model["positions"][corners].ravel())
    data.loops.add(3 * len(corners))
    data.loops.foreach_set("vertex_index", numpy.arange(3 * len(corners), dtype=numpy.int32))
    data.polygons.add(len(corners))
    data.polygons.foreach_set("loop_start", numpy.arange(0, 3 * len(corners), 3, dtype=numpy.int32))
    for layer in ("parameters", "texels"):
        data.uv_layers.new(name=layer).data.foreach_set("uv", model[layer][corners].ravel())
    data.uv_layers["texels"].active = data.uv_layers["texels"].active_render = True
    for one in materials:
        data.materials.append(one)
    data.polygons.foreach_set("material_index", model["materials"][chosen].astype(numpy.int32))
    data.polygons.foreach_set("use_smooth", numpy.ones(len(corners), dtype=bool))
    data.update(calc_edges=True)
    data.normals_split_custom_set(model["normals"][corners].reshape(-1, 3))
    added = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(added)
    return added


def main():
    file, out, side, samples, seed, threads = sys.argv[1:]
    model = numpy.load(file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    image = bpy.data.images.new("irradiance", int(side), int(side), float_buffer=True, is_data=True)
    described = json.loads(str(model["described"]))
    materials = [material(m["name"], m["colours"], m["fields"], m["radiance"], image) for m in described]
    lit = model["lit"]
    baked = add("lit", model, lit, materials)
    if not lit.all():
        add("dark", model, ~lit, materials)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("black")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.threads_mode, render.threads = "FIXED", int(threads)
    cycles.device, cycles.seed, cycles.samples = "CPU", int(seed), int(samples)
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0
    cycles.max_bounces = cycles.diffuse_bounces = BOUNCES
    bpy.context.view_layer.objects.active = baked
    baked.select_set(True)
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF)
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, margin=2, margin_type="EXTEND",
                        use_clear=True, target="IMAGE_TEXTURES")
    after = resource.getrusage(resource.RUSAGE_SELF)
    values = numpy.empty(4 * int(side) ** 2, dtype=numpy.float32)
    image.pixels.foreach_get(values)
    # Cycles divides by pi: a diffuse white surface of this irradiance has this radiance.
    numpy.save(out, math.pi * values.reshape(int(side), int(side), 4)[..., :3])
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(json.dumps({"seconds": time.perf_counter() - start, "processor_seconds": used,
                      "version": f"Blender {bpy.app.version_string}"}), flush=True)


main()
