#!/usr/bin/env python3
"""Renders a scene exported by glanz.rs with Mitsuba 3; compare.py runs it. Integrator `path`, variant `scalar_rgb`, or `llvm_ad_rgb`
with `--vectorised`.

Passes of a few samples with different seeds are averaged until the time is up. Building the scene and a first pass, which
compiles, are not counted."""

import drjit
import mitsuba
import numpy

from exported import Clock, Scene, arguments, report

PASS = 4


def colour(values):
    return {"type": "rgb", "value": values}


def described(scene, asked):
    # The x axis of Mitsuba's camera points to the left.
    to_world = scene.camera_to_world @ numpy.diag([-1, 1, 1, 1])
    world = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": scene.max_depth + 1},
        "sensor": {
            "type": "perspective", "fov": scene.field_of_view, "fov_axis": "smaller", "near_clip": 1e-3, "far_clip": 1e3,
            "to_world": mitsuba.ScalarTransform4f(to_world),
            "film": {"type": "hdrfilm", "width": asked.width, "height": asked.height, "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": PASS},
        },
    }
    for mesh in scene.meshes:
        if mesh["kind"] == "mirror":
            surface = {"type": "conductor", "material": "none", "specular_reflectance": colour(mesh["colour"])}
        else:
            surface = {"type": "diffuse", "reflectance": colour(mesh["colour"])}
        shape = {"type": "ply", "filename": str(scene.folder / mesh["file"]), "bsdf": {"type": "twosided", "surface": surface}}
        if mesh["emission"]:
            shape["emitter"] = {"type": "area", "radiance": colour(mesh["emission"])}
        world["mesh" + mesh["file"].removesuffix(".ply")] = shape
    return world


def main():
    asked = arguments("--vectorised")
    mitsuba.set_variant("llvm_ad_rgb" if asked.vectorised else "scalar_rgb")
    drjit.set_thread_count(asked.threads)
    world = mitsuba.load_dict(described(Scene(asked.folder), asked))

    def render(seed):
        return numpy.array(mitsuba.render(world, spp=PASS, seed=seed), dtype=numpy.float64)

    # Seeds of passes must differ from those of other runs.
    first = asked.seed << 16
    render(first)
    total, passes, clock = 0.0, 0, Clock()
    while clock.seconds() < asked.seconds if asked.seconds else PASS * passes < asked.samples:
        passes += 1
        total = total + render(first + passes)
    report(asked, total / passes, PASS * passes, clock.both(), f"Mitsuba {mitsuba.__version__} {mitsuba.variant()}")


main()
