//! A picture depends on scene, settings and seed, and on nothing else.

use std::time::Duration;

use crate::common::*;
use glanz_job::{CancelFlag, JobEnd, JobIdentity, JobPart, JobProgress, ProgressSink, Silent, WorkCount};
use glanz_math::DVec3;
use glanz_sampling::SamplerKind;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_transport::{
    AovSet, Checkpoint, CheckpointError, CheckpointHead, Film, FilmError, FilmJoin, MergeChecks, MergeError,
    MissingSamples, PictureIdentity, RenderError, RenderSettings, RenderSink, SamplePlan, SampleRanges,
    merge, render,
};

fn scene() -> SceneBuilder {
    let filter =
        FilterDescription { kind: FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 }, radius: [2.0, 2.0] };
    let view = looking(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO, [37, 23], 0.9);
    checkered(view, ImageFilter::Anisotropic { most: 4 }, 8, 10.0)
        .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
        .shape(ShapeDescription::sphere(0.5).translated([1.2, 0.0, -0.4]), glass())
        .shape(ShapeDescription::disk(1.0).translated([-1.0, 0.0, 1.0]), "checkered")
        .light(LightDescription::infinite([0.7; 3]))
        .light(LightDescription::point(DVec3::new(2.0, 2.0, -3.0), [20.0; 3]))
        .edit(|scene| scene.filter = filter)
}

fn runs() -> Vec<Run> {
    let mut runs = Vec::new();
    for (integrator, sampler) in [
        ("path", SamplerKind::Sobol),
        ("distributed", SamplerKind::Independent),
        ("whitted", SamplerKind::Regular),
        ("path", SamplerKind::Stratified),
        ("light", SamplerKind::Sobol),
        ("sppm", SamplerKind::Sobol),
    ] {
        runs.push(Run { sampler, aovs: AovSet::ALL, ..Run::new(integrator, 5, 16) });
    }
    let sampler = SamplerKind::Sobol;
    runs.push(Run { branching: Some(3), sampler, ..Run::new("path", 5, 16) });
    runs.push(Run { spectral: true, sampler, aovs: AovSet::ALL, ..Run::new("light", 5, 16) });
    runs
}

/// Resumes `film` under changed settings.
fn resume(
    run: &Run,
    film: Film,
    change: impl FnOnce(&mut RenderSettings),
    sink: &mut dyn RenderSink,
    cancel: &CancelFlag,
) -> (Film, JobEnd) {
    let builder = scene();
    let mut settings = run.settings(&builder);
    change(&mut settings);
    let integrator = run.integrator_settings().build();
    let outcome = render(&resolved(&builder), integrator.as_ref(), &settings, film, sink, cancel).unwrap();
    (outcome.film, outcome.end)
}

fn fresh(run: &Run) -> Film {
    Film::try_new(run.format(&scene())).unwrap()
}

fn part(run: &Run, range: std::ops::Range<u32>) -> Film {
    let (film, finished) =
        resume(run, fresh(run), |s| s.samples = range, &mut Silent, &CancelFlag::default());
    assert_eq!(finished, JobEnd::Complete);
    film
}

fn identity(run: &Run) -> PictureIdentity {
    let builder = scene();
    PictureIdentity {
        scene: 99,
        film: run.format(&builder),
        filter: described(&builder).filter,
        integrator: run.integrator_settings(),
        sampler: run.sampler,
        seed: run.seed,
        samples_per_pixel: 64,
        guide: None,
        version: glanz_job::current_version(),
    }
}

#[test]
fn number_of_threads_does_not_change_a_bit() {
    for run in runs() {
        let two = run.outcome(&scene()).film;
        for threads in [1, 5] {
            let other = Run { threads, ..run.clone() }.outcome(&scene()).film;
            assert_eq!(other, two, "{}", run.name());
            assert_eq!(other.to_pixels(), two.to_pixels());
        }
    }
}

#[test]
fn odd_splits_and_their_order_do_not_change_a_bit() {
    for run in runs() {
        let whole = part(&run, 0..16);
        let mut film = fresh(&run);
        for range in [5..6, 11..16, 0..3, 3..5, 4..12] {
            (film, _) = resume(&run, film, |s| s.samples = range, &mut Silent, &CancelFlag::default());
        }
        assert_eq!(film, whole, "{}", run.name());
    }
}

/// The checkpoints of the parts of 16 samples, from the last to the first.
fn parts(run: &Run, count: u32) -> Vec<Checkpoint> {
    let plan = SamplePlan::try_new(0..16, count).unwrap();
    let numbers = (1..=count).rev().map(|number| JobPart::try_new(number, count).unwrap());
    let parts = numbers.map(|number| {
        let mut film = fresh(run);
        film.add_plans([plan.clone()]);
        let range = plan.share(number);
        (film, _) = resume(run, film, |s| s.samples = range, &mut Silent, &CancelFlag::default());
        Checkpoint { identity: identity(run), film }
    });
    parts.collect()
}

/// The film of these files, as far as they are undamaged, in a file if it takes more than `memory` bytes.
fn joined(files: &[Vec<u8>], hold: bool, memory: u64) -> (Checkpoint, Vec<CheckpointError>) {
    let mut checks = MergeChecks::default();
    let heads: Vec<_> = files.iter().map(|bytes| CheckpointHead::read(bytes.as_slice())).collect();
    let heads: Vec<_> = heads.into_iter().enumerate().filter_map(|(i, head)| Some((i, head.ok()?))).collect();
    let heads = heads.into_iter().map(|(i, mut head)| {
        checks.admit(i, &mut head).unwrap();
        (i, head)
    });
    let heads: Vec<_> = heads.collect();
    let mut join = FilmJoin::try_new(checks, memory).unwrap();
    let mut errors = Vec::new();
    for (i, head) in heads {
        let sums = &files[i][head.before_sums() as usize..];
        errors.extend(join.add(&head, sums, hold, |_| Ok(())).err());
    }
    (join.finish(), errors)
}

#[test]
fn merged_parts_are_one_run() {
    for run in runs() {
        let whole = Checkpoint { identity: identity(&run), film: part(&run, 0..16) };
        for count in [1, 3, 7] {
            let parts = parts(&run, count);
            let files: Vec<_> = parts.iter().map(|part| part.to_bytes().unwrap()).collect();
            assert_eq!(Checkpoint::from_bytes(&files[0]).as_ref(), Ok(&parts[0]));
            assert_eq!(
                merge(parts).unwrap().to_bytes().unwrap(),
                whole.to_bytes().unwrap(),
                "{}",
                run.name()
            );
            let least = if run.format(&scene()).fits_in_file() { 0 } else { u64::MAX };
            for (hold, memory) in [(false, least), (true, least), (true, u64::MAX)] {
                let (join, errors) = joined(&files, hold, memory);
                assert_eq!(
                    (join.to_bytes().unwrap() == whole.to_bytes().unwrap(), errors),
                    (true, vec![]),
                    "{}",
                    run.name()
                );
            }
        }
    }
    assert_eq!(merge([]), Err(MergeError::Empty));
}

#[test]
fn what_is_there_is_joined_and_the_rest_rendered_later() {
    let run = &runs()[4];
    let whole = part(run, 0..16);
    let mut files: Vec<_> = parts(run, 7).iter().map(|part| part.to_bytes().unwrap()).collect();
    // From the last to the first: part 3 of 7, samples 4 and 5.
    files.remove(4);
    let (join, errors) = joined(&files, true, u64::MAX);
    assert_eq!(errors, []);
    let (third, samples) = (JobPart::try_new(3, 7).unwrap(), SampleRanges::from(4..6));
    let missing = [MissingSamples { part: third, samples, is_whole: true }];
    assert_eq!(join.film.missing_samples(), missing);
    let saved = Checkpoint::from_bytes(&join.to_bytes().unwrap()).unwrap();
    assert_eq!(saved.film.missing_samples(), missing);
    for samples in [4..6, 0..16] {
        let film = saved.film.clone();
        let (film, _) = resume(run, film, |s| s.samples = samples, &mut Silent, &CancelFlag::default());
        assert_eq!(film, whole);
    }
}

#[test]
fn damaged_parts_leave_no_trace_in_the_film() {
    let run = &runs()[4];
    let files: Vec<_> = parts(run, 3).iter().map(|part| part.to_bytes().unwrap()).collect();
    let (rest, _) = joined(&[files[0].clone(), files[2].clone()], true, u64::MAX);
    let length = files[1].len();
    let sums = CheckpointHead::read(files[1].as_slice()).unwrap().before_sums() as usize;
    let least = if run.format(&scene()).fits_in_file() { 0 } else { u64::MAX };
    let mut damaged = Vec::new();
    for at in [0, 9, 15, 21, 40, 120, sums - 1, sums, sums + 5000, length - 5, length - 1] {
        let mut bytes = files[1].clone();
        bytes[at] ^= 4;
        damaged.push((at, bytes));
    }
    for end in [0, 5, 30, sums - 1, sums, length / 2, length - 1] {
        damaged.push((end, files[1][..end].to_vec()));
    }
    damaged.push((length, [files[1].as_slice(), &[0]].concat()));
    for (at, bytes) in damaged {
        let in_head = CheckpointHead::read(bytes.as_slice()).is_err();
        for memory in [least, u64::MAX] {
            let files = [files[0].clone(), bytes.clone(), files[2].clone()];
            let (join, errors) = joined(&files, true, memory);
            assert!(in_head == errors.is_empty(), "at {at}: {errors:?}");
            assert_eq!(in_head, at < sums, "at {at}");
            assert_eq!(join, rest, "at {at}");
        }
    }
}

#[test]
fn sums_of_a_part_that_was_saved_anew_are_refused() {
    let files: Vec<_> = parts(&runs()[4], 2).iter().map(|part| part.to_bytes().unwrap()).collect();
    let sums = CheckpointHead::read(files[0].as_slice()).unwrap().before_sums() as usize;
    // The head of one state, the sums and the end of another.
    let mixed = [&files[0][..sums], &files[1][sums..]].concat();
    assert!(Checkpoint::from_bytes(&mixed).is_err());
    assert_eq!(joined(&[mixed], true, u64::MAX).1.len(), 1);
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    for run in runs() {
        let whole = Checkpoint { identity: identity(&run), film: part(&run, 0..16) };
        let halves =
            [9..16, 0..9].map(|range| Checkpoint { identity: identity(&run), film: part(&run, range) });
        let overlap = merge([halves[0].clone(), whole.clone()]).unwrap_err();
        assert_eq!(overlap, MergeError::Overlap { first: 0, second: 1, samples: 9..16 });
        let mut foreign = halves[1].clone();
        foreign.identity.seed = 7;
        let error = merge([halves[0].clone(), foreign]).unwrap_err().to_string();
        assert_eq!(error, "parts 0 and 1 are of different pictures: the seed is 2 in part 0 and 7 in part 1");
        let mut foreign = halves[1].clone();
        foreign.identity.integrator.branching += 1;
        assert!(matches!(merge([halves[0].clone(), foreign]), Err(MergeError::Picture { .. })));
        let mut foreign = halves[1].clone();
        foreign.identity.integrator.spectral ^= true;
        assert!(matches!(merge([halves[0].clone(), foreign]), Err(MergeError::Picture { .. })));
    }
}

/// Asks to stop after some passes.
struct Stopper<'a> {
    after: u32,
    cancel: &'a CancelFlag,
    reports: Vec<(WorkCount, f64)>,
}

impl ProgressSink<Film> for Stopper<'_> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.reports.push((progress.count.unwrap(), progress.fraction));
        self.after -= 1;
        if self.after == 0 {
            self.cancel.cancel();
        }
    }
}

impl RenderSink for Stopper<'_> {}

#[test]
fn interrupted_and_resumed_run_is_one_run() {
    for run in runs() {
        let whole = part(&run, 0..16);
        let cancel = CancelFlag::default();
        let mut stopper = Stopper { after: 1, cancel: &cancel, reports: Vec::new() };
        let (film, finished) = resume(&run, fresh(&run), |_| {}, &mut stopper, &cancel);
        assert_eq!(finished, JobEnd::Interrupted);
        assert_eq!(film.samples().total(), 1);
        let (count, fraction) = stopper.reports[0];
        assert_eq!((count.done, count.wanted), (1, Some(16)));
        assert!(fraction < 1.0);
        let saved = Checkpoint { identity: identity(&run), film }.to_bytes().unwrap();
        let resumed = Checkpoint::from_bytes(&saved).unwrap();
        assert_eq!(resumed.identity.check(&identity(&run)), Ok(()));
        let (film, finished) = resume(&run, resumed.film, |_| {}, &mut Silent, &CancelFlag::default());
        assert_eq!((&film, finished), (&whole, JobEnd::Complete));
        // A finished one resumed is finished.
        let (again, finished) = resume(&run, film, |_| {}, &mut Silent, &CancelFlag::default());
        assert_eq!((again, finished), (whole, JobEnd::Complete));
    }
}

#[test]
fn films_in_files_are_those_in_memory() {
    let mut tried = 0;
    for run in runs() {
        let format = run.format(&scene());
        if !format.fits_in_file() {
            assert!(matches!(Film::try_new_within(format, 0), Err(FilmError::Limit { limit: 0, .. })));
            continue;
        }
        tried += 1;
        let whole = part(&run, 0..16);
        // Two rows of tiles, one after the other.
        let fresh = Film::try_new_within(format, 0).unwrap();
        let (half, _) = resume(
            &run,
            fresh.clone(),
            |settings| settings.samples = 0..7,
            &mut Silent,
            &CancelFlag::default(),
        );
        assert!(half.is_in_file() && half != fresh);
        let mut bytes = Vec::new();
        let identity = identity(&run);
        Checkpoint::write(&identity, &half, &mut bytes).unwrap();
        assert_eq!(bytes, Checkpoint { identity, film: part(&run, 0..7) }.to_bytes().unwrap());
        let read = Checkpoint::read_within(bytes.as_slice(), 0).unwrap().film;
        assert!(read.is_in_file());
        let (mut film, _) =
            resume(&run, read, |settings| settings.samples = 0..12, &mut Silent, &CancelFlag::default());
        film.merge(&part(&run, 12..16)).unwrap();
        assert!(film.is_in_file());
        assert_eq!(film, whole);
        let pixels = whole.to_pixels().unwrap();
        assert_eq!(film.to_pixels().unwrap(), pixels);
        let rows = film.rows_to_pixels(15..18).unwrap();
        for (some, all) in rows.channels().iter().zip(pixels.channels()) {
            assert_eq!(some.values[..], all.values[15 * 37..18 * 37]);
        }
        assert_eq!(film.is_black(), Ok(false));
        assert_eq!(fresh.is_black(), Ok(true));
    }
    assert!(tried >= 5);
}

/// Counts checkpoints and remembers the last.
#[derive(Default)]
struct Saver(Vec<Film>);

impl ProgressSink<Film> for Saver {
    fn checkpoint_interval(&self) -> Option<Duration> {
        Some(Duration::ZERO)
    }

    fn on_checkpoint(&mut self, film: &Film) {
        self.0.push(film.clone());
    }
}

impl RenderSink for Saver {}

#[test]
fn checkpoint_on_the_way_is_a_shorter_run() {
    let run = &runs()[0];
    let mut saver = Saver::default();
    let (film, _) = resume(run, fresh(run), |_| {}, &mut saver, &CancelFlag::default());
    // One before each pass but the first, which takes one sample.
    assert_eq!(saver.0[0], part(run, 0..1));
    for saved in &saver.0 {
        let taken = saved.samples().total() as u32;
        assert!(taken < 16);
        assert_eq!(*saved, part(run, 0..taken));
    }
    assert_eq!(film, part(run, 0..16));
}

#[test]
fn time_limit_ends_a_run_with_whole_passes() {
    let run = Run { samples: 0..1_000_000, ..runs()[0].clone() };
    let limit = Duration::from_millis(300);
    let begun = std::time::Instant::now();
    let (film, finished) =
        resume(&run, fresh(&run), |s| s.time_limit = Some(limit), &mut Silent, &CancelFlag::default());
    assert_eq!(finished, JobEnd::TimeUp);
    // Generous: the machine may be busy. All samples would take hours.
    assert!(begun.elapsed() < 20 * limit);
    let taken = film.samples().total() as u32;
    assert_eq!(film, part(&run, 0..taken));
    // No time at all: the first pass is still made.
    let (film, finished) = resume(
        &run,
        fresh(&run),
        |s| s.time_limit = Some(Duration::ZERO),
        &mut Silent,
        &CancelFlag::default(),
    );
    assert_eq!((film.samples().total(), finished), (1, JobEnd::TimeUp));
}

#[test]
fn crop_window_is_a_part_of_the_whole_picture() {
    let run = &runs()[0];
    let whole = run.outcome(&scene()).film.to_pixels().unwrap();
    let cropped = scene().edit(|scene| scene.film.crop = [0.3, 0.8, 0.1, 0.6]);
    let film = run.outcome(&cropped).film;
    let (crop, part) = (film.format().crop, film.to_pixels().unwrap());
    for channel in part.channels() {
        let full = whole.channel(&channel.name).unwrap();
        for (i, [x, y]) in crop.pixels().enumerate() {
            let expected = full[(y * whole.width() + x) as usize];
            assert_eq!(channel.values[i].to_bits(), expected.to_bits(), "{} at {x} {y}", channel.name);
        }
    }
}

#[test]
fn geometry_channels_tell_what_the_camera_sees() {
    // Head on to a sphere of radius 1 at 4 m; the middle pixel sees its pole.
    let builder = one_pixel(DVec3::new(0.0, 0.0, -4.0), DVec3::ZERO)
        .shape(ShapeDescription::plane().translated([0.0, 0.0, 9.0]), diffuse(0.2))
        .shape(ShapeDescription::sphere(1.0), diffuse(0.6))
        .light(LightDescription::infinite([1.0; 3]));
    for integrator in ["path", "distributed", "whitted"] {
        let run = Run { aovs: AovSet::ALL, sampler: SamplerKind::Center, ..Run::new(integrator, 3, 3) };
        let pixels = run.outcome(&builder).film.to_pixels().unwrap();
        let value = |name: &str| pixels.channel(name).unwrap()[0];
        let pole = DVec3::new(value("P.X").into(), value("P.Y").into(), value("P.Z").into());
        assert!((pole + DVec3::Z).length() < 1e-15, "{pole}");
        assert_eq!([value("N.Z"), value("Ns.Z"), value("Z")], [-1.0, -1.0, 3.0]);
        assert_eq!([value("Albedo.R"), value("Albedo.B"), value("id")], [0.6, 0.6, 1.0]);
        assert!(value("v") >= 0.0 && value("u") <= 1.0);
    }
}

#[test]
fn film_for_another_filter_is_refused() {
    let run = &runs()[0];
    let mut format = run.format(&scene());
    format.signed = false;
    let builder = scene();
    let integrator = run.integrator_settings().build();
    let error = render(
        &resolved(&builder),
        integrator.as_ref(),
        &run.settings(&builder),
        Film::try_new(format).unwrap(),
        &mut Silent,
        &CancelFlag::default(),
    );
    assert!(matches!(error, Err(RenderError::Filter)));
}

#[test]
fn more_samples_than_the_sums_hold_are_refused() {
    let run = Run { samples: 0..u32::MAX, ..runs()[0].clone() };
    let builder = scene();
    let integrator = run.integrator_settings().build();
    let error = render(
        &resolved(&builder),
        integrator.as_ref(),
        &run.settings(&builder),
        fresh(&run),
        &mut Silent,
        &CancelFlag::default(),
    );
    assert!(matches!(error, Err(RenderError::Film(FilmError::Samples(4_294_967_295)))));
}
