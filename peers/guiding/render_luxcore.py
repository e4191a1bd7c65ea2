#!/usr/bin/env python3
"""Renders a scene exported by glanz.rs with LuxCore; compare.py runs it. Engine PATHCPU with its own sampler SOBOL."""

import time

import numpy  # must precede pyluxcore, whose allocator conflicts with a later import
import pyluxcore

from exported import Clock, Scene, arguments, report


def properties(pairs):
    made = pyluxcore.Properties()
    for name, value in pairs.items():
        made.Set(pyluxcore.Property(name, value))
    return made


def filled(scene, asked):
    made = pyluxcore.Scene()
    right, up, forward, place = (scene.camera_to_world[:3, i] for i in range(4))
    # LuxCore's picture is one pixel too low; the window compensates.
    aspect, pixel = asked.width / asked.height, 2 / asked.height
    made.Parse(properties({
        "scene.camera.type": "perspective",
        "scene.camera.lookat.orig": place.tolist(),
        "scene.camera.lookat.target": (place + forward).tolist(),
        "scene.camera.up": up.tolist(),
        "scene.camera.fieldofview": scene.field_of_view,
        "scene.camera.screenwindow": [-aspect, aspect, -1 - pixel, 1 - pixel],
        "scene.camera.autovolume.enable": False,
        "scene.camera.clippingplane.enable": False,
    }))
    for mesh in scene.meshes:
        name = mesh["file"].removesuffix(".ply")
        kind, colour = ("mirror", "kr") if mesh["kind"] == "mirror" else ("matte", "kd")
        material = {f"scene.materials.{name}.type": kind, f"scene.materials.{name}.{colour}": mesh["colour"]}
        if mesh["emission"]:
            material[f"scene.materials.{name}.emission"] = mesh["emission"]
        made.Parse(properties(material))
        positions, normals, triangles = scene.arrays(mesh)
        lists = [[tuple(row) for row in array.tolist()] for array in (positions, triangles, normals)]
        made.DefineMesh(name, *lists, None, None, None)
        made.Parse(properties({f"scene.objects.{name}.shape": name, f"scene.objects.{name}.material": name}))
    return made


def main():
    asked = arguments()
    scene = Scene(asked.folder)
    pyluxcore.Init()
    settings = {
        "renderengine.type": "PATHCPU", "native.threads.count": asked.threads, "renderengine.seed": asked.seed + 1,
        "sampler.type": "SOBOL", "sampler.sobol.adaptive.strength": 0.0,
        "path.pathdepth.total": scene.max_depth + 1, "path.pathdepth.diffuse": scene.max_depth + 1,
        "path.pathdepth.glossy": scene.max_depth + 1, "path.pathdepth.specular": scene.max_depth + 1,
        "path.clamping.variance.maxvalue": 0.0,
        "film.width": asked.width, "film.height": asked.height, "film.filter.type": "NONE",
        "film.outputs.0.type": "RGB", "film.outputs.0.filename": "unused.exr",
    }
    if asked.samples:
        settings["batch.haltspp"] = [asked.samples, 0]
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties(settings), filled(scene, asked)))
    clock = Clock()
    session.Start()
    while not (clock.seconds() >= asked.seconds if asked.seconds else session.HasDone()):
        time.sleep(0.05)
        session.UpdateStats()
    session.UpdateStats()
    samples = session.GetStats().Get("stats.renderengine.pass").GetInt()
    session.Stop()
    seconds = clock.both()
    values = numpy.empty(3 * asked.width * asked.height, dtype=numpy.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, values)
    report(asked, values.reshape(asked.height, asked.width, 3)[::-1], samples, seconds, f"LuxCore {pyluxcore.Version()}")


main()
