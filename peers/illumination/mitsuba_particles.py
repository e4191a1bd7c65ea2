"""Particle tracing with Mitsuba 3 through the room of document 000.

Emission, intersection (Embree) and scattering are Mitsuba's, in its vectorised variant; this module only adds up the arriving
particles. Mitsuba's own particle tracer connects them to cameras, which a wall is not.
"""

import time
from collections.abc import Iterator

import drjit
import mitsuba
import numpy

import mirror
from lux_map import Array, LuxMap

mitsuba.set_variant("llvm_ad_rgb")

# Particles per step; sums of more would exceed the 24 bits of its numbers.
STEP = 1 << 21

# Largest number of surfaces that a particle hits. After so many mirrors its power is negligible.
DEPTH = 64


def grey(value: float) -> dict[str, object]:
    return {"type": "rgb", "value": [value] * 3}


def triangles(name: str, mesh: mirror.Mesh, surface: dict[str, object]) -> mitsuba.Mesh:
    """A mesh with the same material on both sides."""
    properties = mitsuba.Properties()
    properties["mesh_bsdf"] = mitsuba.load_dict({"type": "twosided", "surface": surface})
    smooth = mesh.normals is not None
    shape = mitsuba.Mesh(name, len(mesh.vertices), len(mesh.faces), has_vertex_normals=smooth, props=properties)
    parameters = mitsuba.traverse(shape)
    parameters["vertex_positions"] = mesh.vertices.astype(numpy.float32).ravel()
    if mesh.normals is not None:
        parameters["vertex_normals"] = mesh.normals.astype(numpy.float32).ravel()
    parameters["faces"] = mesh.faces.ravel()
    parameters.update()
    return shape


def black_hood() -> mitsuba.Mesh:
    vertices = numpy.concatenate(mirror.hood())
    first = 4 * numpy.arange(len(vertices) // 4, dtype=numpy.uint32)[:, None]
    faces = numpy.concatenate([first + numpy.array(corners, dtype=numpy.uint32) for corners in ([0, 1, 2], [0, 2, 3])])
    return triangles("hood", mirror.Mesh(vertices, None, faces), {"type": "diffuse", "reflectance": grey(0.0)})


def room(mesh: mirror.Mesh, hooded: bool) -> mitsuba.Scene:
    surface = {"type": "conductor", "material": "none", "specular_reflectance": grey(mirror.REFLECTANCE)}
    half = mirror.SIZE / 2
    to_world = mitsuba.ScalarTransform4f().translate([half] * 3).scale(half)
    lamp = {
        "type": "sphere",
        "center": list(mirror.LAMP),
        "radius": mirror.RADIUS,
        "bsdf": {"type": "diffuse", "reflectance": grey(mirror.LAMP_REFLECTANCE)},
        "emitter": {"type": "area", "radiance": grey(mirror.RADIANCE)},
    }
    walls = {"type": "cube", "to_world": to_world, "bsdf": {"type": "diffuse", "reflectance": grey(0.0)}}
    things = {"type": "scene", "mirror": triangles("mirror", mesh, surface), "lamp": lamp, "walls": walls}
    return mitsuba.load_dict(things | ({"hood": black_hood()} if hooded else {}))


def cell(position: mitsuba.Point3f, cells: int) -> mitsuba.UInt32:
    """Index of the cell of a point on the walls."""
    share = position / mirror.SIZE
    near = [drjit.minimum(x, 1 - x) for x in share]
    axis = drjit.select(near[0] < near[1], 0, 1)
    axis = drjit.select(drjit.minimum(near[0], near[1]) < near[2], axis, 2)
    along = drjit.select(axis == 0, share.x, drjit.select(axis == 1, share.y, share.z))
    fast = drjit.select(axis == 0, share.y, share.x)
    slow = drjit.select(axis == 2, share.y, share.z)
    wall = 2 * axis + drjit.select(along > 0.5, 1, 0)
    column, row = (drjit.clip(mitsuba.Int32(x * cells), 0, cells - 1) for x in (fast, slow))
    return mitsuba.UInt32((wall * cells + row) * cells + column)


@drjit.syntax
def step(
    scene: mitsuba.Scene, sampler: mitsuba.Sampler, walls: mitsuba.ShapePtr, cells: int
) -> tuple[mitsuba.Float, mitsuba.Float]:
    """Lumens by cell, summed over the particles of a step as if each were the only one, and the sums of their squares."""
    sums, squares = (drjit.zeros(mitsuba.Float, 6 * cells * cells) for _ in range(2))
    active = mitsuba.Bool(True)
    ray, power, _ = scene.sample_emitter_ray(0, sampler.next_1d(), sampler.next_2d(), sampler.next_2d(), active)
    depth = mitsuba.UInt32(0)
    while active:
        at = scene.ray_intersect(ray, active)
        arrived = active & (at.shape == walls)
        lumens = mirror.EFFICACY * mitsuba.luminance(power)
        number = cell(at.p, cells)
        drjit.scatter_reduce(drjit.ReduceOp.Add, sums, lumens, number, arrived)
        drjit.scatter_reduce(drjit.ReduceOp.Add, squares, lumens * lumens, number, arrived)
        active &= at.is_valid() & ~arrived & (depth < DEPTH)
        context = mitsuba.BSDFContext(mitsuba.TransportMode.Importance)
        sampled, weight = at.bsdf(ray).sample(context, at, sampler.next_1d(active), sampler.next_2d(active), active)
        power *= weight
        ray = at.spawn_ray(at.to_world(sampled.wo))
        depth += 1
        active &= mitsuba.luminance(power) > 0
    return sums, squares


class Particles:
    """A room that is traced several times; its kernels are compiled on construction."""

    def __init__(self, mesh: mirror.Mesh, hooded: bool, cells: int, threads: int) -> None:
        drjit.set_thread_count(threads)
        self.cells = cells
        self.scene = room(mesh, hooded)
        is_wall = [shape.id() == "walls" for shape in self.scene.shapes()]
        self.walls = mitsuba.ShapePtr(self.scene.shapes()[is_wall.index(True)])
        self.sampler = mitsuba.load_dict({"type": "independent"})
        next(self.steps(0))

    def steps(self, seed: int) -> Iterator[tuple[Array, Array]]:
        """Sums of successive steps."""
        number = seed << 16
        while True:
            self.sampler.seed(number, STEP)
            sums, squares = step(self.scene, self.sampler, self.walls, self.cells)
            drjit.eval(sums, squares)
            yield numpy.array(sums, dtype=numpy.float64), numpy.array(squares, dtype=numpy.float64)
            number += 1

    def trace(self, particles: int, seed: int) -> tuple[list[LuxMap], int, float]:
        """Maps of at least `particles` particles, their actual number, and processor seconds."""
        begun = time.process_time()
        sums = squares = numpy.zeros(6 * self.cells**2)
        count = 0
        for more, more_squares in self.steps(seed):
            sums, squares, count = sums + more, squares + more_squares, count + STEP
            if count >= particles:
                break
        seconds = time.process_time() - begun
        return mirror.maps(sums / count, squares / count**2, count, self.cells), count, seconds
