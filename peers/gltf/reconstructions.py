"""One picture of a room by all light maps that `glanz bake` makes: six reconstructions, the final gather, and path tracing beside them.

    cargo build --release
    python3 peers/gltf/reconstructions.py --picture docs/images/reconstructions.png

Needs Pillow. Takes some minutes, most of them for the gather and the path-traced picture.
"""

import argparse
import pathlib
import subprocess
import tempfile

from PIL import Image, ImageDraw, ImageFont

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIZE = (400, 300)
RECONSTRUCTIONS = ["natural", "multiquadrics", "bilinear", "spline", "shepard", "constant"]
CAPTION_HEIGHT = 24


def glanz(*arguments):
    subprocess.run([ROOT / "target/release/glanz", *map(str, arguments), "-q"], check=True)


def rendered(scene, folder, name, bake_options):
    """The scene with the light that a bake with these options finds; without options, path-traced."""
    picture = folder / f"{name}.png"
    size = ["--size", "x".join(map(str, SIZE)), "-o", picture]
    if bake_options is None:
        glanz("render", scene, "--integrator", "path", "--spp", 1024, *size)
    else:
        light = folder / f"{name}.light"
        glanz("bake", scene, "-o", folder / f"{name}.glb", "--checkpoint", light, *bake_options)
        glanz("render", scene, "--integrator", "radiosity", "--light-in", light, "--spp", 64, *size)
    return Image.open(picture)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scene", default=ROOT / "scenes/rooms/direct.pbrt")
    parser.add_argument("--picture", required=True)
    arguments = parser.parse_args()
    tiles = {name: ["--method", "radiosity", "--reconstruct", name] for name in RECONSTRUCTIONS}
    tiles |= {"gather": [], "path tracing": None}
    width, height = SIZE[0], SIZE[1] + CAPTION_HEIGHT
    sheet = Image.new("RGB", (4 * width, 2 * height), "white")
    font = ImageFont.load_default(16)
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, options) in enumerate(tiles.items()):
            corner = (number % 4 * width, number // 4 * height)
            sheet.paste(rendered(arguments.scene, pathlib.Path(folder), name.replace(" ", "_"), options), corner)
            ImageDraw.Draw(sheet).text((corner[0] + 6, corner[1] + SIZE[1] + 2), name, "black", font)
    sheet.save(arguments.picture, optimize=True)


if __name__ == "__main__":
    main()
