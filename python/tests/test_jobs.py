"""Rendering, illuminating and baking."""

import dataclasses
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import glanz
from glanz.scene import AreaLight, Diffuse, Disk, DistantLight, Film, PerspectiveCamera, Plane, PointLight, SceneDescription, Sphere, Transform

DESIGN = SceneDescription(
    camera=PerspectiveCamera(eye=(0, -5, 1), target=(0, 0, 0), up=(0, 0, 1), fov=40),
    film=Film(xresolution=24, yresolution=16),
    lights=[PointLight(from_=(1, -4, 3), I=50)],
    shapes=[Sphere(), Disk(height=-1, radius=4, receiver="floor", cells=[4, 3])],
)
SCENE = DESIGN.load()


def test_image_has_writable_arrays_of_light_channels_and_errors() -> None:
    image = SCENE.render(samples=8, aovs="all")
    assert image.array.shape == (16, 24, 3) and image.array.dtype == np.float32
    assert image.array is image.array and image.array.flags.writeable
    shapes = {name: array.shape[2:] for name, array in image.aovs.items()}
    three = {name: (3,) for name in ("Albedo", "P", "N", "Ns", "Variance")}
    assert shapes == {**three, "uv": (2,), "Z": (), "id": ()}
    assert image.standard_error is not None
    np.testing.assert_allclose(image.standard_error**2, image.aovs["Variance"], rtol=1e-6)
    assert image.samples == 8 and image.sample_ranges == [(0, 8)]
    assert image.statistics is not None and image.statistics.end == "complete"
    assert np.asarray(image).shape == (16, 24, 3)
    assert image.to_png().startswith(b"\x89PNG")


def test_parts_join_to_the_bits_of_the_whole(tmp_path: Path) -> None:
    whole = SCENE.render(samples=7)
    for part in (1, 2, 3):
        SCENE.render(samples=7, part=f"{part}/3", checkpoint=tmp_path / f"{part}.glanz")
    joined = glanz.merge([tmp_path / f"{part}.glanz" for part in (1, 2, 3)])
    assert np.array_equal(joined.array, whole.array)
    with pytest.raises(glanz.GlanzError):
        glanz.merge([tmp_path / "1.glanz", tmp_path / "1.glanz"])


def test_picture_does_not_depend_on_threads_or_checkpoints(tmp_path: Path) -> None:
    whole = SCENE.render(samples=6, threads=1)
    checkpoint = tmp_path / "state"
    SCENE.render(samples=6, sample_range=(0, 2), checkpoint=checkpoint)
    with pytest.raises(FileExistsError, match="resume=True"):
        SCENE.render(samples=6, checkpoint=checkpoint)
    assert np.array_equal(SCENE.render(samples=6, checkpoint=checkpoint, resume=True).array, whole.array)


def test_saved_pictures_are_read_and_compared(tmp_path: Path) -> None:
    red = Sphere(material=Diffuse(reflectance=(0.8, 0.2, 0.1)))
    image = dataclasses.replace(DESIGN, shapes=[red]).load().render(samples=2, aovs="all")
    image.save(tmp_path / "a.exr")
    back = glanz.read_image(tmp_path / "a.exr")
    assert np.array_equal(back.array, image.array) and back.samples is None
    # Files sort channels by name: blue comes first there.
    assert image.aovs["Albedo"][8, 12, 0] > image.aovs["Albedo"][8, 12, 2]
    assert set(back.aovs) == set(image.aovs)
    for name, channel in image.aovs.items():
        np.testing.assert_array_equal(back.aovs[name], channel)
    same = glanz.compare(image, tmp_path / "a.exr")
    assert same.rmse == 0 and same.flip == 0
    shifted = glanz.compare(image.array + np.float32(0.25), image)
    assert shifted.rmse == pytest.approx(0.25, rel=1e-6) and shifted.flip > 0
    with pytest.raises(ValueError):
        glanz.compare(image, image.array[:4])
    grey = glanz.Image(np.full((2, 3), 128, dtype=np.uint8))
    # 128 / 255 in sRGB.
    assert grey.array[0, 0] == pytest.approx(((128 / 255 + 0.055) / 1.055) ** 2.4, rel=1e-5)
    for refused in (np.full((2, 3), 300, np.uint16), np.ones((2, 3), complex), np.ones((2, 3), int), np.array([["1", "2"]])):
        with pytest.raises(TypeError, match="uint8"):
            glanz.Image(refused)
    with pytest.raises(ValueError, match="extension"):
        image.save(tmp_path / "a.tiff")
    with pytest.raises(FileNotFoundError):
        image.save(tmp_path / "none" / "a.png")


def test_image_is_an_array_without_copies_where_they_are_not_needed() -> None:
    image = glanz.Image(np.ones((2, 3)))
    assert image.__array__(copy=False) is image.array and image.__array__("float32", copy=False) is image.array
    assert image.__array__(copy=True) is not image.array and image.__array__("float64").dtype == np.float64
    with pytest.raises(ValueError, match="copy"):
        image.__array__("float64", copy=False)


def test_standard_error_is_the_spread_of_seeds() -> None:
    images = [SCENE.render(samples=16, sampler="independent", seed=seed, variance=True) for seed in range(64)]
    spread = np.var([image.array for image in images], axis=0, ddof=1).mean()
    stated = np.mean([image.aovs["Variance"] for image in images])
    print(f"variance of the seeds over that of the pictures: {spread / stated:.3f}")
    # 64 seeds of 1152 values: the ratio of the sums is known to a few percent.
    assert stated == pytest.approx(spread, rel=0.15)


@pytest.mark.parametrize(
    ("job", "arguments"),
    [
        ("render", {"samples": 2, "time_limit": 1}),
        ("render", {"sample_range": (0, 1), "time_limit": 1}),
        ("render", {"part": "1/2", "time_limit": 1}),
        ("render", {"guide_input": "a", "guide_output": "b", "integrator": "guided"}),
        ("render", {"samples": 2, "resume": True}),
        ("illuminate", {"particles": 10, "part": "1/2"}),
        ("bake_part", {"part": "1/1", "checkpoint": "a", "direct_only": True, "light_input": "b"}),
    ],
)
def test_arguments_that_contradict_one_another_are_refused(job: str, arguments: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="exclude|needs"):
        getattr(SCENE, job)(**arguments)


def test_outputs_replace_neither_inputs_nor_one_another(tmp_path: Path) -> None:
    path = tmp_path / "part"
    SCENE.render(samples=1, part="1/1", checkpoint=path)
    with pytest.raises(ValueError, match="input"):
        glanz.merge_checkpoints([path], path)
    with pytest.raises(FileNotFoundError, match="folder"):
        glanz.merge_checkpoints([path], tmp_path / "none" / "x")
    both = tmp_path / "both"
    with pytest.raises(ValueError, match="two outputs"):
        SCENE.render(integrator="guided", checkpoint=both, guide_output=both)
    with pytest.raises(ValueError, match="input"):
        SCENE.bake_part("1/1", path, light_input=path, resume=True)
    ball = tmp_path / "ball.ply"
    SCENE.save(ball)
    with pytest.raises(ValueError, match="input"):
        glanz.load(ball).save(ball)


def test_illuminance_under_a_point_light_follows_the_inverse_square() -> None:
    # 100 cd, 2 m above the middle of a floor of 1 m: E = I h / r^3.
    cells = 8
    floor = Plane(x=[-0.5, 0.5], y=[-0.5, 0.5], material=Diffuse(reflectance=0), receiver="floor", cells=[cells, cells])
    lamp = PointLight(from_=(0, 0, 2), candela=100)
    scene = SceneDescription(lights=[lamp], shapes=[floor]).load()
    maps = scene.illuminate(method="integrate", tolerance=1e-4).receivers["floor"]
    x, y, _ = maps.positions.T.reshape(3, cells, cells)
    np.testing.assert_allclose(maps.lux, 200 / (x**2 + y**2 + 4) ** 1.5, rtol=2e-3)
    assert maps.areas.sum() == pytest.approx(1)
    traced = scene.illuminate(particles=200_000)
    assert traced["floor"].mean == pytest.approx(maps.mean, rel=0.05)
    assert traced.balance is not None and traced.balance.closes_to < 1e-9
    frame = traced.to_pandas()
    assert len(frame) == cells**2 and frame["lux"].max() == traced["floor"].lux.max()


def test_lux_maps_are_saved(tmp_path: Path) -> None:
    result = SCENE.illuminate(particles=1000)
    assert list(result) == ["floor"] and "floor" in result and "wall" not in result and len(result) == 1
    names = {path.name for path in result.save(tmp_path / "lux")}
    assert {"report.json", "floor.csv", "floor.exr"} <= names
    facts = json.loads((tmp_path / "lux" / "report.json").read_text())["facts"]
    assert facts == {key: list(value) if isinstance(value, tuple) else value for key, value in result.facts.items()}
    assert result["floor"].lux.shape == (3, 4)


def test_facts_of_a_calculation_have_their_types() -> None:
    facts = SCENE.illuminate(particles=1000, seed=2**63 + 1, room=(20, 20, 5.5), threads=1).facts
    assert facts["glanz_version"] == glanz.__version__ and facts["method"] == "trace"
    assert facts["particles"] == 1000 and facts["seed"] == 2**63 + 1 and facts["threads"] == 1
    assert facts["room_m"] == (20.0, 20.0, 5.5) and facts["complete"] is True and facts["far_field"] is False
    assert isinstance(facts["particles"], int) and isinstance(facts["seconds"], float) and facts["seconds"] > 0
    assert str(facts["end_utc"]).endswith("Z")


def test_illuminance_of_a_light_is_in_lux() -> None:
    floor = Plane(x=[-0.5, 0.5], y=[-0.5, 0.5], material=Diffuse(reflectance=0), receiver="floor", cells=[1, 1])
    sun = DistantLight(from_=(0, 0, 1), to=(0, 0, 0), illuminance=10_000)
    lux = SceneDescription(lights=[sun], shapes=[floor]).load().illuminate(method="integrate")["floor"].lux
    assert lux[0, 0] == pytest.approx(10_000, rel=1e-5)


def test_bake_gives_pages_charts_and_a_model(tmp_path: Path) -> None:
    maps = SCENE.bake(density=4, rays=16)
    assert maps.irradiance[0].ndim == 3 and maps.radiance[0].max() > 0
    lit = [chart for chart in maps.charts if chart.page is not None]
    assert lit and lit[0].irradiance.shape[2] == 3
    for chart in lit:
        assert chart.page is not None and chart.corner is not None
        (column, row), (height, width) = chart.corner, chart.irradiance.shape[:2]
        place = maps.irradiance[chart.page][row : row + height, column : column + width]
        np.testing.assert_array_equal(place, chart.irradiance)
    assert [path.name for path in maps.save(tmp_path / "room.glb")] == ["room.glb", "room.exr"]


def test_progress_reaches_its_function_and_its_exceptions_end_the_job(tmp_path: Path) -> None:
    seen: list[glanz.Progress] = []
    SCENE.render(samples=4, progress=seen.append)
    assert seen and seen[-1].fraction == 1 and seen[-1].phase

    class Stop(Exception):
        pass

    def stop(progress: glanz.Progress) -> None:
        raise Stop

    checkpoint = tmp_path / "state"
    with pytest.raises(Stop):
        SCENE.render(samples=10**8, progress=stop, checkpoint=checkpoint)
    done = glanz.merge([checkpoint])
    assert done.samples is not None and 0 < done.samples < 10**8


def test_slow_progress_functions_do_not_delay_the_end() -> None:
    begun = time.monotonic()
    SCENE.render(time_limit=3, progress=lambda _: time.sleep(1.5))
    # Six messages or more, each for 1.5 s, would take nine seconds; one under way at the end and the last one take three.
    assert time.monotonic() - begun < 7.5


def test_other_threads_run_during_a_render() -> None:
    counts = [0]
    stopped = threading.Event()

    def count() -> None:
        while not stopped.wait(0.001):
            counts[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    SCENE.render(time_limit=0.5)
    stopped.set()
    thread.join()
    assert counts[0] > 20


@pytest.mark.skipif(os.name == "nt", reason="signals are those of POSIX")
def test_interrupt_ends_a_render_within_two_seconds_and_keeps_its_samples(tmp_path: Path) -> None:
    checkpoint = tmp_path / "state"
    sent: list[float] = []

    def interrupt() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        SCENE.render(samples=10**8, checkpoint=checkpoint)
    assert time.monotonic() - sent[0] < 2.0
    samples = glanz.merge([checkpoint]).samples
    assert samples is not None and samples > 0


def test_bar_is_shown_with_and_without_tqdm(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    SCENE.render(samples=2, progress=True)
    assert "100 %|" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    SCENE.render(samples=2, progress=True)
    assert "rendering 100 %" in capsys.readouterr().err
    with pytest.raises(TypeError, match="progress"):
        SCENE.render(samples=2, progress="yes")  # type: ignore[arg-type]


def test_area_light_emits_the_flux_that_it_states() -> None:
    lamp = Disk(light=AreaLight(lumens=700), transform=Transform.translate(0, 0, 1))
    boxed = SceneDescription(shapes=[lamp]).load().illuminate(particles=1000, room=(1, 1, 1))
    assert boxed.balance is not None and boxed.balance.emitted == pytest.approx(700, rel=1e-6)


def test_far_field_has_the_resolution_asked_for(tmp_path: Path) -> None:
    scene = SceneDescription(lights=[PointLight(I=1)]).load()
    for resolution, counts in [(10, "36 planes with 19 gamma angles"), ((5, 90), "4 planes with 37 gamma angles"), (None, "24 planes with 37 gamma angles")]:
        lamp = scene.illuminate(particles=20_000, far_field=True, resolution=resolution)
        assert counts in lamp.summary()
        lamp.save_far_field(tmp_path / "lamp.ldt")
        assert (tmp_path / "lamp.ldt").stat().st_size > 1000
    for arguments in ({"resolution": 5}, {"resolution": 0.01, "far_field": True}, {"resolution": (1, 91), "far_field": True}):
        with pytest.raises(ValueError, match="resolution"):
            scene.illuminate(particles=10, **arguments)  # type: ignore[arg-type]


def test_rays_that_leave_a_scene_are_saved_and_have_its_flux(tmp_path: Path) -> None:
    scene = SceneDescription(lights=[PointLight(candela=100)]).load()
    lamp, path = scene.illuminate(particles=5000, ray_file=True, title="Desk lamp"), tmp_path / "lamp.tm25ray"
    assert lamp.save_ray_file(path, threads=1, progress=lambda _: None) == 5000
    # Tables and texts of the file, and seven numbers of 32 bits for each ray.
    assert path.stat().st_size == 36_288 + 28 * 5000
    assert lamp.facts["ray_file_rays"] == 5000 and lamp.facts["ray_file_lm"] == pytest.approx(400 * np.pi, rel=1e-6)
    assert "Desk lamp" in lamp.summary()
    with pytest.raises(ValueError, match="tm25ray"):
        lamp.save_ray_file(tmp_path / "lamp.rays")
    with pytest.raises(FileNotFoundError, match="folder"):
        lamp.save_ray_file(tmp_path / "none" / "lamp.tm25ray")
    with pytest.raises(ValueError, match="only goal"):
        scene.illuminate(error=0.1, ray_file=True)
    with pytest.raises(ValueError, match="did not keep"):
        SCENE.illuminate(particles=1000).save_ray_file(path)
    # Without rays, an old file stays.
    inside, size = SceneDescription(lights=[PointLight(from_=(0.5, 0.5, 0.5), candela=100)]).load(), path.stat().st_size
    boxed = inside.illuminate(particles=1000, ray_file=True, room=(1, 1, 1))
    with pytest.warns(glanz.GlanzWarning, match="no light leaves"):
        assert boxed.save_ray_file(path) == 0
    assert boxed.facts["ray_file_rays"] == 0 and path.stat().st_size == size


def test_unbounded_plane_is_no_receiver() -> None:
    scene = SceneDescription(lights=[PointLight(from_=(0, 0, 1))], shapes=[Plane(receiver="floor")]).load()
    with pytest.raises(glanz.GlanzError, match="no end"):
        scene.illuminate(particles=100)


def test_first_picture_after_the_import_is_quick() -> None:
    code = (
        "import time; begun = time.perf_counter(); import glanz; "
        "image = glanz.loads('WorldBegin LightSource \"infinite\" Shape \"sphere\"').render(size=(64, 48), samples=4); "
        "image.to_png(); print(time.perf_counter() - begun)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    print(f"from import to first picture: {float(run.stdout):.2f} s")
    assert float(run.stdout) < 10


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
def test_job_in_a_forked_process_fails_rather_than_waits() -> None:
    code = (
        "import os, glanz\nscene = glanz.loads('WorldBegin LightSource \"infinite\" Shape \"sphere\"')\nscene.render(size=(8, 8), samples=1)\n"
        "child = os.fork()\nif child:\n    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\nelse:\n"
        "    try:\n        scene.render(size=(8, 8), samples=1)\n    except glanz.GlanzError as error:\n        os._exit(7 if 'forked' in str(error) else 1)\n"
        "    os._exit(2)\n"
    )
    subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=True, timeout=60)


def test_parts_of_light_and_bakes_join_to_the_whole(tmp_path: Path) -> None:
    parts = [f"{number}/3" for number in (1, 2, 3)]
    paths = [tmp_path / f"{number}.part" for number in (1, 2, 3)]
    traced, whole = SCENE.illuminate(particles=4000), tmp_path / "whole"
    for part, path in zip(parts, paths):
        SCENE.illuminate(particles=4000, part=part, checkpoint=path)
    with pytest.raises(glanz.GlanzError, match="part 2/3"):
        glanz.merge_checkpoints([paths[0], paths[2]], whole)
    with pytest.raises(glanz.GlanzError, match="illuminance"):
        glanz.merge(paths)
    glanz.merge_checkpoints(paths, whole)
    joined = SCENE.illuminate(particles=4000, checkpoint=whole, resume=True)
    for name, lux in traced.receivers.items():
        assert np.array_equal(joined[name].lux, lux.lux)
    baked, light = SCENE.bake(density=2, rays=16), tmp_path / "light"
    for number, part in enumerate(parts):
        SCENE.bake_part(part, tmp_path / f"{number}.light", density=2, rays=16)
    glanz.merge_checkpoints([tmp_path / f"{number}.light" for number in range(3)], light)
    again = SCENE.bake(density=2, rays=16, checkpoint=light, resume=True)
    assert baked.irradiance
    for page, other in zip(baked.irradiance + baked.radiance, again.irradiance + again.radiance, strict=True):
        assert np.array_equal(page, other)
    with pytest.raises(ValueError, match="one computation"):
        SCENE.illuminate(method="integrate", particles=4000, part="1/3", checkpoint=tmp_path / "none")
