"""Pictures from Python and from the command line."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import glanz
from glanz.scene import Diffuse, Disk, Film, PerspectiveCamera, PointLight, SceneDescription, Sphere

ROOT = Path(__file__).resolve().parents[2]


def program() -> str:
    """The program, from GLANZ_PROGRAM, the folder target or the path; skips without one."""
    built = [ROOT / "target" / profile / f"glanz{suffix}" for profile in ("release", "debug") for suffix in ("", ".exe")]
    named = os.environ.get("GLANZ_PROGRAM")
    candidates = [named] if named else [str(path) for path in built if path.is_file()]
    found = next(iter(candidates), None) or shutil.which("glanz")
    if found is None:
        pytest.skip("there is no program glanz: build it by `cargo build --release`, or set GLANZ_PROGRAM")
    version = subprocess.run([found, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
    if version != glanz.__version__:
        pytest.skip(f"the program glanz is of version {version}, the package of {glanz.__version__}")
    return found


def run(*arguments: str | Path) -> None:
    """Runs the program."""
    subprocess.run([program(), *map(str, arguments)], check=True, capture_output=True)


@pytest.mark.parametrize("scene", ["scenes/lens.pbrt", "scenes/fog.pbrt", "scenes/prism.pbrt"])
@pytest.mark.filterwarnings("ignore::glanz.GlanzWarning")
def test_pictures_have_the_bits_of_the_command_line(scene: str, tmp_path: Path) -> None:
    path = ROOT / scene
    run("render", path, "--size", "32x24", "--spp", "2", "--aov", "all", "-o", tmp_path / "a.exr", "-o", tmp_path / "a.png", "--tone", "filmic")
    image = glanz.load(path).render(size=(32, 24), samples=2, aovs="all")
    image.save(tmp_path / "b.exr")
    image.save(tmp_path / "b.png", tone="filmic")
    for suffix in ("exr", "png"):
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()


def test_scene_in_code_has_the_bits_of_its_text_on_the_command_line(tmp_path: Path) -> None:
    design = SceneDescription(
        camera=PerspectiveCamera(eye=(0, -5, 1 / 3), target=(0, 0, 0), up=(0, 0, 1), fov=40),
        film=Film(xresolution=24, yresolution=16),
        lights=[PointLight(from_=(1, -4, 3), I=(50, 40, 30))],
        shapes=[Sphere(radius=0.7, material=Diffuse(reflectance=(0.1, 0.7, 1 / 7))), Disk(height=-0.7, radius=3, receiver="floor")],
    )
    design.save(tmp_path / "design.pbrt")
    run("render", tmp_path / "design.pbrt", "-o", tmp_path / "a.exr")
    design.load().render().save(tmp_path / "b.exr")
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()
    run("illuminate", tmp_path / "design.pbrt", "-o", tmp_path / "lux", "--rays", "20000", "--cells", "8")
    result = design.load().illuminate(particles=20_000, cells=8)
    result.save(tmp_path / "ours")
    # The numbers as pictures; other files contain times.
    assert (tmp_path / "lux" / "floor.exr").read_bytes() == (tmp_path / "ours" / "floor.exr").read_bytes()
    lux = glanz.read_image(tmp_path / "lux" / "floor.exr").aovs["lux"]
    np.testing.assert_array_equal(lux[::-1], result["floor"].lux.astype(np.float32))


def test_parts_of_python_and_of_the_command_line_join(tmp_path: Path) -> None:
    path = ROOT / "scenes/fog.pbrt"
    scene = glanz.load(path)
    scene.render(size=(16, 12), samples=4, sample_range=(0, 1), checkpoint=tmp_path / "a")
    run("render", path, "--size", "16x12", "--spp", "4", "--samples", "1..4", "--checkpoint", tmp_path / "b", "-o", tmp_path / "part.exr")
    joined = glanz.merge([tmp_path / "a", tmp_path / "b"])
    assert np.array_equal(joined.array, scene.render(size=(16, 12), samples=4).array)
