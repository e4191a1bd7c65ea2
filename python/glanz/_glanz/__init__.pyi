"""The native module. Everything of it is in `glanz`."""

import os
import pathlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._errors import Diagnostic
from .._progress import Progress
from .._results import Comparison, FluxBalance, LightChart, LuxMap, RenderStatistics

_Path: TypeAlias = str | os.PathLike[str]
_Progress: TypeAlias = bool | Callable[[Progress], object] | None

__version__: str

class Image:
    """A picture: rendered, joined from parts, read from a file, or made of an array.

    Parameters
    ----------
    array
        H x W x 3 or H x W: linear light of any type of float, or sRGB bytes (uint8).

    Raises
    ------
    ValueError
        If the array has another shape or no pixels.
    TypeError
        If its elements are neither floats nor uint8.
    """

    def __init__(self, array: ArrayLike) -> None: ...
    @property
    def array(self) -> NDArray[np.float32]:
        """Linear red, green and blue, H x W x 3, from the top left. Always the same array, which may be changed; `save` writes the picture as it
        was: make an ``Image`` of a changed array to save it."""
    @property
    def aovs(self) -> dict[str, NDArray[np.float32]]:
        """Further channels by name: ``Albedo``, ``P`` (position, m), ``N`` and ``Ns`` (geometric and shading normal) and ``Variance`` are
        H x W x 3, ``uv`` is H x W x 2, ``Z`` (distance, m) and ``id`` (number of the shape, -1 for none) are H x W."""
    @property
    def standard_error(self) -> NDArray[np.float32] | None:
        """Standard error of each value of `array`, if rendered with ``variance=True``."""
    @property
    def width(self) -> int:
        """Pixels per row."""
    @property
    def height(self) -> int:
        """Number of rows."""
    @property
    def samples(self) -> int | None:
        """Samples per pixel; None if not rendered."""
    @property
    def sample_ranges(self) -> list[tuple[int, int]]:
        """The samples as ranges, ends excluded."""
    @property
    def denoised(self) -> bool:
        """Whether noise was removed."""
    @property
    def warnings(self) -> list[str]:
        """Warnings of the render."""
    @property
    def statistics(self) -> RenderStatistics | None:
        """Statistics of the render; None if not rendered, zeros if joined from parts."""
    def save(self, path: _Path, *, exposure: float = 0.0, tone: str = "linear") -> None:
        """Writes the picture; the extension selects the format: .exr (all channels), .png, .hdr or .pfm.

        Parameters
        ----------
        path
            The file, which is replaced as a whole.
        exposure
            Stops by which PNG pictures are brightened.
        tone
            Tone curve of PNG pictures: ``linear``, ``reinhard`` or ``filmic``.

        Raises
        ------
        ValueError
            For another extension or curve.
        OSError
            If the file cannot be written.
        """
    def save_checkpoint(self, path: _Path) -> None:
        """Writes the samples, to be resumed by `Scene.render` or joined by `merge`."""
    def save_guide(self, path: _Path) -> None:
        """Writes the guide that the integrator ``guided`` has learnt, for ``guide_input``."""
    def to_png(self, *, exposure: float = 0.0, tone: str = "linear") -> bytes:
        """The picture as the bytes of a PNG file."""
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]: ...
    def _repr_png_(self) -> bytes: ...

class Illumination:
    """Illuminance on the receivers of a scene."""

    @property
    def receivers(self) -> dict[str, LuxMap]:
        """The maps by receiver; names that occur several times get a number: ``desk``, ``desk 2``."""
    @property
    def integrated(self) -> dict[str, LuxMap]:
        """The maps by integration if the method was ``both``."""
    def __getitem__(self, name: str) -> LuxMap: ...
    def __contains__(self, name: object) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    @property
    def balance(self) -> FluxBalance | None:
        """Emitted light and where it ended; None for an integration."""
    @property
    def facts(self) -> dict[str, str | bool | int | float | tuple[float, float, float]]:
        """Facts about the calculation as in report.json, with the unit at the end of a name: ``particles``, ``seconds``, ``relative_error``."""
    @property
    def warnings(self) -> list[str]:
        """Warnings of the calculation."""
    @property
    def complete(self) -> bool:
        """Whether the goal was reached, rather than the time limit."""
    def summary(self) -> str:
        """The table of the results."""
    def save(self, folder: _Path) -> list[pathlib.Path]:
        """Writes the reports, and for each receiver table (CSV), numbers (EXR), false colours (PNG) and isolux lines (SVG); returns the paths."""
    def save_far_field(self, path: _Path) -> None:
        """Writes the candela distribution of all light that left the scene, .ldt or .ies, if ``far_field=True``. Interpolated between its angles,
        it has the flux of that light; `summary` has its peak, angles and errors."""
    def save_ray_file(self, path: _Path, *, threads: int | None = None, progress: _Progress = None) -> int:
        """Writes the rays of all particles that leave the scene, .tm25ray (IES TM-25), if ``ray_file=True``; they are traced once more for it. Returns the number of
        rays, which is in `facts`, too; if it is 0, no file is written.

        Parameters
        ----------
        path
            The file, which is replaced as a whole.
        threads, progress
            As for `Scene.render`.

        Raises
        ------
        ValueError
            For another extension, a pipe or a device, or if the scene was not kept.
        OSError
            If the file cannot be written; the illuminance is not lost.
        """
    def to_pandas(self) -> Any:
        """One row for each cell of all receivers, see `LuxMap.to_pandas`."""
    def _repr_html_(self) -> str: ...

class LightMaps:
    """Light on the surfaces of a scene, as baked."""

    @property
    def irradiance(self) -> list[NDArray[np.float32]]:
        """Irradiance of the texels of each page, S x S x 3, in units of radiance."""
    @property
    def radiance(self) -> list[NDArray[np.float32]]:
        """Radiance that leaves the texels of each page, S x S x 3."""
    @property
    def charts(self) -> list[LightChart]:
        """Light of the parts of surfaces, the two sides of each adjacent."""
    @property
    def elements(self) -> int:
        """Number of elements that exchanged light."""
    @property
    def seconds(self) -> float:
        """Wall time."""
    @property
    def warnings(self) -> list[str]:
        """Warnings of the bake."""
    def save(
        self,
        path: _Path,
        *,
        tolerance: float | None = None,
        exposure: float = 0.0,
        tone: str = "linear",
        lightmap: str = "exr",
    ) -> list[pathlib.Path]:
        """Writes a model (.glb) that shows the light, and the irradiance beside it; returns the paths.

        Parameters
        ----------
        path
            The model.
        tolerance
            Largest distance of triangles from the surface, m; by default 0.001, or less in a small scene.
        exposure, tone
            As for `Image.save`.
        lightmap
            Format of the irradiance: ``exr`` or ``png``.
        """

class Scene:
    """A scene or a model that was read by `load` or `loads`; its jobs do not change it.

    Jobs release the interpreter lock. Ctrl-C and exceptions of the progress function end them after the step under way, and what is done is
    in the checkpoint, if there is one.
    """

    @property
    def name(self) -> str:
        """Name of the file or text."""
    @property
    def text(self) -> str | None:
        """The text of a scene that was read by `loads`."""
    @property
    def files(self) -> list[pathlib.Path]:
        """Paths of all files that were read."""
    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the film, pixels."""
    @property
    def samples(self) -> int:
        """Samples per pixel."""
    @property
    def is_model(self) -> bool:
        """Whether camera and light are those of a studio, which `render` adds."""
    @property
    def warnings(self) -> list[str]:
        """Warnings of reading, with file, line and column."""
    @property
    def diagnostics(self) -> list[Diagnostic]:
        """The same with their parts."""
    def bounds(self) -> NDArray[np.float64]:
        """Smallest and largest coordinates of the surfaces, m, 2 x 3."""
    def save(self, path: _Path, *, threads: int | None = None, progress: _Progress = None) -> list[pathlib.Path]:
        """Writes the surfaces as triangles (.glb, .obj, .ply), or exactly (.pbrt) for models and scenes that were read from a text.
        Files that such a text names relative to a folder are not found from another one.

        Returns
        -------
        The paths of the files.
        """
    def render(
        self,
        *,
        size: tuple[int, int] | None = None,
        samples: int | None = None,
        integrator: str | None = None,
        sampler: str | None = None,
        seed: int | None = None,
        noise: float | None = None,
        sample_range: tuple[int, int] | None = None,
        part: str | None = None,
        time_limit: float | None = None,
        light_sampling: bool | None = None,
        spectral: bool = False,
        branching: int | None = None,
        guide: str | None = None,
        guide_input: _Path | None = None,
        guide_output: _Path | None = None,
        light_input: _Path | None = None,
        aovs: str | Sequence[str] | None = None,
        variance: bool = False,
        edges: bool | float | None = None,
        denoise: bool = False,
        threads: int | None = None,
        checkpoint: _Path | None = None,
        resume: bool = False,
        progress: _Progress = None,
    ) -> Image:
        """Renders. The picture has the bits of ``glanz render`` with the same settings; they do not depend on threads or interruptions.

        Parameters
        ----------
        size
            Width and height, pixels.
        samples
            Samples per pixel.
        integrator
            ``path``, ``guided``, ``light``, ``sppm``, ``radiosity``, ``whitted`` or ``distributed``.
        sampler
            ``sobol``, ``independent``, ``stratified``, ``regular`` or ``center``.
        seed
            Another seed gives another, independent picture.
        noise
            Relative standard error, 1e-6 to 1, at which parts of the picture take no more samples.
        sample_range
            Only the samples from the first up to, but not including, the second number; `merge` joins such parts.
        part
            ``"K/N"``: part K, from 1, of N of the samples; `merge` joins the parts. ``denoise`` has no effect on it.
        time_limit
            Seconds, instead of a number of samples.
        light_sampling
            Whether lights are sampled at every hit.
        spectral
            Four wavelengths per path instead of red, green and blue.
        branching
            Paths into which a camera ray divides at its first rough surface (``path``, ``distributed``).
        guide, guide_input, guide_output
            Kind of guide of ``guided``, file of a learnt one, file to write it to.
        light_input
            Checkpoint of a finished bake (``radiosity``).
        aovs
            Channels for `Image.aovs`: ``"all"`` or names of ``Albedo P N Ns uv Z id Variance``.
        variance
            Whether `Image.standard_error` is known.
        edges
            Whether the edges of CAD models are drawn, or the width of their lines in pixels.
        denoise
            Whether noise is removed by Open Image Denoise, if it is installed.
        threads
            Number of threads; by default all processors.
        checkpoint
            File for the state. It is written after one second, then at doubling intervals up to 30 seconds (longer if writing would take more than 5 % of
            the time), and at the end. Another process that names the same file is refused.
        resume
            Whether an existing checkpoint is resumed.
        progress
            True for a bar (of tqdm, if installed), or a function of a `Progress`.

        Raises
        ------
        SceneError
            If the scene is not one.
        ValueError, TypeError
            For arguments without meaning, or that contradict one another.
        OSError
            For files that cannot be read or written; FileExistsError for a checkpoint that is not to be resumed. A picture whose
            checkpoint or guide could not be written is the attribute ``image`` of the exception.
        GlanzError
            For everything else that fails.
        """
    def illuminate(
        self,
        *,
        method: str = "auto",
        particles: int | None = None,
        time_limit: float | None = None,
        error: float | None = None,
        tolerance: float = 0.01,
        daylight: bool = False,
        room: tuple[float, float, float] | None = None,
        cells: int | None = None,
        texel: float | None = None,
        far_field: bool = False,
        resolution: float | tuple[float, float] | None = None,
        ray_file: bool = False,
        title: str | None = None,
        seed: int | None = None,
        max_depth: int | None = None,
        part: str | None = None,
        threads: int | None = None,
        checkpoint: _Path | None = None,
        resume: bool = False,
        progress: _Progress = None,
    ) -> Illumination:
        """Computes the illuminance on receivers: shapes with the name of a receiver, and the walls of ``room``.

        Parameters
        ----------
        method
            ``auto``: direct light and light after one reflection in a mirror by integration, the rest by paths from the cells and by particles;
            with ``particles``, ``part`` or ``far_field`` it is ``trace``: particles from the lights, all light; ``integrate``: deterministic, direct
            light and light after one reflection in a mirror; ``both``: the two before, compared.
        particles, time_limit, error
            End of the tracing: number of particles, seconds, relative standard error; by default an error of 0.01.
        tolerance
            Relative error of the integration in every cell.
        daylight
            Replaces all light of the scene by an overcast sky that gives the open ground 10 000 lx; daylight factors are shares of that.
        room
            Adds the walls of a box from the origin to this corner, m, which absorb all light.
        cells, texel
            Cells along the longer side (64) of receivers without their own, or the length of a cell, m.
        far_field
            Whether the directions of light that leaves the scene are counted.
        resolution
            Steps of gamma and of C for this, or one number for both, degrees; without it they are small where the intensity changes.
        ray_file
            Whether the scene is kept for `Illumination.save_ray_file`; needs ``particles``, but no receiver.
        title
            Title of the reports, such as the name of the project; the name of the scene's file without its extension by default.
        seed
            Another seed gives another, independent result.
        max_depth
            Largest number of scattering events of a particle (1000).
        part
            ``"K/N"``: part K, from 1, of N of the particles, into the checkpoint; `merge_checkpoints` joins the parts.
        threads, checkpoint, resume, progress
            As for `render`.

        Raises
        ------
        As `render`.
        """
    def bake(
        self,
        *,
        density: float = 50.0,
        rays: int | None = None,
        method: str = "gather",
        interpolation: str | None = None,
        threads: int | None = None,
        checkpoint: _Path | None = None,
        resume: bool = False,
        progress: _Progress = None,
    ) -> LightMaps:
        """Computes light maps by radiosity: all materials count as diffuse.

        Parameters
        ----------
        density
            Texels per metre.
        rays
            Rays that gather indirect light at a point, 16 to 65536 (512).
        method
            ``gather``, or ``radiosity``: a preview in a tenth of the time.
        interpolation
            Of ``radiosity``, from elements to texels.
        threads, checkpoint, resume, progress
            As for `render`.

        Raises
        ------
        As `render`.
        """

    def bake_part(
        self,
        part: str,
        checkpoint: _Path,
        *,
        density: float = 50.0,
        rays: int | None = None,
        direct_only: bool = False,
        light_input: _Path | None = None,
        threads: int | None = None,
        resume: bool = False,
        progress: _Progress = None,
    ) -> None:
        """Computes a part of a bake by ``gather``. `merge_checkpoints` joins all parts into a checkpoint, from which ``bake(checkpoint=...,
        resume=True)`` makes the light maps of one bake.

        Parameters
        ----------
        part
            ``"K/N"``: part K, from 1, of N.
        checkpoint
            File for the light of the part.
        direct_only
            Whether the part ends with the direct light, which every part computes otherwise.
        light_input
            Checkpoint of joined parts with ``direct_only``, from which the part begins.
        density, rays, threads, resume, progress
            As for `bake`.

        Raises
        ------
        As `render`.
        """

def load(path: str, arguments: dict[str, object]) -> Scene: ...
def loads(
    text: str, name: str, folder: str | None, origins: list[tuple[int, str]], arguments: dict[str, object]
) -> Scene: ...
def read_image(path: _Path) -> Image:
    """Reads a picture: OpenEXR, PNG, Radiance HDR, PFM, JPEG, TGA, BMP, QOI or PNM.

    Raises
    ------
    OSError
        If the file cannot be read.
    GlanzError
        If it is not a picture.
    """

def merge(paths: Sequence[_Path], *, partial: bool = False, threads: int | None = None, progress: _Progress = None) -> Image:
    """Joins checkpoints of disjoint samples into one picture, with the bits of one render of all samples. Files are read once; they take the
    memory of one of them.

    Parameters
    ----------
    paths
        Checkpoints of renders with ``part`` or ``sample_range``.
    partial
        Whether parts that are missing or damaged are left out, with a warning, instead of being errors.
    threads, progress
        As for `Scene.render`.

    Raises
    ------
    GlanzError
        For parts of different pictures or with common samples, and for missing or damaged ones.
    OSError
        If a file cannot be read.
    """

def merge_checkpoints(
    paths: Sequence[_Path], checkpoint: _Path, *, partial: bool = False, threads: int | None = None, progress: _Progress = None
) -> None:
    """Joins checkpoints of parts of a picture, a calculation of illuminance or a bake into the file ``checkpoint``, from which the job is resumed.

    Parameters and exceptions are those of `merge`. The whole and one part are in memory, sums of a picture that take more than half of it in temporary files.
    """

def compare(picture: Image | ArrayLike | _Path, reference: Image | ArrayLike | _Path) -> Comparison:
    """Measures the differences of a picture from a reference, as ``glanz compare`` does.

    Parameters
    ----------
    picture, reference
        Images, arrays (see `Image`) or paths of picture files, of the same size. If one is a PNG file or has bytes, FLIP compares both as
        displayed, otherwise as light at all relevant exposures.

    Raises
    ------
    ValueError
        For pictures of different sizes, or without a pixel that is finite in both.
    """
