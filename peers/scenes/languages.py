"""Cameras, lights, materials and shapes in pbrt's scene language and as Mitsuba's dictionaries, from one call each.

A part is written for both programs from the meaning of its parameters in their manuals; where the programs mean different things by the
same name, the function converts. Lengths are metres, colours linear Rec. 709, y is up.
"""

import pathlib
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import mitsuba
import numpy

mitsuba.set_variant("llvm_ad_rgb")

import plugins  # noqa: E402  (needs the variant)

plugins.register()

Colour = float | Sequence[float]


class Part(NamedTuple):
    """The same thing in both languages."""

    pbrt: str
    mitsuba: dict[str, object]


def numbers(values: Iterable[float]) -> str:
    return "[" + " ".join(f"{v:.9g}" for v in numpy.asarray(list(values), dtype=float).ravel()) + "]"


def read(path: pathlib.Path) -> numpy.ndarray:
    """The linear RGB values of a picture."""
    picture = mitsuba.Bitmap(str(path)).convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, False)
    return numpy.array(picture, dtype=float)


def three(colour: Colour) -> list[float]:
    return [float(c) for c in colour] if isinstance(colour, Sequence) else [float(colour)] * 3


def rgb(name: str, colour: Colour) -> str:
    return f'"rgb {name}" {numbers(three(colour))}'


def colour_of(value: Colour) -> dict[str, object]:
    return {"type": "rgb", "value": three(value)}


class Texture(NamedTuple):
    """A texture: the directive that defines it, its name, its dictionary."""

    definition: str
    name: str
    mitsuba: dict[str, object]


class Scene:
    """A scene under construction: its camera, film and parts."""

    def __init__(self, folder: pathlib.Path, size: int):
        self.folder, self.size, self.depth, self.integrator = folder, size, 32, "path"
        # Mitsuba's samples over those of Glanz: pixels need enough for a normal distribution of their means.
        self.factor = 1
        self.camera = Part("", {})
        self.parts: list[Part] = []
        self.files = 0

    # Pictures and textures

    def picture(self, pixels: numpy.ndarray) -> tuple[str, mitsuba.Bitmap]:
        """A picture of rows from top to bottom: the name of its file for Glanz, and a bitmap for Mitsuba."""
        self.files += 1
        name = f"picture{self.files}.exr"
        bitmap = mitsuba.Bitmap(numpy.ascontiguousarray(pixels, dtype=numpy.float32))
        bitmap.write(str(self.folder / name))
        return name, bitmap

    def image_texture(self, pixels: numpy.ndarray, kind: str = "spectrum") -> Texture:
        """Bilinear, linear values. pbrt's v points up in the picture, Mitsuba's down."""
        file, _ = self.picture(pixels)
        bitmap = mitsuba.Bitmap(numpy.ascontiguousarray(pixels[::-1], dtype=numpy.float32))
        name = pathlib.Path(file).stem
        return Texture(
            f'Texture "{name}" "{kind}" "imagemap" "string filename" "{file}" "string filter" "bilinear" "string wrap" "clamp"\n',
            name, {"type": "bitmap", "bitmap": bitmap, "raw": True, "wrap_mode": "clamp", "filter_type": "bilinear"})

    # Cameras

    def look_at(self, origin: Sequence[float], target: Sequence[float], *, kind: str = "perspective", fov: float = 40,
                lens: tuple[float, float] | None = None) -> None:
        """`lens`: radius and distance of the plane of focus; `fov` of `orthographic`: height of the picture in metres."""
        # pbrt's camera is left-handed; the scale undoes it.
        pbrt = f"Scale -1 1 1\nLookAt {numbers([*origin, *target, 0, 1, 0])[1:-1]}\n"
        to_world = mitsuba.ScalarTransform4f().look_at(origin=list(origin), target=list(target), up=[0, 1, 0])
        if kind == "orthographic":
            half = fov / 2
            pbrt += f'Camera "orthographic" "float screenwindow" {numbers([-half, half, -half, half])}'
            dictionary = {"type": "orthographic", "to_world": to_world @ mitsuba.ScalarTransform4f().scale([half, half, 1])}
        elif kind == "spherical":
            pbrt += 'Camera "spherical" "string mapping" "equirectangular"'
            dictionary = {"type": "longitude_latitude", "to_world": to_world}
        else:
            pbrt += f'Camera "perspective" "float fov" {fov}'
            dictionary = {"type": "perspective", "fov": fov, "fov_axis": "smaller", "to_world": to_world}
        if lens:
            pbrt += f' "float lensradius" {lens[0]} "float focaldistance" {lens[1]}'
            dictionary |= {"type": "thinlens", "aperture_radius": lens[0], "focus_distance": lens[1]}
        dictionary |= {"near_clip": 1e-3, "far_clip": 1e3} if kind != "spherical" else {}
        self.camera = Part(pbrt, dictionary)

    def add(self, *parts: Part) -> None:
        self.parts += parts

    # Output

    def pbrt(self) -> str:
        head = [self.camera.pbrt,
                f'Film "rgb" "integer xresolution" {self.size} "integer yresolution" {self.size}',
                'PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5',
                f'Integrator "{self.integrator}" "integer maxdepth" {self.depth}', "WorldBegin"]
        return "\n".join([*head, *(part.pbrt for part in self.parts)]) + "\n"

    def mitsuba(self) -> mitsuba.Scene:
        film = {"type": "hdrfilm", "width": self.size, "height": self.size, "pixel_format": "rgb", "component_format": "float32",
                "rfilter": {"type": "box"}}
        world: dict[str, object] = {
            "type": "scene",
            # pbrt counts scattering events, Mitsuba segments of the path.
            "integrator": {"type": self.integrator, "max_depth": self.depth + 1},
            "sensor": self.camera.mitsuba | {"film": film, "sampler": {"type": "independent"}},
        }
        for number, part in enumerate(self.parts):
            if "type" in part.mitsuba:
                world[f"part{number}"] = part.mitsuba
            else:
                world |= {f"part{number}-{name}": value for name, value in part.mitsuba.items()}
        return mitsuba.load_dict(world)


# Materials


def value_of(name: str, value: Colour | Texture) -> tuple[str, str, dict[str, object]]:
    """A definition that comes before, the parameter, and the dictionary of a colour or texture."""
    if isinstance(value, Texture):
        return value.definition, f'"texture {name}" "{value.name}"', value.mitsuba
    return "", rgb(name, value), colour_of(value)


def both_sides(bsdf: dict[str, object]) -> dict[str, object]:
    return {"type": "twosided", "inside": bsdf}


def diffuse(reflectance: Colour | Texture) -> Part:
    before, parameter, dictionary = value_of("reflectance", reflectance)
    return Part(f'{before}Material "diffuse" {parameter}', both_sides({"type": "diffuse", "reflectance": dictionary}))


def diffuse_transmission(reflectance: Colour, transmittance: Colour) -> Part:
    return Part(f'Material "diffusetransmission" {rgb("reflectance", reflectance)} {rgb("transmittance", transmittance)}',
                {"type": "diffuse_transmission", "reflectance": colour_of(reflectance), "transmittance": colour_of(transmittance)})


def alphas(alpha: float | tuple[float, float], prefix: str = "") -> tuple[str, float, float]:
    """Widths of the distribution, without pbrt's mapping of roughness and without light between facets, which Mitsuba lacks."""
    u, v = alpha if isinstance(alpha, tuple) else (alpha, alpha)
    return (f'"float {prefix}uroughness" {u} "float {prefix}vroughness" {v} "bool remaproughness" false "bool multiplescattering" false', u, v)


def correlated(bsdf: dict[str, object], u: float, v: float) -> dict[str, object]:
    """Masking of both directions correlated by height, as in pbrt."""
    return {"type": "correlated", "alpha_u": u, "alpha_v": v, "nested": bsdf}


def conductor(eta: Colour, k: Colour, alpha: float | tuple[float, float] | None = None, own_masking: bool = False) -> Part:
    """`own_masking`: with Mitsuba's masking, which differs at grazing angles."""
    pbrt = f'Material "conductor" {rgb("eta", eta)} {rgb("k", k)}'
    dictionary = {"type": "conductor", "eta": colour_of(eta), "k": colour_of(k)}
    if alpha is not None:
        text, u, v = alphas(alpha)
        pbrt += " " + text
        dictionary |= {"type": "roughconductor", "distribution": "ggx", "alpha_u": u, "alpha_v": v}
        dictionary = dictionary if own_masking else correlated(dictionary, u, v)
    return Part(pbrt, both_sides(dictionary))


def dielectric(eta: float, alpha: float | tuple[float, float] | None = None, own_masking: bool = False) -> Part:
    pbrt, dictionary = f'Material "dielectric" "float eta" {eta}', {"type": "dielectric", "int_ior": eta, "ext_ior": 1.0}
    if alpha is not None:
        text, u, v = alphas(alpha)
        pbrt += " " + text
        dictionary |= {"type": "roughdielectric", "distribution": "ggx", "alpha_u": u, "alpha_v": v}
        dictionary = dictionary if own_masking else correlated(dictionary, u, v)
    return Part(pbrt, dictionary)


def thin_dielectric(eta: float) -> Part:
    return Part(f'Material "thindielectric" "float eta" {eta}', {"type": "thindielectric", "int_ior": eta, "ext_ior": 1.0})


def plastic(reflectance: Colour, eta: float, alpha: float | None, nonlinear: bool) -> dict[str, object]:
    """Mitsuba's diffuse base under a dielectric interface; `nonlinear`: colours of the light between both change as in nature."""
    if alpha is None:
        return {"type": "plastic", "diffuse_reflectance": colour_of(reflectance), "int_ior": eta, "ext_ior": 1.0, "nonlinear": nonlinear}
    white = {"type": "roughplastic", "distribution": "ggx", "alpha": alpha, "diffuse_reflectance": colour_of(1.0), "int_ior": eta, "ext_ior": 1.0}
    return {"type": "rough_coat", "alpha_u": alpha, "alpha_v": alpha, "eta": eta, "reflectance": colour_of(reflectance), "saturates": nonlinear,
            "nested": white}


def coated_diffuse(reflectance: Colour, eta: float, alpha: float | None = None) -> Part:
    pbrt = f'Material "coateddiffuse" {rgb("reflectance", reflectance)} "float eta" {eta}'
    pbrt += " " + alphas(alpha)[0] if alpha is not None else ""
    return Part(pbrt, both_sides(plastic(reflectance, eta, alpha, True)))


def mix(first: Part, second: Part, amount: float, name: str) -> Part:
    """`amount` of the second."""
    named = "\n".join(part.pbrt.replace("Material ", f'MakeNamedMaterial "{name}{i}" "string type" ', 1)
                      for i, part in enumerate([first, second]))
    return Part(f'{named}\nMaterial "mix" "string materials" ["{name}0" "{name}1"] "float amount" {amount}',
                {"type": "blendbsdf", "weight": amount, "first": first.mitsuba, "second": second.mitsuba})


def with_normals(material: Part, pixels: numpy.ndarray, scene: Scene) -> Part:
    """A map of normals, which repeats in pbrt."""
    texture = scene.image_texture(pixels)
    nested = material.mitsuba.get("inside", material.mitsuba)
    return Part(f'{material.pbrt} "string normalmap" "{texture.name}.exr"',
                both_sides({"type": "normalmap", "normalmap": texture.mitsuba | {"wrap_mode": "repeat"}, "nested": nested, "use_shadowing_function": False,
                            "flip_invalid_normals": False}))


def with_bumps(material: Part, heights: numpy.ndarray, scene: Scene) -> Part:
    """Heights in metres, bilinear."""
    texture = scene.image_texture(heights, "float")
    nested = material.mitsuba.get("inside", material.mitsuba)
    return Part(f'{texture.definition}{material.pbrt} "texture displacement" "{texture.name}"',
                both_sides({"type": "bumpmap", "arbitrary": texture.mitsuba, "nested": nested}))


# Shapes


def transform(*, scale: Sequence[float] = (1, 1, 1), rotate: Iterable[tuple[Sequence[float], float]] = (),
              translate: Sequence[float] = (0, 0, 0)) -> mitsuba.ScalarTransform4f:
    """Scaled, then rotated by degrees about axes, then moved."""
    result = mitsuba.ScalarTransform4f().scale(list(scale))
    for axis, angle in rotate:
        # Mitsuba expects an axis of length 1.
        result = mitsuba.ScalarTransform4f().rotate((numpy.asarray(axis) / numpy.linalg.norm(axis)).tolist(), angle) @ result
    return mitsuba.ScalarTransform4f().translate(list(translate)) @ result


def matrix(to_world: mitsuba.ScalarTransform4f) -> numpy.ndarray:
    return numpy.array(to_world.matrix, dtype=float)


def placed(material: Part, text: str, shape: dict[str, object], emission: Colour | Texture | None = None,
           opacity: float | Texture | None = None) -> Part:
    """A shape with its material, light and opacity."""
    lines, dictionary = [material.pbrt], dict(shape) | {"bsdf": material.mitsuba}
    if emission is not None:
        if isinstance(emission, Texture):
            lines.append(f'AreaLightSource "diffuse" "rgb L" [1 1 1] "string filename" "{emission.name}.exr"')
            radiance = emission.mitsuba
        else:
            lines.append(f'AreaLightSource "diffuse" {rgb("L", emission)}')
            radiance = colour_of(emission)
        dictionary["emitter"] = {"type": "area", "radiance": radiance}
    if opacity is not None:
        if isinstance(opacity, Texture):
            lines.insert(0, opacity.definition)
            text += f' "texture alpha" "{opacity.name}"'
        else:
            text += f' "float alpha" {opacity}'
        opaque = opacity.mitsuba if isinstance(opacity, Texture) else opacity
        dictionary["bsdf"] = {"type": "mask", "opacity": opaque, "nested": material.mitsuba}
    return Part("\n".join(["AttributeBegin", *lines, text, "AttributeEnd"]), dictionary)


def rectangle(material: Part, to_world: mitsuba.ScalarTransform4f, **more: object) -> Part:
    """The square from (-1, -1) to (1, 1) in z = 0, u along x, v along y, front along +z."""
    corners = numpy.array([[-1, -1, 0, 1], [1, -1, 0, 1], [-1, 1, 0, 1], [1, 1, 0, 1]], dtype=float)
    points = (matrix(to_world) @ corners.T).T[:, :3]
    return placed(material, f'Shape "bilinearmesh" "point3 P" {numbers(points.ravel())}',
                  {"type": "rectangle", "to_world": to_world}, **more)


def sphere(material: Part, centre: Sequence[float], radius: float, **more: object) -> Part:
    return placed(material, f'Translate {numbers(centre)[1:-1]}\nShape "sphere" "float radius" {radius}',
                  {"type": "sphere", "center": list(centre), "radius": radius}, **more)


def under_transform(material: Part, to_world: mitsuba.ScalarTransform4f, text: str, shape: dict[str, object], **more: object) -> Part:
    return placed(material, f"ConcatTransform {numbers(matrix(to_world).T.ravel())}\n{text}", shape | {"to_world": to_world}, **more)


def disk(material: Part, to_world: mitsuba.ScalarTransform4f, **more: object) -> Part:
    return under_transform(material, to_world, 'Shape "disk"', {"type": "disk"}, **more)


def cylinder(material: Part, to_world: mitsuba.ScalarTransform4f, **more: object) -> Part:
    return under_transform(material, to_world, 'Shape "cylinder" "float zmin" 0 "float zmax" 1', {"type": "cylinder"}, **more)


def box(material: Part, to_world: mitsuba.ScalarTransform4f, **more: object) -> Part:
    """The cube from -1 to 1."""
    return under_transform(material, to_world, 'Shape "box" "point3 min" [-1 -1 -1] "point3 max" [1 1 1]', {"type": "cube"}, **more)


def mesh(material: Part, scene: Scene, vertices: numpy.ndarray, faces: numpy.ndarray, **more: object) -> Part:
    """Flat triangles."""
    scene.files += 1
    name = f"mesh{scene.files}.ply"
    head = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", *(f"property float {c}" for c in "xyz"),
            f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    body = [" ".join(f"{c:.9g}" for c in v) for v in vertices] + ["3 " + " ".join(map(str, f)) for f in faces]
    (scene.folder / name).write_text("\n".join(head + body) + "\n")
    return placed(material, f'Shape "plymesh" "string filename" "{name}"',
                  {"type": "ply", "filename": str(scene.folder / name), "face_normals": True}, **more)


def instances(shape: Part, name: str, places: Sequence[mitsuba.ScalarTransform4f]) -> Part:
    pbrt = [f'ObjectBegin "{name}"', shape.pbrt, "ObjectEnd"]
    dictionary: dict[str, object] = {"group": {"type": "shapegroup", "id": name, "shape": shape.mitsuba}}
    for number, place in enumerate(places):
        pbrt += ["AttributeBegin", f"ConcatTransform {numbers(matrix(place).T.ravel())}", f'ObjectInstance "{name}"', "AttributeEnd"]
        dictionary[f"instance{number}"] = {"type": "instance", "to_world": place, "shapegroup": {"type": "ref", "id": name}}
    return Part("\n".join(pbrt), dictionary)


# Lights


def point(position: Sequence[float], intensity: Colour) -> Part:
    return Part(f'LightSource "point" "point3 from" {numbers(position)} {rgb("I", intensity)}',
                {"type": "point", "position": list(position), "intensity": colour_of(intensity)})


def spot(position: Sequence[float], target: Sequence[float], angle: float, intensity: Colour) -> Part:
    """A cone with a hard edge: the programs fade differently."""
    return Part(f'LightSource "spot" "point3 from" {numbers(position)} "point3 to" {numbers(target)} "float coneangle" {angle} '
                f'"float conedeltaangle" 0.001 {rgb("I", intensity)}',
                {"type": "spot", "to_world": pointing(position, target), "intensity": colour_of(intensity), "cutoff_angle": angle,
                 "beam_width": angle - 0.001})


def pointing(position: Sequence[float], target: Sequence[float]) -> mitsuba.ScalarTransform4f:
    return mitsuba.ScalarTransform4f().look_at(origin=list(position), target=list(target), up=[0, 0, 1])


def angular(to_world: mitsuba.ScalarTransform4f, text: str, intensity: Callable) -> Part:
    """A point light of this intensity by the direction (drjit) in its space, for Glanz as `text`."""
    plugins.INTENSITIES.append(intensity)
    return Part(f"AttributeBegin\nConcatTransform {numbers(matrix(to_world).T.ravel())}\n{text}\nAttributeEnd",
                {"type": "angular", "to_world": to_world, "intensity": len(plugins.INTENSITIES) - 1})


def distant(direction: Sequence[float], irradiance: Colour) -> Part:
    return Part(f'LightSource "distant" "point3 from" [0 0 0] "point3 to" {numbers(direction)} {rgb("L", irradiance)}',
                {"type": "directional", "direction": list(direction), "irradiance": colour_of(irradiance)})


def constant(radiance: Colour) -> Part:
    return Part(f'LightSource "infinite" {rgb("L", radiance)}', {"type": "constant", "radiance": colour_of(radiance)})


def environment(scene: Scene, radiance: Callable, width: int) -> Part:
    """`radiance(directions)`: colours of an array of directions. Each program gets them where it has the pixels of its pictures.

    Glanz: rows between z and -z, columns by the angle from x to y; here turned so that z becomes y, x becomes z, y becomes x.
    Mitsuba: columns by atan2(x, -z); its first row is the direction up, the last the direction down.
    """
    height = width // 2

    def at(phi: numpy.ndarray, theta: numpy.ndarray) -> numpy.ndarray:
        phi, theta = numpy.meshgrid(phi, theta)
        return radiance(numpy.stack([numpy.sin(phi) * numpy.sin(theta), numpy.cos(theta), numpy.cos(phi) * numpy.sin(theta)], axis=-1))

    turn = 2 * numpy.pi * (numpy.arange(width) + 0.5) / width
    file, _ = scene.picture(at(turn, numpy.pi * (numpy.arange(height) + 0.5) / height))
    _, bitmap = scene.picture(at(numpy.pi - turn, numpy.pi * numpy.arange(height) / (height - 1)))
    axes = numpy.array([[0, 1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1]], dtype=float)
    return Part(f'AttributeBegin\nConcatTransform {numbers(axes.T.ravel())}\nLightSource "infinite" "string filename" "{file}"\nAttributeEnd',
                {"type": "envmap", "bitmap": bitmap})


# Media


def fog(to_world: mitsuba.ScalarTransform4f, sigma_a: Colour, sigma_s: Colour, g: float) -> Part:
    """The cube from -1 to 1, filled with a homogeneous medium of Henyey and Greenstein's phase function."""
    absorbed, scattered = numpy.array(three(sigma_a)), numpy.array(three(sigma_s))
    extinction = absorbed + scattered
    medium = {"type": "homogeneous", "sigma_t": colour_of(extinction.tolist()), "albedo": colour_of((scattered / extinction).tolist()),
              "phase": {"type": "hg", "g": g}}
    shape = box(Part('Material "interface"', {"type": "null"}), to_world)
    return Part(f'MakeNamedMedium "fog" "string type" "homogeneous" {rgb("sigma_a", sigma_a)} {rgb("sigma_s", sigma_s)} "float g" {g}\n'
                + shape.pbrt.replace("AttributeBegin", 'AttributeBegin\nMediumInterface "fog" ""', 1), shape.mitsuba | {"interior": medium})
