"""The scenes. Each function fills a scene; its first line describes it."""

from collections.abc import Callable

import drjit
import mitsuba
import numpy

from languages import (Part, Scene, angular, box, coated_diffuse, conductor, constant, correlated, cylinder, dielectric, diffuse, diffuse_transmission,
                       disk, distant, environment, fog, instances, mesh, mix, plastic, point, pointing, rectangle, rgb, sphere, spot,
                       thin_dielectric, both_sides, colour_of, transform, with_bumps, with_normals)

SCENES: dict[str, Callable[[Scene], None]] = {}

GOLD = (0.16, 0.42, 1.4), (3.9, 2.4, 1.75)


def scene(build: Callable[[Scene], None]) -> Callable[[Scene], None]:
    SCENES[build.__name__.replace("_", "-")] = build
    return build


# Common parts


def lamp(height: float = 4, half: float = 1, emission: object = (10, 9, 8), x: float = 0) -> Part:
    return rectangle(diffuse(0), transform(scale=(half, half, 1), rotate=[((1, 0, 0), 90)], translate=(x, height, 0.5)), emission=emission)


def floor(material: Part | None = None, half: float = 5) -> Part:
    return rectangle(material or diffuse((0.5, 0.45, 0.4)), transform(scale=(half, half, 1), rotate=[((1, 0, 0), -90)]))


def wall(material: Part | None = None) -> Part:
    return rectangle(material or diffuse((0.3, 0.5, 0.6)), transform(scale=(5, 3, 1), translate=(0, 3, -3)))


def stage(s: Scene, emission: object = (10, 9, 8), **camera: object) -> None:
    """A floor, a wall behind, a lamp above, and a dim sky."""
    s.look_at((0.4, 2.4, 6), (0, 0.8, 0), **camera)
    s.add(floor(), wall(), lamp(emission=emission), constant((0.2, 0.25, 0.3)))


def three_balls(s: Scene, materials: list[Part]) -> None:
    for number, material in enumerate(materials):
        s.add(sphere(material, (1.7 * (number - 1), 0.8, 0.3 * number), 0.8))


def sky(directions: numpy.ndarray) -> numpy.ndarray:
    """Smooth, without symmetry, brighter to one side; 0.1 to about 5."""
    x, y, z = directions[..., 0], directions[..., 1], directions[..., 2]
    glow = 4 * numpy.exp(8 * (0.48 * x + 0.6 * y + 0.64 * z - 1))
    return numpy.stack([0.3 + glow + 0.2 * x, 0.4 + 0.8 * glow + 0.2 * y, 0.5 + 0.5 * glow + 0.3 * z * y], axis=-1)


def colours(width: int, height: int) -> numpy.ndarray:
    """A picture without symmetry, 0.1 to 0.9."""
    return numpy.random.default_rng(7).uniform(0.1, 0.9, (height, width, 3))


# Materials


@scene
def rough_glass(s: Scene) -> None:
    """Balls of rough glass, alpha 0.1, 0.3 and 0.6"""
    stage(s)
    three_balls(s, [dielectric(1.5, a) for a in (0.1, 0.3, 0.6)])


@scene
def rough_glass_pane(s: Scene) -> None:
    """A slab of rough glass, alpha 0.15, with Mitsuba's own masking"""
    stage(s)
    s.add(box(dielectric(1.5, 0.15, own_masking=True), transform(scale=(1.3, 0.9, 0.2), rotate=[((0, 1, 0), 20)], translate=(0, 1, 1))))


@scene
def rough_metals(s: Scene) -> None:
    """Balls of gold, alpha 0.05, 0.3 and 0.9"""
    stage(s)
    three_balls(s, [conductor(*GOLD, a) for a in (0.05, 0.3, 0.9)])


@scene
def rough_metal_plate(s: Scene) -> None:
    """A plate of gold, alpha 0.2, with Mitsuba's own masking"""
    stage(s)
    s.add(rectangle(conductor(*GOLD, 0.2, own_masking=True), transform(scale=(2, 1, 1), rotate=[((1, 0, 0), -50)], translate=(0, 0.8, 1))))


@scene
def anisotropic_metals(s: Scene) -> None:
    """Plates of brushed gold, along and across, and a plate of anisotropic glass"""
    stage(s)
    for number, material in enumerate([conductor(*GOLD, (0.05, 0.4)), conductor(*GOLD, (0.4, 0.05)), dielectric(1.5, (0.1, 0.4))]):
        s.add(rectangle(material, transform(scale=(0.8, 0.8, 1), rotate=[((1, 0, 0), -50)], translate=(1.8 * (number - 1), 0.7, 1))))


@scene
def smooth(s: Scene) -> None:
    """A smooth metal, a glass ball and a thin pane"""
    stage(s)
    s.add(sphere(conductor(*GOLD), (-1.7, 0.8, 0), 0.8), sphere(dielectric(1.5), (0, 0.8, 0.5), 0.8),
          rectangle(thin_dielectric(1.5), transform(scale=(0.7, 0.8, 1), rotate=[((0, 1, 0), -30)], translate=(1.7, 0.8, 0.6))))


@scene
def coated(s: Scene) -> None:
    """Diffuse balls under smooth coats of index 1.3, 1.5 and 1.9"""
    stage(s)
    three_balls(s, [coated_diffuse((0.8, 0.4, 0.1), eta) for eta in (1.3, 1.5, 1.9)])


@scene
def coated_rough(s: Scene) -> None:
    """Diffuse balls under rough coats, alpha 0.05, 0.15 and 0.3"""
    stage(s)
    three_balls(s, [coated_diffuse((0.8, 0.4, 0.1), 1.5, a) for a in (0.05, 0.15, 0.3)])


@scene
def coated_layers(s: Scene) -> None:
    """A coated plate; in Mitsuba a sheet of glass 2 mm above a diffuse one"""
    reflectance, eta = (0.8, 0.4, 0.1), 1.5
    # The picture shows the middle alone: light leaves between the sheets at the border.
    s.look_at((0, 4, 6), (0, 0, 0), fov=5)
    s.add(environment(s, sky, 512))
    lying = transform(scale=(1, 1, 1), rotate=[((1, 0, 0), -90)])
    pair = rectangle(coated_diffuse(reflectance, eta), lying)
    base = rectangle(diffuse(reflectance), lying)
    sheet = rectangle(dielectric(eta), transform(rotate=[((1, 0, 0), -90)], translate=(0, 2e-3, 0)))
    s.add(Part(pair.pbrt, {"base": base.mitsuba, "sheet": sheet.mitsuba}))


@scene
def principled(s: Scene) -> None:
    """Glanz's glossy dielectric as roughplastic, metal as roughconductor, a blend of both"""
    stage(s)
    colour, roughness = (0.7, 0.3, 0.15), 0.5
    k = [2 * (c / (1 - c)) ** 0.5 for c in colour]
    alpha = roughness**2
    text = f'Material "principled" {rgb("basecolor", colour)} "float roughness" {roughness} "bool multiplescattering" false "float metallic" '
    glossy = both_sides(plastic(colour, 1.5, alpha, False))
    metal = conductor(1.0, k, alpha).mitsuba
    three_balls(s, [Part(text + "0", glossy), Part(text + "1", metal),
                    Part(text + "0.4", {"type": "blendbsdf", "weight": 0.4, "first": glossy, "second": metal})])


@scene
def principled_glass(s: Scene) -> None:
    """White metal and glass, with Mitsuba's principled BSDF and correlated masking"""
    stage(s)
    parts = []
    for roughness in (0.3, 0.6):
        alpha = roughness**2
        parts.append(Part(f'Material "principled" "rgb basecolor" [1 1 1] "float metallic" 1 "float roughness" {roughness} "bool multiplescattering" false',
                          both_sides(correlated({"type": "principled", "base_color": colour_of(1.0), "metallic": 1.0, "roughness": roughness}, alpha, alpha))))
    parts.append(Part('Material "principled" "rgb basecolor" [1 1 1] "float transmission" 1 "float roughness" 0.5 "bool multiplescattering" false',
                      correlated({"type": "principled", "base_color": colour_of(1.0), "spec_trans": 1.0, "roughness": 0.5, "eta": 1.5}, 0.25, 0.25)))
    three_balls(s, parts)


@scene
def transmission(s: Scene) -> None:
    """A diffuse sheet that transmits, between a lamp and the camera"""
    stage(s)
    sheet = diffuse_transmission((0.2, 0.3, 0.1), (0.5, 0.4, 0.6))
    s.add(rectangle(sheet, transform(scale=(1, 0.8, 1), rotate=[((0, 1, 0), 30), ((1, 0, 0), -20)], translate=(0.3, 1, 1))))


@scene
def mixed(s: Scene) -> None:
    """Mixtures of a diffuse and a rough metallic BSDF"""
    stage(s)
    three_balls(s, [mix(diffuse((0.1, 0.2, 0.6)), conductor(*GOLD, 0.2), amount, f"mix{i}") for i, amount in enumerate((0.2, 0.5, 0.8))])


# Textures


@scene
def textures(s: Scene) -> None:
    """A picture as reflectance"""
    stage(s)
    s.add(rectangle(diffuse(s.image_texture(colours(8, 5))), transform(scale=(2, 1.2, 1), rotate=[((0, 1, 0), 15)], translate=(0, 1.3, 1))))


@scene
def normal_map(s: Scene) -> None:
    """A map of normals on a diffuse plate"""
    s.look_at((0.4, 4, 4), (0, 0.5, 0), fov=30)
    s.depth = 1
    random = numpy.random.default_rng(3)
    slopes = random.uniform(-0.25, 0.25, (8, 8, 2))
    normals = numpy.concatenate([slopes, numpy.sqrt(1 - (slopes**2).sum(axis=2, keepdims=True))], axis=2)
    material = with_normals(diffuse(0.6), normals / 2 + 0.5, s)
    s.add(lamp(), rectangle(material, transform(scale=(1.5, 1.2, 1), rotate=[((1, 0, 0), -70), ((0, 1, 0), 20)], translate=(0, 0.5, 0))))


@scene
def bump_map(s: Scene) -> None:
    """Heights on a diffuse plate"""
    s.look_at((0.4, 4, 4), (0, 0.5, 0), fov=30)
    s.depth = 1
    heights = numpy.random.default_rng(3).uniform(0, 0.08, (8, 8, 1)).repeat(3, axis=2)
    material = with_bumps(diffuse(0.6), heights, s)
    s.add(lamp(), rectangle(material, transform(scale=(1.5, 1.2, 1), rotate=[((1, 0, 0), -70), ((0, 1, 0), 20)], translate=(0, 0.5, 0))))


@scene
def alpha(s: Scene) -> None:
    """A sheet whose opacity is a picture, and one of constant opacity"""
    # A large lamp: Mitsuba finds it behind such sheets by chance alone.
    s.factor = 2
    s.look_at((0.4, 2.4, 6), (0, 0.8, 0))
    s.add(floor(), wall(), lamp(half=3, emission=(1.1, 1, 0.9)), constant((0.2, 0.25, 0.3)))
    opacity = numpy.random.default_rng(5).uniform(0, 1, (6, 6, 1)).repeat(3, axis=2)
    upright = {"rotate": [((0, 1, 0), 25)]}
    s.add(rectangle(diffuse((0.7, 0.2, 0.2)), transform(scale=(0.9, 0.9, 1), translate=(-1.1, 1, 1), **upright), opacity=s.image_texture(opacity, "float")),
          rectangle(diffuse((0.2, 0.7, 0.2)), transform(scale=(0.9, 0.9, 1), translate=(1.1, 1, 1), **upright), opacity=0.35))


# Lights


@scene
def environment_map(s: Scene) -> None:
    """A picture of the sky around diffuse, metallic and glass balls"""
    s.look_at((0.4, 2.4, 6), (0, 0.8, 0), fov=50)
    s.add(environment(s, sky, 512), floor(half=3))
    three_balls(s, [diffuse((0.7, 0.5, 0.3)), conductor(*GOLD, 0.1), dielectric(1.5)])


@scene
def sun(s: Scene) -> None:
    """A dim sky with a sun of 0.35 degrees (standard deviation) that gives nine tenths of the light"""
    s.look_at((0.4, 2.4, 6), (0, 0.8, 0), fov=50)
    towards, width2 = numpy.array((0.48, 0.6, 0.64)), numpy.radians(0.35) ** 2

    def radiance(directions):
        return numpy.array((0.2, 0.3, 0.5)) + numpy.exp((directions @ towards - 1) / width2)[..., None] * (3e4, 2.7e4, 2.2e4)

    s.add(environment(s, radiance, 2048), floor(half=3))
    three_balls(s, [diffuse((0.7, 0.5, 0.3)), conductor(*GOLD, 0.3), coated_diffuse((0.1, 0.4, 0.8), 1.5)])


@scene
def textured_lamp(s: Scene) -> None:
    """A lamp that emits a picture"""
    lamp_texture = s.image_texture(colours(6, 4) * 20)
    stage(s, lamp_texture)
    s.add(sphere(conductor(*GOLD, 0.15), (0, 0.8, 0), 0.8))


@scene
def many_lights(s: Scene) -> None:
    """200 balls, squares and points that emit"""
    s.look_at((0.4, 2.4, 6), (0, 0.8, 0), fov=50)
    s.add(floor(), wall())
    s.depth, s.factor = 4, 8
    random = numpy.random.default_rng(11)
    for number in range(200):
        position, colour = random.uniform((-4, 0.3, -2.5), (4, 4, 2)).tolist(), (10 ** random.uniform(-1, 1) * random.uniform(0.3, 1, 3)).tolist()
        if number % 3 == 0:
            s.add(sphere(diffuse(0), position, 0.05, emission=[10 * c for c in colour]))
        elif number % 3 == 1:
            axis, angle = random.normal(size=3).tolist(), random.uniform(0, 180)
            s.add(rectangle(diffuse(0), transform(scale=(0.06, 0.06, 1), rotate=[(axis, angle)], translate=position), emission=[10 * c for c in colour]))
        else:
            s.add(point(position, [0.1 * c for c in colour]))


@scene
def point_lights(s: Scene) -> None:
    """A spot, a point and a distant light"""
    s.look_at((0.4, 2.4, 6), (0, 0.8, 0), fov=50)
    s.add(floor(), wall(), sphere(diffuse((0.7, 0.7, 0.2)), (0, 0.8, 0), 0.8), spot((-2, 4, 2), (-0.5, 0, 0.5), 20, (40, 30, 20)),
          point((2, 2, 2), (5, 8, 10)), distant((1, -2, -1), (0.5, 0.4, 0.6)))


@scene
def angular_lights(s: Scene) -> None:
    """A spot with a soft edge, a goniometric light, a projector and a photometric file"""
    s.look_at((0.4, 2.4, 6), (0, 0.8, 0), fov=60)
    s.factor = 8
    s.add(floor(), wall(), sphere(diffuse((0.7, 0.7, 0.2)), (0, 0.8, 0), 0.8))

    def cone(d):
        # pbrt: a cubic step between the cosines of both angles.
        first, last = numpy.cos(numpy.radians((30, 15))).tolist()
        t = drjit.clip((d.z - first) / (last - first), 0, 1)
        return 20 * t * t * (3 - 2 * t) * mitsuba.Color3f(1, 0.8, 0.6)

    s.add(angular(pointing((-2.5, 3, 2), (-1.5, 0, 0)), 'LightSource "spot" "point3 from" [0 0 0] "point3 to" [0 0 1] "float coneangle" 30 '
                  '"float conedeltaangle" 15 "rgb I" [20 16 12]', cone))

    def lobes(x, y, z):
        return 2 + x + 0.5 * y * z, 1.5 + 0.8 * z * x, 1.6 - 0.7 * y + x * y

    # pbrt swaps y and z: rows from y to -y, columns by the angle from x towards z.
    width, height = 512, 256
    phi, theta = numpy.meshgrid(2 * numpy.pi * (numpy.arange(width) + 0.5) / width, numpy.pi * (numpy.arange(height) + 0.5) / height)
    file, _ = s.picture(numpy.stack(lobes(numpy.cos(phi) * numpy.sin(theta), numpy.cos(theta), numpy.sin(phi) * numpy.sin(theta)), axis=2))
    s.add(angular(transform(rotate=[((1, 2, 3), 50)], translate=(2, 1.5, 1.5)), f'LightSource "goniometric" "string filename" "{file}"',
                  lambda d: mitsuba.Color3f(*lobes(d.x, d.y, d.z))))

    def slide(x, y):
        return 4 + 3 * x + 0.5 * y, 4 + 2 * x * y, 4 - 3 * y - 0.5 * x * x

    # Columns of the picture to the right (x), rows down (-y).
    x, y = numpy.meshgrid(2 * (numpy.arange(width) + 0.5) / width - 1, 1 - 2 * (numpy.arange(width) + 0.5) / width)
    file, _ = s.picture(numpy.stack(slide(x, y), axis=2))

    def projected(d):
        x, y = (c / (d.z * float(numpy.tan(numpy.radians(20)))) for c in (d.x, d.y))
        return drjit.select((d.z > 0) & (abs(x) < 1) & (abs(y) < 1), mitsuba.Color3f(*slide(x, y)), 0)

    s.add(angular(pointing((0, 3, 3), (0.5, 2.5, -3)), f'LightSource "projection" "string filename" "{file}" "float fov" 40', projected))

    # From 2000 cd downwards (-z) in a straight line to 0 cd at the horizon; 683 cd are 1 W/sr.
    (s.folder / "lamp.ies").write_text("IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 25\n0 90\n0\n2000 0\n")
    s.add(angular(transform(rotate=[((1, 0, 0), -90), ((0, 0, 1), 20)], translate=(-0.5, 3.5, -1)), 'LightSource "photometric" "string filename" "lamp.ies"',
                  lambda d: 2000 / 683 * mitsuba.Color3f(drjit.maximum(0, 1 - 2 / drjit.pi * drjit.safe_acos(-d.z)))))


@scene
def mesh_light(s: Scene) -> None:
    """A tetrahedron and a disk that emit"""
    stage(s)
    corners = numpy.array([[0, 0, 0], [0.8, 0, 0.1], [0.2, 0.9, 0], [0.3, 0.2, 0.8]]) + (-1.2, 0.5, 1)
    faces = numpy.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    s.add(mesh(diffuse(0.4), s, corners, faces, emission=(3, 5, 9)),
          disk(diffuse(0.4), transform(scale=(0.5, 0.5, 0.5), rotate=[((0, 1, 0), -40)], translate=(1.5, 1, 0.5)), emission=(9, 4, 2)))


# Cameras and shapes


@scene
def thin_lens(s: Scene) -> None:
    """A lens of radius 0.15 m, focused on the middle ball"""
    stage(s, lens=(0.15, 5.5))
    s.add(*(sphere(diffuse(c), (x, 0.6, z), 0.6) for c, x, z in (((0.8, 0.2, 0.2), -1.4, -2), ((0.2, 0.8, 0.2), 0, 0.5), ((0.2, 0.2, 0.8), 1, 3))))


@scene
def orthographic(s: Scene) -> None:
    """An orthographic camera"""
    stage(s, kind="orthographic", fov=5)
    three_balls(s, [diffuse((0.8, 0.4, 0.1)), conductor(*GOLD, 0.3), dielectric(1.5)])


@scene
def spherical(s: Scene) -> None:
    """All directions, as longitude and latitude"""
    s.look_at((0.4, 1.5, 2), (0, 1, 0), kind="spherical")
    s.add(floor(), wall(), lamp(), constant((0.2, 0.25, 0.3)))
    three_balls(s, [diffuse((0.8, 0.4, 0.1)), conductor(*GOLD, 0.3), diffuse((0.1, 0.4, 0.8))])


@scene
def instanced(s: Scene) -> None:
    """A tetrahedron in five places, turned, scaled and mirrored"""
    stage(s)
    corners = numpy.array([[-0.5, 0, -0.5], [0.5, 0, -0.5], [0, 0, 0.6], [0, 1, 0]])
    faces = numpy.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    places = [transform(scale=(1, 0.5 + 0.3 * i, (-1) ** i), rotate=[((0, 1, 0), 40 * i)], translate=(1.1 * (i - 2), 0.1, 0.3 * i)) for i in range(5)]
    s.add(instances(mesh(diffuse((0.3, 0.6, 0.3)), s, corners, faces), "thing", places))


@scene
def quadrics(s: Scene) -> None:
    """A cylinder, a disk and a box of several materials"""
    stage(s)
    s.add(cylinder(conductor(*GOLD, 0.2), transform(scale=(0.6, 0.6, 1.5), rotate=[((1, 0, 0), -90)], translate=(-1.6, 0, 0))),
          disk(diffuse((0.8, 0.3, 0.3)), transform(scale=(0.8, 0.8, 1), rotate=[((0, 1, 0), 20), ((1, 0, 0), -20)], translate=(0, 1, 0.6))),
          box(dielectric(1.5), transform(scale=(0.5, 0.7, 0.5), rotate=[((0, 1, 0), 30)], translate=(1.6, 0.72, 0.3))))


# Media


@scene
def foggy(s: Scene) -> None:
    """A box of fog around two balls"""
    stage(s)
    s.integrator = "volpath"
    s.add(fog(transform(scale=(3, 1.2, 1.5), translate=(0, 1.21, 0)), (0.02, 0.04, 0.08), (0.3, 0.35, 0.4), 0.4),
          sphere(diffuse((0.8, 0.3, 0.2)), (-1, 0.7, 0.2), 0.6), sphere(conductor(*GOLD, 0.3), (1, 0.7, 0.2), 0.6))
