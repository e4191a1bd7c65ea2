//! Warnings and other events of a job.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use glanz_report::number::{grouped, plural, significant};
use glanz_scene::Diagnostic;
use glanz_transport::SampleRanges;

use crate::error::Error;
use crate::merge::MissingParts;
use crate::render::{Darkness, RenderPlan};

/// Warning about something that a job repaired, left out or could not decide. The result of the job contains all warnings, too.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// A part of the scene.
    Scene(Diagnostic),
    /// More parts of the scene than are listed.
    SceneOmitted {
        /// Number of those not listed.
        count: usize,
    },
    /// Materials that are not diffuse, in a job that treats all as diffuse.
    NotDiffuse {
        /// Their number.
        materials: usize,
    },
    /// Participating media, in a job that treats them as empty space.
    MediaLeftOut {
        /// What does so: an integrator with its name, or another job.
        what: String,
    },
    /// No light leaves the scene, so that no ray file was written.
    NoRays,
    /// Unbounded surfaces or surfaces without parameters, which cast shadows but carry no light.
    LeftOut {
        /// Their number.
        surfaces: usize,
    },
    /// Nothing in the scene gives light, so that the result is black.
    NoLight,
    /// A picture without any light, although its scene has lights.
    Black {
        /// The reason.
        reason: Darkness,
    },
    /// Light of lamps that leaves the scene, although only that on receivers is wanted.
    EscapedFlux {
        /// Luminous flux that leaves, lm.
        flux: f64,
        /// Its share of the flux that the lamps emit, from 0 to 1.
        share: f64,
    },
    /// Rays for which it was not decided whether they hit a freeform surface.
    Undecided {
        /// Their number.
        rays: u64,
    },
    /// Samples that were infinite or not a number, and counted as black.
    Dropped {
        /// Their number.
        samples: u64,
    },
    /// Samples too bright to be added, which were clipped.
    Cut {
        /// Their number.
        samples: u64,
    },
    /// Photons, which see neither participating media nor sampled wavelengths, are left out.
    NoPhotons,
    /// Tiles of the picture that had not reached its noise level, or lay beside such a tile, at the last check.
    NoiseAboveLevel {
        /// Their number.
        tiles: u64,
    },
    /// Noise was to be removed from the picture, but the job was cancelled.
    NotDenoised,
    /// Edges were to be drawn over the picture, but the scene has none.
    NoEdges,
    /// Edges were to be drawn over the picture, but there are too many.
    TooManyEdges {
        /// Their number.
        edges: u64,
    },
    /// Edges were to be drawn over the picture, but the camera cannot project them.
    EdgesOfCamera,
    /// A camera that models cannot represent: its picture is off-centre, sheared or mirrored, or not that of a perspective or orthographic one.
    CameraLeftOut,
    /// Charts with fewer texels than requested, because their sides have at most 4096.
    CoarseCharts {
        /// Their number.
        charts: usize,
    },
    /// Elements of the hierarchical solver that are larger than its error bound requires, because more would take too much memory.
    CoarseElements {
        /// Their number.
        elements: usize,
        /// Largest error of the light between two groups of them, relative to the flux of the scene.
        error: f64,
        /// The bound on `error`, which it exceeds.
        bound: f64,
    },
    /// Lights without extent, whose reflections are not integrated.
    Unreflected {
        /// Their number.
        lights: u64,
    },
    /// A part that cannot be read, and was not joined with the others.
    PartLeftOut {
        /// Its file and what is wrong with it.
        reason: String,
    },
    /// Parts of a job that are not among those that were joined.
    PartsMissing(MissingParts),
    /// Cells of a receiver that other things cover, which do not count.
    CoveredCells {
        /// Name of the receiver.
        receiver: String,
        /// Number of cells of which nothing is left, and of those of which a part is.
        covered: [u64; 2],
        /// Number of all cells.
        cells: u64,
    },
    /// A beam that is too narrow for the angles by which light that leaves the scene is counted.
    CoarseFarField {
        /// Angle within which its intensity is at least half of the peak, degrees.
        beam: f64,
        /// Step of the angles there, degrees.
        step: f64,
    },
    /// Large errors of the light that leaves the scene by direction.
    NoisyFarField {
        /// Largest relative standard error of intensities of at least a tenth of the peak.
        error: f64,
    },
    /// Glare that is not rated.
    GlareNotRated {
        /// The reason.
        reason: String,
    },
    /// A receiver that receives light only on the side that is not counted.
    DarkSide {
        /// Name of the receiver.
        receiver: String,
        /// Luminous flux on the other side, lm.
        other_side: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene(diagnostic) => f.write_str(&diagnostic.sentence()),
            Self::SceneOmitted { count } => write!(f, "{count} more of the kind \"scene\" are not shown"),
            Self::NotDiffuse { materials } => write!(
                f,
                "{} not diffuse; what they reflect or transmit counts as reflected diffusely",
                plural(*materials as u64, "material is", "materials are")
            ),
            Self::MediaLeftOut { what } => write!(
                f,
                "{what} does not see the participating media of the scene: they count as empty space; render with \
                 the integrator \"path\" or \"guided\" to see them"
            ),
            Self::NoRays => {
                write!(f, "no ray file is written: no light leaves the scene; leave out what encloses it")
            }
            Self::LeftOut { surfaces } => write!(
                f,
                "{} no parameters or no end: they cast shadows, but carry no light",
                plural(*surfaces as u64, "surface has", "surfaces have")
            ),
            Self::NoLight => f.write_str(
                "nothing in this scene gives light: the result is black; add a light, or an emission to a shape",
            ),
            Self::Black { reason } => write!(f, "the picture is black: {reason}"),
            Self::EscapedFlux { flux, share } => write!(
                f,
                "{} % of the light of the lamps ({} lm) leaves the scene; if it is a closed room, check its gaps, and whether \
                 lamps lie outside",
                significant(100.0 * share),
                significant(*flux)
            ),
            Self::Undecided { rays } => write!(
                f,
                "{} could not be decided against a freeform surface; a point may be missing",
                plural(*rays, "ray", "rays")
            ),
            Self::Dropped { samples } => write!(
                f,
                "{} infinite or not a number and counted as black",
                plural(*samples, "sample was", "samples were")
            ),
            Self::Cut { samples } => {
                write!(f, "{} too bright to be added and cut", plural(*samples, "sample was", "samples were"))
            }
            Self::NoPhotons => f.write_str(
                "no photons are traced: they see neither participating media nor wavelengths; caustics are found by chance alone",
            ),
            Self::NoiseAboveLevel { tiles } => {
                let tiles = plural(*tiles, "tile", "tiles");
                write!(
                    f,
                    "{tiles} of 16 x 16 pixels had not reached the noise level at the last check, or lay beside such a tile; more samples or more time are needed"
                )
            }
            Self::NotDenoised => f.write_str("the picture has its noise: the job ended before it was removed"),
            Self::NoEdges => f.write_str("no edges are drawn: only models from CAD files have edges"),
            Self::TooManyEdges { edges } => write!(
                f,
                "no edges are drawn: the scene has {edges}, more than {}",
                glanz_transport::MAX_EDGES
            ),
            Self::EdgesOfCamera => f.write_str(
                "no edges are drawn: they cannot be projected through the lenses of a realistic camera",
            ),
            Self::CameraLeftOut => f.write_str(
                "a camera that is not perspective or orthographic, or whose picture is off-centre, sheared or mirrored, is not in the model",
            ),
            Self::CoarseCharts { charts } => write!(
                f,
                "{} fewer texels than asked for: 4096 along a side is the most",
                plural(*charts as u64, "chart has", "charts have")
            ),
            Self::CoarseElements { elements, error, bound } => write!(
                f,
                "the solver ended at {} because more would take too much memory: the light between two parts of the \
                 scene has errors of up to {} % of all light instead of {} %; choose fewer texels per metre, or the \
                 method \"gather\"",
                plural(*elements as u64, "element", "elements"),
                significant(100.0 * error),
                100.0 * bound,
            ),
            Self::Unreflected { lights } => write!(
                f,
                "{} no extent: reflections of it in mirrors are not integrated",
                plural(*lights, "light has", "lights have")
            ),
            Self::PartLeftOut { reason } => write!(f, "{reason}; this part is left out"),
            Self::PartsMissing(parts) => parts.fmt(f),
            Self::CoveredCells { receiver, covered: [whole, part], cells } => write!(
                f,
                "other things stand on \"{receiver}\" or reach through it: {} of {} are covered, which do not count, {} in part",
                grouped(*whole),
                plural(*cells, "cell", "cells"),
                grouped(*part)
            ),
            Self::CoarseFarField { beam, step } => write!(
                f,
                "the beam of the light that leaves the scene is {} degrees wide, and the angles of its intensities are {} \
                 degrees apart, too far to show its peak and its width",
                significant(*beam),
                significant(*step)
            ),
            Self::NoisyFarField { error } => write!(
                f,
                "intensities of the light that leaves the scene, of at least a tenth of the peak, have standard errors of up to {:.0} %; more \
                 particles or larger steps are needed",
                100.0 * error
            ),
            Self::GlareNotRated { reason } => write!(f, "UGR is not rated: {reason}"),
            Self::DarkSide { receiver, other_side } => write!(
                f,
                "the side of \"{receiver}\" that counts receives no light, the other side {other_side:.4} lm: \
                 \"string receiverside\" selects the side"
            ),
        }
    }
}

/// Event of a job.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum JobEvent<'a> {
    /// Something was repaired, left out or not decided.
    Warning(&'a Warning),
    /// The checkpoint to resume does not exist yet: the job starts anew.
    NoCheckpoint(&'a Path),
    /// The job resumes a checkpoint.
    Resumed {
        /// The file.
        path: &'a Path,
        /// Its content.
        state: &'a ResumedState,
    },
    /// The scene is ready, rays follow.
    RenderStarted(&'a RenderPlan),
    /// The scene is divided, light follows.
    #[cfg(feature = "radiosity")]
    BakeStarted {
        /// Texels per metre.
        density: f64,
        /// Number of elements.
        elements: usize,
    },
    /// The materials are ready, triangles follow.
    #[cfg(feature = "formats")]
    TessellationStarted {
        /// Number of shapes, those of a group counted once.
        shapes: usize,
    },
    /// The receivers are ready, light follows.
    #[cfg(feature = "illumination")]
    IlluminateStarted {
        /// Number of receivers.
        receivers: usize,
        /// Number of their cells.
        cells: usize,
    },
    /// A checkpoint could not be written during the job. Writing is tried again; only the last checkpoint must succeed.
    CheckpointFailed(&'a Error),
}

/// Progress stored in a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ResumedState {
    /// Samples of each pixel.
    Samples {
        /// Those in the checkpoint.
        done: SampleRanges,
        /// Those wanted; `None` if a time or a noise level ends the render.
        wanted: Option<Range<u32>>,
    },
    /// Number of points at which indirect light was gathered.
    Places(usize),
    /// All light maps.
    AllLight,
    /// Particles.
    Particles {
        /// Their number.
        done: u64,
        /// The number wanted; `None` if a time or an error ends the calculation.
        wanted: Option<u64>,
    },
    /// Number of paths from cells, and particles.
    Paths(u64),
    /// Steps of an inverse design.
    Steps {
        /// Their number.
        done: u32,
        /// The largest number.
        wanted: u32,
    },
}

#[cfg(test)]
mod tests {
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{LightDescription, MaterialKind, MediumDescription, ShapeDescription};

    use super::*;
    use crate::{LoadedScene, RenderOptions};

    #[test]
    fn integrators_that_do_not_see_media_warn_of_it() {
        let scene = |media: &[MediumDescription], camera_medium| {
            SceneBuilder::new()
                .resolution(2, 2)
                .edit(|description| {
                    description.media.extend(media.iter().cloned());
                    description.camera_medium = camera_medium;
                })
                .light(LightDescription::point([0.0; 3], 1.0))
                .shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5))
                .describe()
                .unwrap()
        };
        let warnings_of = |name: &str, spectral, media: &[MediumDescription], camera_medium| {
            let scene = LoadedScene::from_description("fog", scene(media, camera_medium)).render();
            let options = RenderOptions { spectral, ..RenderOptions::default() };
            scene.options(options).samples(1).integrator(name).run().unwrap().warnings().to_vec()
        };
        let warnings = |name: &str, media: &[MediumDescription], camera_medium| {
            warnings_of(name, false, media, camera_medium)
        };
        let fog = [MediumDescription::new(0.0, 1.0)];
        for name in ["light", "whitted", "distributed"] {
            let what = format!("the integrator {name:?}");
            assert_eq!(warnings(name, &fog, Some(0)), [Warning::MediaLeftOut { what }]);
            assert_eq!(warnings(name, &fog, None), [], "a medium without a place");
            assert_eq!(warnings(name, &[], None), []);
        }
        for name in ["path", "guided"] {
            assert_eq!(warnings(name, &fog, Some(0)), []);
        }
        assert_eq!(warnings("sppm", &fog, Some(0)), [Warning::NoPhotons]);
        assert_eq!(warnings("sppm", &[], None), []);
        assert_eq!(warnings_of("sppm", true, &[], None), [Warning::NoPhotons]);
        assert_eq!(warnings_of("path", true, &[], None), []);
    }

    #[test]
    fn warning_of_coarse_elements_has_numbers_and_a_remedy() {
        let warning = Warning::CoarseElements { elements: 838_000, error: 0.0123, bound: 1e-4 };
        assert_eq!(
            warning.to_string(),
            "the solver ended at 838 000 elements because more would take too much memory: the light between two parts of \
             the scene has errors of up to 1.230 % of all light instead of 0.01 %; choose fewer texels per metre, or the method \
             \"gather\""
        );
    }
}
