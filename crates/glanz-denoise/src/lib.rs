#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! - `finder`: places of the library;
//! - `library`: its functions, with all unsafe code of this crate.

mod finder;
mod library;

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink};

use library::{FilterImage, FilterMonitor, Library};

pub use finder::DIRECTORY_VARIABLE;

/// Time between two reports of progress.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Number of filters for one picture.
const FILTERS: f64 = 3.0;

/// Errors of denoising.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DenoiseError {
    /// The library is in none of the usual places.
    #[error("Open Image Denoise was not found ({})", tried.join("; "))]
    NotFound {
        /// The files that were tried, each with the reason why it was not loaded.
        tried: Vec<String>,
    },
    /// A library without a function, as of another major version.
    #[error("{} has no function {function:?}; version 2 of Open Image Denoise is needed", path.display())]
    Version {
        /// The library.
        path: PathBuf,
        /// Name of the function.
        function: String,
    },
    /// The number of pixels of a layer differs from that of the picture.
    #[error("{layer}: {found} pixels; the picture has {expected}")]
    Size {
        /// Name of the layer.
        layer: &'static str,
        /// Its number of pixels.
        found: usize,
        /// That of the picture.
        expected: usize,
    },
    /// An error of the library, in its own words.
    #[error("Open Image Denoise: {0}")]
    Library(String),
    /// The job was cancelled.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// A picture with noise, row by row from the top, and what its surfaces look like without light.
#[derive(Clone, Debug)]
pub struct NoisyPicture {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Linear radiance.
    pub color: Vec<[f32; 3]>,
    /// Albedo of the first hit, in [0, 1]: the mean over all samples, 0 for those without a hit.
    pub albedo: Vec<[f32; 3]>,
    /// Shading normal of the first hit: the mean over all samples, 0 for those without a hit.
    pub normal: Vec<[f32; 3]>,
}

/// The library, ready for pictures.
#[derive(Debug)]
pub struct Denoiser {
    library: Library,
}

impl Denoiser {
    /// Loads the library from the folder in the environment variable [`DIRECTORY_VARIABLE`], or from where the system keeps libraries.
    ///
    /// # Errors
    /// [`DenoiseError::NotFound`] or [`DenoiseError::Version`]; [`DenoiseError::Library`] if it cannot start.
    pub fn load() -> Result<Self, DenoiseError> {
        Self::load_first(&finder::candidates(std::env::var_os(DIRECTORY_VARIABLE).as_deref()))
    }

    fn load_first(candidates: &[PathBuf]) -> Result<Self, DenoiseError> {
        let mut tried = Vec::new();
        for path in candidates {
            match Library::open(path)? {
                Ok(library) => return Ok(Self { library }),
                Err(reason) => tried.push(reason),
            }
        }
        Err(DenoiseError::NotFound { tried })
    }

    /// The colours of `picture` without noise.
    ///
    /// Noise in albedo and normals (of a lens, of edges within a pixel) is removed first. `threads`: their number; 0 for all processors.
    ///
    /// # Errors
    /// [`DenoiseError::Size`] for layers of another size, [`DenoiseError::Library`], [`DenoiseError::Interrupted`].
    pub fn denoise(
        &self,
        picture: NoisyPicture,
        threads: usize,
        sink: &mut dyn ProgressSink,
        cancel: &CancelFlag,
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        picture.check()?;
        cancel.check()?;
        if picture.color.is_empty() {
            return Ok(picture.color);
        }
        let monitor = FilterMonitor { cancel, done: AtomicU64::new(0) };
        let finished = AtomicU32::new(0);
        let start = Instant::now();
        // The library has threads of its own; this one shows the progress.
        let denoised = thread::scope(|scope| {
            let worker = scope.spawn(|| self.filter(picture, threads, &monitor, &finished));
            while !worker.is_finished() {
                thread::sleep(POLL_INTERVAL);
                let done = f64::from(finished.load(Ordering::Relaxed))
                    + f64::from_bits(monitor.done.load(Ordering::Relaxed));
                let share = (done / FILTERS).min(1.0);
                sink.on_progress(&JobProgress::by_work("denoising", share, start.elapsed()));
            }
            worker.join().unwrap_or_else(|_| Err(DenoiseError::Library("its thread panicked".to_owned())))
        });
        cancel.check()?;
        denoised
    }

    /// Runs the filters one after the other; `finished`: number of those done.
    fn filter(
        &self,
        mut picture: NoisyPicture,
        threads: usize,
        monitor: &FilterMonitor<'_>,
        finished: &AtomicU32,
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let (size, device) = (picture.size, self.library.device(threads)?);
        let mut output = vec![[0.0; 3]; picture.color.len()];
        for (name, pixels) in [("albedo", &mut picture.albedo), ("normal", &mut picture.normal)] {
            let mut images =
                [FilterImage { name, pixels }, FilterImage { name: "output", pixels: &mut output }];
            device.filter(size, &mut images, &[], monitor)?;
            pixels.copy_from_slice(&output);
            monitor.done.store(0, Ordering::Relaxed);
            finished.fetch_add(1, Ordering::Relaxed);
        }
        let mut images = [
            FilterImage { name: "color", pixels: &mut picture.color },
            FilterImage { name: "albedo", pixels: &mut picture.albedo },
            FilterImage { name: "normal", pixels: &mut picture.normal },
            FilterImage { name: "output", pixels: &mut output },
        ];
        device.filter(size, &mut images, &["hdr", "cleanAux"], monitor)?;
        Ok(output)
    }
}

impl NoisyPicture {
    fn check(&self) -> Result<(), DenoiseError> {
        let expected = self.size[0] as usize * self.size[1] as usize;
        let layers = [("colour", &self.color), ("albedo", &self.albedo), ("normals", &self.normal)];
        match layers.into_iter().find(|(_, pixels)| pixels.len() != expected) {
            Some((layer, pixels)) => Err(DenoiseError::Size { layer, found: pixels.len(), expected }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_job::Silent;

    #[test]
    fn library_that_is_not_there_is_reported_with_every_file_tried() {
        let folder = tempfile::tempdir().unwrap();
        let files = finder::candidates(Some(folder.path().as_os_str()));
        let Err(DenoiseError::NotFound { tried }) = Denoiser::load_first(&files) else { panic!() };
        assert_eq!(tried.len(), files.len());
        assert!(tried.iter().all(|reason| reason.contains("OpenImageDenoise")), "{tried:?}");
    }

    #[test]
    fn file_that_is_no_library_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("libOpenImageDenoise.so.2");
        std::fs::write(&path, "no library").unwrap();
        assert!(matches!(Denoiser::load_first(&[path]), Err(DenoiseError::NotFound { .. })));
    }

    #[test]
    fn layers_of_another_size_are_refused() {
        let layer = vec![[0.5; 3]; 6];
        let picture =
            NoisyPicture { size: [3, 2], color: layer.clone(), albedo: layer.clone(), normal: layer };
        assert!(picture.check().is_ok());
        let short = NoisyPicture { albedo: vec![[0.5; 3]; 5], ..picture };
        assert!(matches!(short.check(), Err(DenoiseError::Size { layer: "albedo", found: 5, expected: 6 })));
    }

    /// Tests of the nightly run, which need the library, see [`DIRECTORY_VARIABLE`].
    mod heavy {
        use super::*;

        #[test]
        fn noise_is_removed_and_the_border_of_the_albedo_stays() {
            let size = [64, 48];
            let left = |i: usize| i % 64 < 32;
            let mut state = 1_u32;
            let mut noise = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state) as f32 / 4_294_967_296.0 - 0.5
            };
            let pixels = 64 * 48;
            let albedo: Vec<[f32; 3]> = (0..pixels).map(|i| [if left(i) { 0.2 } else { 0.8 }; 3]).collect();
            let color: Vec<[f32; 3]> = albedo.iter().map(|a| a.map(|a| 3.0 * a * (1.0 + noise()))).collect();
            let normal = vec![[0.0, 0.0, 1.0]; pixels];
            let clean = albedo.clone();
            let picture = NoisyPicture { size, color: color.clone(), albedo, normal };
            let found =
                Denoiser::load().unwrap().denoise(picture, 0, &mut Silent, &CancelFlag::default()).unwrap();
            let error = |of: &[[f32; 3]]| -> f32 {
                of.iter().zip(&clean).map(|(x, a)| (x[1] - 3.0 * a[1]).powi(2)).sum::<f32>() / pixels as f32
            };
            assert!(error(&found) < 0.02 * error(&color), "{} {}", error(&found), error(&color));
            let cancelled = CancelFlag::default();
            cancelled.cancel();
            let picture = NoisyPicture { size, color: color.clone(), albedo: color.clone(), normal: color };
            let end = Denoiser::load().unwrap().denoise(picture, 0, &mut Silent, &cancelled);
            assert!(matches!(end, Err(DenoiseError::Interrupted(_))));
        }
    }
}
