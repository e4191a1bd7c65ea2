//! Rays of a scene by their parameters on lights and mirrors, and the merits of their light with its derivatives.

use glanz_job::{CancelFlag, ResourceBudget};
use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3, Ray};
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_scene::{Description, Interaction, Scene};
use glanz_shading::bsdf::{Lobe, TransportMode};
use rayon::prelude::*;

use super::error::OptimizeError;
use super::merit::{Merit, MeritValue, ReflectedRay, TargetMeasure};
use super::ray_sources::{EmitterPart, EmittingSurface, MirrorSurface, ReflectingPart, emitters, mirrors};
use super::reflection::{EmittingPoint, Reflection, ReflectionGradient};
use super::sensitivity::{MirrorVariables, SensitivityTerm, directions, light_variables};
use super::surface_basis::LocalFrame;
use super::targets::merit;

/// Largest number of chunks of rays, each of which has sums of its own.
const CHUNKS: usize = 64;
/// Least number of rays of a chunk.
const CHUNK: usize = 1024;
/// Fraction of a distance within which a ray meets the point it was aimed at.
const AIM: f64 = 1e-6;
/// Fraction of the way to a mirror at which the test of a shadow begins, so that the surface of the light is not met again.
const SHADOW_START: f64 = 1e-9;

/// Rays of all lights over all mirrors: fixed parameters, which no displacement moves across a border.
#[derive(Clone, Debug)]
pub(super) struct RayModel {
    rays: Vec<RaySample>,
    terms: Vec<SensitivityTerm>,
    /// Direction of each variable in the world.
    directions: Vec<DVec3>,
    /// Variables that move each light.
    light_variables: Vec<Vec<usize>>,
    merits: Vec<(Merit, f64)>,
    /// For each ray and merit.
    passages: Vec<Passage>,
    /// Limits of each resolved scene.
    budget: ResourceBudget,
}

/// Losses of a ray at its mirror and behind it.
#[derive(Clone, Copy, Debug, Default)]
struct Passage {
    /// 0 if the light does not arrive on the mirror.
    reflectance: f64,
    /// Whether something is between the mirror and the receiver.
    is_blocked: bool,
}

/// A ray with its displacements.
struct DisplacedRay<'a> {
    sample: &'a RaySample,
    passages: &'a [Passage],
    from: EmittingPoint,
    frame: LocalFrame,
    reflection: Reflection,
}

#[derive(Clone, Debug)]
struct RaySample {
    from: EmittingPoint,
    light: usize,
    mirror: usize,
    frame: LocalFrame,
    terms: std::ops::Range<usize>,
    /// lm per unit of [`Reflection::flux`].
    weight: f64,
}

/// Merit and measures of a design.
#[derive(Clone, Debug)]
pub(super) struct DesignValue {
    /// The weighted sum of the merits.
    pub(super) merit: f64,
    /// Its derivatives by the displacements, 1/m; empty if they were not asked for.
    pub(super) gradient: Vec<f64>,
    pub(super) measures: Vec<TargetMeasure>,
}

impl RayModel {
    /// Rays of the scene, about `count`.
    ///
    /// # Errors
    /// [`OptimizeError`] if lights, mirrors or targets are not of the supported kinds.
    pub(super) fn new(
        description: &Description,
        count: usize,
        seed: u64,
        budget: &ResourceBudget,
    ) -> Result<Self, OptimizeError> {
        let scene = resolved(description, &[], budget)?;
        let placed = scene.placed_surfaces();
        let (emitters, emitted) = emitters(&scene, &placed)?;
        let mirrors = mirrors(description, &scene, &placed);
        let design = &description.design;
        let merits = design.targets.iter().enumerate();
        let merits = merits
            .map(|(index, target)| Ok((merit(description, &scene, index, target, emitted)?, target.weight)));
        let mut model = Self {
            rays: Vec::new(),
            terms: Vec::new(),
            directions: directions(description),
            light_variables: light_variables(description, &scene, &placed),
            merits: merits.collect::<Result<_, OptimizeError>>()?,
            passages: Vec::new(),
            budget: budget.clone(),
        };
        if model.merits.is_empty() {
            return Err(OptimizeError::NoTarget);
        }
        let per_pair = count.max(1).div_ceil((emitters.len() * mirrors.len()).max(1));
        let per_pair = u32::try_from(per_pair).unwrap_or(u32::MAX);
        let mut key = seed;
        for mirror in &mirrors {
            let variables = MirrorVariables::of(description, mirror.shape);
            for emitter in &emitters {
                let points = ScrambledSobol::new(key);
                key = key.wrapping_add(1);
                for i in 0..per_pair {
                    let [a, b, c, d] = points.point(i.reverse_bits()).map(unit);
                    let share = 1.0 / f64::from(per_pair);
                    model.add_ray(emitter, mirror, &variables, [DVec2::new(a, b), DVec2::new(c, d)], share);
                }
            }
        }
        model.aim(&scene, &[]);
        scene.check_textures()?;
        if !model.has_light(None) {
            return Err(OptimizeError::NoReflection("a mirror"));
        }
        for (merit, _) in &model.merits {
            let Merit::Collimation { mirror, .. } = merit else { continue };
            if !model.has_light(Some(*mirror)) {
                return Err(OptimizeError::NoReflection("the mirror with the target \"collimation\""));
            }
        }
        Ok(model)
    }

    fn add_ray(
        &mut self,
        emitter: &EmitterPart<'_>,
        mirror: &ReflectingPart<'_>,
        variables: &MirrorVariables,
        [on_mirror, on_emitter]: [DVec2; 2],
        share: f64,
    ) {
        let (uv, mut weight) = mirror.part.at(on_mirror);
        weight *= share * emitter.brightness;
        let from = match &emitter.surface {
            EmittingSurface::Point(position) => {
                EmittingPoint { position: *position, normal: None, two_sided: false }
            }
            EmittingSurface::Area { placed, face, part, two_sided } => {
                let (uv, area) = part.at(on_emitter);
                let Some(point) = placed.at(*face, uv, false) else { return };
                weight *= area * point.area_element;
                let (position, normal) = (point.at.point.position, Some(point.at.point.normal));
                EmittingPoint { position, normal, two_sided: *two_sided }
            }
        };
        let first = self.terms.len();
        let frame = match &mirror.surface {
            MirrorSurface::Freeform(basis) => {
                let factors = basis.factors(uv);
                let frame = basis.frame(&factors);
                variables.add_terms(basis.indexed(factors), &mut self.terms);
                frame
            }
            MirrorSurface::Fixed { placed, face } => {
                let Some(point) = placed.at(*face, uv, false) else { return };
                let (x, y) = point.at.point.normal.any_orthonormal_pair();
                LocalFrame { position: point.at.point.position, tangents: [x * point.area_element, y] }
            }
        };
        let whole = |&variable| SensitivityTerm { variable, position: 1.0, tangents: [0.0; 2] };
        self.terms.extend(variables.offsets.iter().map(whole));
        // There is no normal where parameters degenerate.
        if frame.tangents[0].cross(frame.tangents[1]) == DVec3::ZERO {
            self.terms.truncate(first);
            return;
        }
        let terms = first..self.terms.len();
        self.rays.push(RaySample { from, light: emitter.light, mirror: mirror.shape, frame, terms, weight });
    }

    /// Whether light is reflected, by the mirror of a shape or any.
    fn has_light(&self, mirror: Option<usize>) -> bool {
        let mut rays = self.rays.iter().zip(self.passages.chunks(self.merits.len()));
        rays.any(|(ray, passages)| {
            mirror.is_none_or(|mirror| mirror == ray.mirror)
                && passages.iter().any(|passage| passage.reflectance > 0.0)
                && Reflection::new(&ray.from, &ray.frame).flux * ray.weight > 0.0
        })
    }

    /// Sums over all rays, in chunks whose number does not depend on the threads; `add` adds a ray to `count` sums.
    fn summed(
        &self,
        displacements: &[f64],
        count: usize,
        add: impl Fn(&DisplacedRay<'_>, &mut [f64]) + Sync,
    ) -> Vec<f64> {
        let size = self.rays.len().div_ceil(CHUNKS).max(CHUNK);
        let chunk = |(rays, passages): (&[RaySample], &[Passage])| {
            let mut sums = vec![0.0; count];
            for (sample, passages) in rays.iter().zip(passages.chunks(self.merits.len())) {
                let (from, frame) = self.displaced(sample, displacements);
                let reflection = Reflection::new(&from, &frame);
                add(&DisplacedRay { sample, passages, from, frame, reflection }, &mut sums);
            }
            sums
        };
        let chunks = self.rays.par_chunks(size).zip(self.passages.par_chunks(size * self.merits.len()));
        let chunks: Vec<Vec<f64>> = chunks.map(chunk).collect();
        let total = chunks.into_iter().reduce(|mut total, part| {
            total.iter_mut().zip(&part).for_each(|(total, part)| *total += part);
            total
        });
        total.unwrap_or_else(|| vec![0.0; count])
    }

    /// Number of rays.
    pub(super) fn len(&self) -> usize {
        self.rays.len()
    }

    /// Leaves the `count` finest levels of distributions out of the merits, as far as they are finer than those to begin with; returns the largest number.
    pub(super) fn skip_levels(&mut self, count: usize) -> usize {
        let mut largest = 0;
        for grid in self.merits.iter_mut().filter_map(|(merit, _)| merit.grid_mut()) {
            let refinements = grid.refinements();
            grid.skip(count.min(refinements));
            largest = largest.max(refinements);
        }
        largest
    }

    /// Finds anew, in the scene with these displacements, which rays pass and how much of them the mirrors reflect.
    ///
    /// # Errors
    /// [`OptimizeError::Scene`] if the displaced description is not a scene, [`OptimizeError::Textures`] if its pictures cannot be read.
    pub(super) fn refresh(
        &mut self,
        description: &Description,
        displacements: &[f64],
    ) -> Result<(), OptimizeError> {
        let scene = resolved(description, displacements, &self.budget)?;
        self.aim(&scene, displacements);
        scene.check_textures()?;
        Ok(())
    }

    fn aim(&mut self, scene: &Scene, displacements: &[f64]) {
        let passages = self.rays.par_iter().flat_map_iter(|ray| {
            let (from, frame) = self.displaced(ray, displacements);
            let reflected = reflectance(scene, &from, &frame);
            let reflection = Reflection::new(&from, &frame);
            self.merits.iter().map(move |(merit, _)| {
                let Some((reflectance, at)) = &reflected else { return Passage::default() };
                let ray = ray.reflected(&reflection, 1.0);
                let arrival = merit.receiver().and_then(|receiver| receiver.arrival(&ray));
                // Light that does not arrive yet may do so later.
                let is_blocked = arrival.is_some_and(|arrival| {
                    let length = arrival * ray.direction.length();
                    let path = at.spawn(ray.direction.normalize_or_zero());
                    scene.occluded(&path, length * (1.0 - AIM))
                });
                Passage { reflectance: *reflectance, is_blocked }
            })
        });
        self.passages = passages.collect();
    }

    /// Both ends of a ray.
    fn displaced(&self, ray: &RaySample, displacements: &[f64]) -> (EmittingPoint, LocalFrame) {
        let (mut from, mut frame) = (ray.from, ray.frame);
        let offset = |variable: usize| {
            let displacement = displacements.get(variable).copied().unwrap_or_default();
            displacement * self.directions.get(variable).copied().unwrap_or_default()
        };
        for term in self.terms.get(ray.terms.clone()).unwrap_or_default() {
            frame.add(term.position, term.tangents, offset(term.variable));
        }
        for &variable in self.light_variables.get(ray.light).map(Vec::as_slice).unwrap_or_default() {
            from.position += offset(variable);
        }
        (from, frame)
    }

    /// The merit at these displacements, with its gradient if that is asked for.
    pub(super) fn value(&self, displacements: &[f64], with_gradient: bool) -> DesignValue {
        let values = self.merit_values(displacements);
        let merit = values.iter().zip(&self.merits).map(|(value, (_, weight))| weight * value.value).sum();
        let gradient = if with_gradient { self.gradient(displacements, &values) } else { Vec::new() };
        DesignValue { merit, gradient, measures: values.into_iter().map(|value| value.measure).collect() }
    }

    fn merit_values(&self, displacements: &[f64]) -> Vec<MeritValue> {
        let count = self.merits.iter().map(|(merit, _)| merit.sums()).sum();
        let sums = self.summed(displacements, count, |ray, mut sums| {
            for ((merit, _), passage) in self.merits.iter().zip(ray.passages) {
                let Some((own, others)) = sums.split_at_mut_checked(merit.sums()) else { return };
                sums = others;
                let reflected = ray.reflected(passage);
                match (passage.reflectance > 0.0, passage.is_blocked) {
                    (false, _) => {}
                    (true, true) => merit.deposit_blocked(reflected.flux, own),
                    (true, false) => merit.deposit(&reflected, own),
                }
            }
        });
        let mut sums = sums.as_slice();
        let mut values = Vec::with_capacity(self.merits.len());
        for (merit, _) in &self.merits {
            let (own, others) = sums.split_at_checked(merit.sums()).unwrap_or_default();
            values.push(merit.value(own));
            sums = others;
        }
        values
    }

    fn gradient(&self, displacements: &[f64], values: &[MeritValue]) -> Vec<f64> {
        self.summed(displacements, self.directions.len(), |ray, gradient| {
            let mut by = ReflectionGradient::default();
            for (((merit, weight), value), passage) in self.merits.iter().zip(values).zip(ray.passages) {
                let scale = passage.reflectance * ray.sample.weight;
                if passage.reflectance > 0.0 && passage.is_blocked {
                    by.flux += *weight * scale * merit.blocked_slope(&value.slopes);
                } else if passage.reflectance > 0.0 {
                    let own = merit.ray_gradient(&ray.reflected(passage), scale, &value.slopes);
                    by.origin += *weight * own.origin;
                    by.direction += *weight * own.direction;
                    by.flux += *weight * own.flux;
                }
            }
            self.add_gradient(ray, &by, gradient);
        })
    }

    fn add_gradient(&self, ray: &DisplacedRay<'_>, by: &ReflectionGradient, gradient: &mut [f64]) {
        let source = ray.reflection.source_gradient(&ray.from, &ray.frame, by);
        let mut add = |variable: usize, vector: DVec3| {
            let direction = self.directions.get(variable).copied().unwrap_or_default();
            if let Some(slot) = gradient.get_mut(variable) {
                *slot += vector.dot(direction);
            }
        };
        for term in self.terms.get(ray.sample.terms.clone()).unwrap_or_default() {
            let [du, dv] = source.mirror.tangents;
            add(
                term.variable,
                term.position * source.mirror.position + term.tangents[0] * du + term.tangents[1] * dv,
            );
        }
        for &variable in self.light_variables.get(ray.sample.light).map(Vec::as_slice).unwrap_or_default() {
            add(variable, source.light);
        }
    }
}

impl DisplacedRay<'_> {
    fn reflected(&self, passage: &Passage) -> ReflectedRay {
        self.sample.reflected(&self.reflection, passage.reflectance)
    }
}

impl RaySample {
    fn reflected(&self, reflection: &Reflection, reflectance: f64) -> ReflectedRay {
        ReflectedRay {
            origin: reflection.origin,
            direction: reflection.direction,
            flux: reflection.flux * self.weight * reflectance,
            mirror: self.mirror,
        }
    }
}

fn resolved(
    description: &Description,
    displacements: &[f64],
    budget: &ResourceBudget,
) -> Result<Scene, OptimizeError> {
    // Each scene replaces the one before. The flag ends the search, which then still measures what it has found.
    let budget = budget.for_next_step().with_cancel(CancelFlag::default());
    let scene = Scene::resolve_with(description.displaced(displacements), &budget);
    scene.map(|(scene, _)| scene).map_err(|error| OptimizeError::Scene {
        displacements: displacements.to_vec(),
        error: Box::new(error),
    })
}

/// The reflectance of the point that a ray is aimed at, with the point; `None` if it does not arrive there.
fn reflectance(scene: &Scene, from: &EmittingPoint, mirror: &LocalFrame) -> Option<(f64, Interaction)> {
    let towards = mirror.position - from.position;
    let distance = towards.length();
    let direction = towards / distance;
    let ray = Ray::new(from.position + SHADOW_START * towards, direction);
    let hit = scene.intersect(&ray, distance * (1.0 + AIM))?;
    if (hit.t - distance).abs() > AIM * distance {
        return None;
    }
    let wavelengths = Wavelengths::default();
    let bsdf = hit.bsdf(scene, &wavelengths)?;
    let branches = bsdf.delta_branches(hit.frame().to_local(hit.wo), TransportMode::Importance);
    let mirrored = branches.into_iter().flatten().find(|branch| branch.lobe == Lobe::SPECULAR_REFLECTION)?;
    let reflectance = f64::from(mirrored.weight.luminance(&wavelengths));
    Some((reflectance, hit))
}
