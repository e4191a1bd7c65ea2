"""Reading scenes, and scenes built in Python."""

import dataclasses
import time
from pathlib import Path

import numpy as np
import pytest

import glanz
from glanz.scene import (
    BezierPatch,
    CheckerboardTexture,
    Diffuse,
    Disk,
    FbmTexture,
    Film,
    GridMedium,
    Group,
    HomogeneousMedium,
    Instance,
    Interface,
    Mirror,
    Mix,
    Nurbs,
    PerspectiveCamera,
    PointLight,
    SceneDescription,
    Sphere,
    Torus,
    Transform,
    TriangleMesh,
    TrimCurve,
    TrimEllipse,
    TrimLoops,
)


def small(*shapes: Sphere | Instance | Nurbs | BezierPatch | Disk | TriangleMesh) -> SceneDescription:
    """A scene of 16 x 12 pixels from (0, -5, 0)."""
    return SceneDescription(
        camera=PerspectiveCamera(eye=(0, -5, 0), target=(0, 0, 0), up=(0, 0, 1), fov=40),
        film=Film(xresolution=16, yresolution=12),
        lights=[PointLight(from_=(1, -4, 3), I=50)],
        shapes=shapes,
    )


def test_missing_scene_is_file_not_found(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        glanz.load(tmp_path / "missing.pbrt")
    assert caught.value.filename == str(tmp_path / "missing.pbrt")
    with pytest.raises(IsADirectoryError):
        glanz.load(tmp_path)


def test_faults_have_file_line_and_column(tmp_path: Path) -> None:
    path = tmp_path / "room.pbrt"
    path.write_text('WorldBegin\n\n  Shape "sphere" "float radius" "one"\n')
    with pytest.raises(glanz.SceneError) as caught:
        glanz.load(path)
    error = caught.value
    assert (error.file, error.line) == (str(path), 3)
    assert error.column is not None and error.column > 3
    assert error.diagnostics[0].severity == "error"
    assert "radius" in str(error)


def test_fault_of_a_scene_in_code_names_its_object() -> None:
    design = small(Sphere(), Sphere(radius=-1))
    with pytest.raises(glanz.SceneError) as caught:
        design.load().render()
    assert caught.value.object == "shapes[1]: Sphere"
    with pytest.raises(ValueError, match=r"shapes\[0\]: Sphere: radius"):
        small(Sphere(radius=float("nan"))).to_pbrt()
    with pytest.raises(ValueError, match=r"shapes\[0\].*P has the shape \(4, 3\)"):
        small(BezierPatch(P=np.zeros((4, 3)))).to_pbrt()


def test_warnings_are_python_warnings_with_their_place() -> None:
    with pytest.warns(glanz.GlanzWarning, match="desk:2:.*raduis") as caught:
        scene = glanz.loads('WorldBegin\nShape "sphere" "float raduis" 2\n', name="desk")
    assert caught[0].filename == __file__
    assert scene.diagnostics[0].help is not None and "radius" in scene.diagnostics[0].help
    with pytest.raises(glanz.SceneError):
        glanz.loads('WorldBegin\nShape "subdivide"\n', strict=True)


def test_scene_in_code_has_the_meaning_of_its_text(tmp_path: Path) -> None:
    trimmed = Nurbs(
        P=[[(-1, 0, -1), (1, 0, -1)], [(-1, 0, 1), (1, 0, 1)]],
        weights=[[1, 2], [1, 1 / 3]],
        uknots=[0, 0, 1, 1],
        vknots=[0, 0, 1, 1],
        trims=[TrimEllipse(0.5, 0.5, 0.2, 0.1)],
    )
    square = TrimLoops([[TrimCurve([0, 0, 1, 2, 3, 4, 4], [(0.1, 0.1), (0.9, 0.1), (0.9, 0.9), (0.1, 0.9), (0.1, 0.1)])]])
    ball = Group(shapes=[Sphere(radius=0.3, material=Mix(first=Mirror(), second=Diffuse(reflectance=(0.8, 0.1, 0.1))))])
    pair = Group(shapes=[Instance(group=ball), Instance(group=ball, transform=Transform.translate(0.7, 0, 0))])
    fog = Sphere(radius=0.5, material=Interface(), inside=HomogeneousMedium(sigma_s=2.0, sigma_a=0.1))
    tiled = Disk(height=-1, radius=3, material=Diffuse(reflectance=CheckerboardTexture(uscale=4)), trims=[square])
    design = small(trimmed, tiled, fog, Instance(group=pair, transform=Transform.rotate(30, (0, 1, 0))))
    path = tmp_path / "code.pbrt"
    design.save(path)
    ours, file = design.load().render(samples=4), glanz.load(path).render(samples=4)
    assert ours.array.mean() > 0
    assert np.array_equal(ours.array, file.array)


def test_textures_and_media_are_in_the_world_whatever_uses_them() -> None:
    cloud = GridMedium(density=np.ones(8), nx=2, ny=2, nz=2, p0=(0, 0, 0), p1=(1, 1, 1))
    holes = FbmTexture()
    ball = Sphere(alpha=holes, transform=Transform.translate(1, 2, 3))
    design = small(ball, Sphere(alpha=holes))
    text = dataclasses.replace(design, camera=PerspectiveCamera(eye=(0, -5, 0), medium=cloud)).to_pbrt()
    assert text.index("MakeNamedMedium") < text.index("LookAt")
    assert text.count("Texture ") == 1 and text.index("Texture ") < text.index("ConcatTransform")


def test_several_trims_of_loops_are_one() -> None:
    def loop(low: float, high: float) -> TrimLoops:
        corners = [(low, low), (high, low), (high, high), (low, high), (low, low)]
        return TrimLoops([[TrimCurve([0, 0, 1, 2, 3, 4, 4], corners)]])

    text = small(Disk(trims=[loop(0.1, 0.4), loop(0.6, 0.9), TrimEllipse(0.5, 0.5, 0.01, 0.01)])).to_pbrt()
    assert text.count('trimloops"') == 1 and '"integer trimloops" [ 1 1 ]' in text
    assert not glanz.loads(text).diagnostics


def test_whole_numbers_have_32_bits() -> None:
    with pytest.raises(ValueError, match="32 bits"):
        small(Sphere(solid=10**300)).to_pbrt()


def test_numbers_keep_all_their_digits() -> None:
    radius = float(np.nextafter(0.1, 1))
    text = small(Sphere(radius=radius)).to_pbrt()
    assert repr(radius) in text


def test_picture_shows_a_right_handed_world_unmirrored() -> None:
    # +x is to the right, +z up.
    image = small(Sphere(radius=0.4, transform=Transform.translate(1, 0, 0.7))).load().render(samples=8)
    row, column = divmod(int(image.array.sum(axis=2).argmax()), image.width)
    assert column > 8 and row < 6


def test_replacing_a_number_makes_a_variant() -> None:
    ball = Sphere(radius=0.5)
    bigger = dataclasses.replace(ball, radius=1.0)
    design = small(ball)
    assert np.count_nonzero(dataclasses.replace(design, shapes=[bigger]).load().render(samples=1).array) > np.count_nonzero(
        design.load().render(samples=1).array
    )


def test_a_million_numbers_are_written_in_seconds() -> None:
    points = np.random.default_rng(1).random((333_334, 3))
    begun = time.process_time()
    text = small(TriangleMesh(P=points, indices=[0, 1, 2])).to_pbrt()
    seconds = time.process_time() - begun
    assert len(text) > 10_000_000
    print(f"{points.size} numbers in {seconds:.2f} s")
    assert seconds < 5.0


def test_bounds_and_triangles_are_those_of_the_surfaces(tmp_path: Path) -> None:
    scene = small(Sphere(radius=2)).load()
    np.testing.assert_allclose(scene.bounds(), [[-2, -2, -2], [2, 2, 2]], atol=1e-9)
    assert [path.name for path in scene.save(tmp_path / "ball.ply")] == ["ball.ply"]
    model = glanz.load(tmp_path / "ball.ply", view="front", material="steel")
    assert model.is_model and "model" in repr(model)
    assert model.render(size=(16, 16), samples=1).array.shape == (16, 16, 3)
    assert scene.save(tmp_path / "ball.pbrt") == [tmp_path / "ball.pbrt"]
    with pytest.warns(glanz.GlanzWarning, match="view, material: only for models"):
        glanz.load(tmp_path / "ball.pbrt", view="front", material="steel")
    with pytest.raises(ValueError, match="there is no view"):
        glanz.load(tmp_path / "ball.ply", view="below")


def test_transformations_compose_from_the_right() -> None:
    turned = Transform.translate(1, 2, 3) @ Transform.rotate(90, (0, 0, 1)) @ Transform.scale(2)
    np.testing.assert_allclose(turned.array @ [1, 0, 0, 1], [1, 4, 3, 1], atol=1e-15)
    with pytest.raises(ValueError, match="4, 4"):
        Transform(np.eye(3))
    assert isinstance(Torus(transform=turned).transform, Transform)


def test_limits_end_reading_with_a_place(tmp_path: Path) -> None:
    """Thirty files that each include the next one twice."""
    for level in range(30):
        (tmp_path / f"{level}.pbrt").write_text(f'Include "{level + 1}.pbrt"\n' * 2)
    (tmp_path / "30.pbrt").write_text("Identity\n")
    for limits, message in [
        ({"files": 300}, "the limit of 300 files is exceeded"),
        ({"tokens": 3e2, "files": "1e9"}, "the limit of 300 tokens is exceeded"),
    ]:
        with pytest.raises(glanz.SceneError, match=message) as raised:
            glanz.load(tmp_path / "0.pbrt", limits=limits)
        assert raised.value.line is not None
        advice = {"files": 'limits={"files": "600"}', "tokens": 'limits={"tokens": "600"}'}[next(iter(limits))]
        assert raised.value.diagnostics[0].help == f"raise it with {advice}"
        assert advice in str(raised.value)
    with pytest.raises(ValueError, match="limits: memory is much"):
        glanz.loads("WorldBegin", limits={"memory": "much"})
    with pytest.raises(ValueError, match="limits"):
        glanz.loads("WorldBegin", limits={"rays": 1})
