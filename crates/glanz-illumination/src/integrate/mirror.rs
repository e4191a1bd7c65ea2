//! Faces that reflect specularly.

use glanz_geometry::{FaceDomain, Surface};
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, Transform};
use glanz_scene::{PlacedPoint, PlacedSurface, Scene};
use glanz_shading::Material;
use glanz_shading::bsdf::{Lobe, TransportMode};

/// A face, or a triangle of one whose parameters are a polygon, over the unit square.
#[derive(Clone, Copy, Debug)]
pub(super) struct MirrorFace {
    surface: u32,
    face: u32,
    /// Corners of the triangle; one side of the square maps to the first.
    triangle: Option<[DVec2; 3]>,
}

/// The reflecting faces.
#[derive(Debug)]
pub(super) struct Mirrors<'a> {
    scene: &'a Scene,
    wavelengths: Wavelengths,
    surfaces: Vec<(PlacedSurface<'a>, Transform)>,
    faces: Vec<MirrorFace>,
}

impl<'a> Mirrors<'a> {
    pub(super) fn of(scene: &'a Scene) -> Self {
        let surfaces: Vec<(PlacedSurface<'a>, Transform)> = scene
            .placed_surfaces()
            .into_iter()
            .map(|placed| {
                let map = placed.to_world();
                (placed, map)
            })
            .collect();
        let mut faces = Vec::new();
        for (number, (placed, _)) in (0..).zip(&surfaces) {
            for face in (0..placed.faces()).filter(|&face| reflects(scene, placed, face)) {
                faces.extend(parts(number, face, &placed.face_domain(face)));
            }
        }
        Self { scene, wavelengths: Wavelengths::default(), surfaces, faces }
    }

    /// Whether all mirrors are flat.
    pub(super) fn are_flat(&self) -> bool {
        let is_flat = |face: &MirrorFace| {
            let surface = self.surfaces.get(face.surface as usize).map(|(placed, _)| placed.surface());
            match surface {
                Some(Surface::Bilinear(patch)) => patch.is_parallelogram(),
                Some(surface) => {
                    matches!(surface, Surface::Plane(_) | Surface::Disk(_) | Surface::Triangle(_))
                }
                None => false,
            }
        };
        self.faces.iter().all(is_flat)
    }

    /// No mirrors.
    pub(super) fn none(&self) -> Self {
        let Self { scene, wavelengths, .. } = *self;
        Self { scene, wavelengths, surfaces: Vec::new(), faces: Vec::new() }
    }

    /// Whether a face is a mirror.
    pub(super) fn contains(&self, surface: u32, face: u32) -> bool {
        let placed = self.surfaces.get(surface as usize);
        placed.is_some_and(|(placed, _)| face < placed.faces() && reflects(self.scene, placed, face))
    }

    pub(super) fn faces(&self) -> &[MirrorFace] {
        &self.faces
    }

    pub(super) fn surface(&self, face: &MirrorFace) -> Option<(&PlacedSurface<'a>, &Transform)> {
        self.surfaces.get(face.surface as usize).map(|(placed, map)| (placed, map))
    }

    /// Position and unit normal at a point of the unit square, regardless of trimming.
    pub(super) fn place(&self, face: &MirrorFace, at: DVec2) -> Option<(DVec3, DVec3)> {
        let (placed, map) = self.surface(face)?;
        let point = placed.surface().untrimmed_at(face.face, face.uv(at).0)?;
        Some((map.point(point.position), map.normal(point.shading_normal).try_normalize()?))
    }

    /// The surface point with all its data, and the area per unit of the square; `None` where it is trimmed away.
    pub(super) fn point(&self, face: &MirrorFace, at: DVec2) -> Option<PlacedPoint> {
        let (placed, _) = self.surface(face)?;
        let (uv, scale) = face.uv(at);
        let mut point = placed.at(face.face, uv, false)?;
        point.area_element *= scale;
        Some(point)
    }

    /// Specular reflectance towards `direction`.
    pub(super) fn reflectance(&self, point: &PlacedPoint, direction: DVec3) -> Option<Spectrum> {
        let bsdf = point.at.bsdf(self.scene, &self.wavelengths)?;
        let wo = point.at.frame().to_local(direction);
        let branches = bsdf.delta_branches(wo, TransportMode::Radiance);
        let mirrored = branches.into_iter().flatten().find(|branch| branch.lobe == Lobe::SPECULAR_REFLECTION);
        mirrored.map(|branch| branch.weight)
    }
}

impl MirrorFace {
    pub(super) fn number(&self) -> u32 {
        self.face
    }

    /// Whether points of the unit square are the parameters themselves.
    pub(super) fn is_square(&self) -> bool {
        self.triangle.is_none()
    }

    /// Parameters at a point of the unit square, and the area of parameters per unit of the square.
    fn uv(&self, at: DVec2) -> (DVec2, f64) {
        match self.triangle {
            None => (at, 1.0),
            Some([a, b, c]) => {
                let uv = a + at.x * (b - a).lerp(c - a, at.y);
                (uv, at.x * (b - a).perp_dot(c - a).abs())
            }
        }
    }
}

/// Whether a face reflects specularly, and in no other way.
fn reflects(scene: &Scene, placed: &PlacedSurface<'_>, face: u32) -> bool {
    let material = placed.material(face);
    !scene.has_surface_detail(material)
        && scene.materials().get(material as usize).is_some_and(Material::is_specular)
}

fn parts(surface: u32, face: u32, domain: &FaceDomain) -> Vec<MirrorFace> {
    match domain {
        FaceDomain::Square => vec![MirrorFace { surface, face, triangle: None }],
        FaceDomain::Polygon(corners) => corners
            .windows(2)
            .skip(1)
            .filter_map(|pair| match (corners.first(), pair) {
                (Some(&a), &[b, c]) => Some(MirrorFace { surface, face, triangle: Some([a, b, c]) }),
                _ => None,
            })
            .collect(),
    }
}
