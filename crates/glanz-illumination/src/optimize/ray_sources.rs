//! Lights and mirrors of a scene, where rays start and are reflected.

use glanz_geometry::FaceDomain;
use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::{DVec2, DVec3};
use glanz_scene::{Description, Light, LightId, PlacedSurface, Scene};

use super::error::OptimizeError;
use super::surface_basis::SurfaceBasis;

/// Where rays start.
pub(super) struct EmitterPart<'a> {
    pub(super) light: usize,
    /// cd, or cd/m^2.
    pub(super) brightness: f64,
    pub(super) surface: EmittingSurface<'a>,
}

pub(super) enum EmittingSurface<'a> {
    Point(DVec3),
    Area { placed: &'a PlacedSurface<'a>, face: u32, part: UnitPart, two_sided: bool },
}

/// Where rays are reflected.
pub(super) struct ReflectingPart<'a> {
    pub(super) shape: usize,
    pub(super) surface: MirrorSurface<'a>,
    pub(super) part: UnitPart,
}

pub(super) enum MirrorSurface<'a> {
    Freeform(SurfaceBasis),
    Fixed { placed: &'a PlacedSurface<'a>, face: u32 },
}

/// Parameters of a face by those of the unit square: themselves, or those of a triangle, to whose first corner a side of the square maps.
#[derive(Clone, Copy)]
pub(super) enum UnitPart {
    Square,
    Triangle([DVec2; 3]),
}

impl UnitPart {
    fn of(domain: &FaceDomain) -> Vec<Self> {
        match domain {
            FaceDomain::Square => vec![Self::Square],
            FaceDomain::Polygon(corners) => {
                let pairs = corners.windows(2).skip(1);
                let part =
                    |pair: &[DVec2]| Some(Self::Triangle([*corners.first()?, *pair.first()?, *pair.get(1)?]));
                pairs.filter_map(part).collect()
            }
        }
    }

    /// Parameters, and their area per unit of the square.
    pub(super) fn at(&self, at: DVec2) -> (DVec2, f64) {
        match *self {
            Self::Square => (at, 1.0),
            Self::Triangle([a, b, c]) => {
                (a + at.x * (b - a).lerp(c - a, at.y), at.x * (b - a).perp_dot(c - a).abs())
            }
        }
    }
}

/// Number of the first shape of the world among those of the scene.
pub(super) fn first_of_world(description: &Description) -> usize {
    let grouped: usize = description.groups.iter().map(|group| group.shapes.len()).sum();
    grouped + usize::from(description.section.is_some())
}

/// Index of the shape of a surface in the world; `None` for one in a group.
pub(super) fn world_shape(description: &Description, placed: &PlacedSurface<'_>, face: u32) -> Option<usize> {
    (placed.shape(face) as usize).checked_sub(first_of_world(description))
}

/// The parts of all lights, and their flux, lm.
pub(super) fn emitters<'a>(
    scene: &Scene,
    placed: &'a [PlacedSurface<'a>],
) -> Result<(Vec<EmitterPart<'a>>, f64), OptimizeError> {
    let wavelengths = Wavelengths::default();
    let (mut parts, mut emitted) = (Vec::new(), 0.0);
    for (number, light) in scene.lights().iter().enumerate() {
        let id = LightId(number as u32);
        let refused = |kind| OptimizeError::Light { light: id, kind };
        match light {
            Light::Area(area) if area.radiance().is_black() => {}
            Light::Area(area) if !area.is_opaque() => return Err(refused("diffuse with alpha")),
            Light::Area(area) if area.has_picture() => return Err(refused("diffuse with a picture")),
            Light::Area(area) => {
                emitted += photometric(area.power(), &wavelengths);
                let brightness = photometric(area.radiance(), &wavelengths);
                for placed in placed.iter().filter(|placed| placed.light() == Some(id)) {
                    for face in 0..placed.faces() {
                        for part in UnitPart::of(&placed.face_domain(face)) {
                            let two_sided = area.is_two_sided();
                            let surface = EmittingSurface::Area { placed, face, part, two_sided };
                            parts.push(EmitterPart { light: number, brightness, surface });
                        }
                    }
                }
            }
            Light::Point(point) if point.power().is_black() => {}
            Light::Point(point) if point.range().is_none() => {
                emitted += photometric(point.power(), &wavelengths);
                let brightness = photometric(point.intensity(), &wavelengths);
                let surface = EmittingSurface::Point(point.position());
                parts.push(EmitterPart { light: number, brightness, surface });
            }
            Light::Point(_) => return Err(refused("point with a range")),
            other => return Err(refused(other.kind())),
        }
    }
    if parts.is_empty() { Err(OptimizeError::NoLight) } else { Ok((parts, emitted)) }
}

/// The parts of all shapes of the world that reflect like mirrors.
pub(super) fn mirrors<'a>(
    description: &Description,
    scene: &Scene,
    placed: &'a [PlacedSurface<'a>],
) -> Vec<ReflectingPart<'a>> {
    let mut parts = Vec::new();
    let mut freeform = None;
    for surface in placed {
        for face in 0..surface.faces() {
            let Some(shape) = world_shape(description, surface, face) else { continue };
            if freeform == Some(shape) || !is_mirror(scene, surface, face) {
                continue;
            }
            let bases = description.world.shapes.get(shape).and_then(SurfaceBasis::of_shape);
            match bases {
                Some(bases) => {
                    // All faces at once.
                    freeform = Some(shape);
                    let triangle = UnitPart::Triangle([DVec2::ZERO, DVec2::X, DVec2::Y]);
                    parts.extend(bases.into_iter().map(|basis| ReflectingPart {
                        shape,
                        part: if basis.is_triangle() { triangle } else { UnitPart::Square },
                        surface: MirrorSurface::Freeform(basis),
                    }));
                }
                None => parts.extend(UnitPart::of(&surface.face_domain(face)).into_iter().map(|part| {
                    ReflectingPart { shape, surface: MirrorSurface::Fixed { placed: surface, face }, part }
                })),
            }
        }
    }
    parts
}

/// Whether a face reflects specularly, by its material in the middle of the face or, if that is trimmed away, at the first of some points.
fn is_mirror(scene: &Scene, surface: &PlacedSurface<'_>, face: u32) -> bool {
    let corners = surface.face_domain(face).corners();
    let middle = corners.iter().sum::<DVec2>() / corners.len().max(1) as f64;
    let grid = (0..1024_u32).map(|k| (DVec2::new(f64::from(k % 32), f64::from(k / 32)) + 0.5) / 32.0);
    let mut points = [middle].into_iter().chain(grid).filter_map(|uv| surface.at(face, uv, false));
    let bsdf = points.next().and_then(|point| point.at.bsdf(scene, &Wavelengths::default()));
    bsdf.is_some_and(|bsdf| bsdf.is_delta())
}
