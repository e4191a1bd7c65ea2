//! The patches of a surface: where they lie in its parameters, and their control points.

use glanz_math::DVec2;
use glanz_math::glam::DVec4;

use super::bicubic::{Bicubic, POWERS};
use super::bicubic_surface::{BicubicJet, BicubicTangents};
use super::control_net::{PatchJet, SecondOrderJet, second_order_jet};
use super::net_corrections::NetCorrections;
use super::subpatches::SubpatchList;
use super::surface_patch::PatchPlacement;
use super::{Freeform, SurfacePatch};
use crate::bezier::TensorPatch;

/// The patches of a surface.
#[derive(Debug)]
pub(super) enum PatchList {
    /// With their control nets.
    Nets(Vec<SurfacePatch>),
    /// With their control nets, and the same in coordinates of the surface: far from the origin of the common ones.
    Moved { patches: Vec<SurfacePatch>, own: Vec<SurfacePatch> },
    /// Polynomial ones of degrees up to (3, 3), by the powers that rays search: these are evaluated, and their control points restored
    /// on demand.
    Powers { placements: Vec<PatchPlacement>, corrections: NetCorrections },
}

/// The coefficients by which a patch is evaluated.
pub(super) enum PatchCoefficients<'a> {
    /// Homogeneous control points.
    Net { points: &'a [DVec4], degrees: (usize, usize) },
    /// Powers about the centre.
    Powers(&'a Bicubic<3>),
}

impl PatchList {
    fn len(&self) -> usize {
        match self {
            Self::Nets(patches) | Self::Moved { patches, .. } => patches.len(),
            Self::Powers { placements, .. } => placements.len(),
        }
    }

    /// The placement of a patch.
    #[inline]
    pub(super) fn placement(&self, face: u32) -> Option<&PatchPlacement> {
        match self {
            Self::Nets(patches) | Self::Moved { patches, .. } => {
                patches.get(face as usize).map(|patch| &patch.placement)
            }
            Self::Powers { placements, .. } => placements.get(face as usize),
        }
    }

    /// Bound on the rounding that evaluation by powers adds to that by control points, in units of the noise.
    pub(super) fn evaluation_rounding(&self) -> f64 {
        match self {
            Self::Nets(_) | Self::Moved { .. } => 0.0,
            Self::Powers { .. } => POWERS,
        }
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Nets(patches) => bytes(patches),
            Self::Moved { patches, own } => bytes(patches) + bytes(own),
            Self::Powers { placements, corrections } => {
                let boxed: usize = placements.iter().map(PatchPlacement::boxed_bytes).sum();
                size_of_val(&**placements) + boxed + corrections.bytes()
            }
        }
    }
}

/// Memory of patches, bytes.
fn bytes(patches: &[SurfacePatch]) -> usize {
    let own =
        patches.iter().map(|patch| size_of_val(patch.patch.control_points()) + patch.placement.boxed_bytes());
    size_of_val(patches) + own.sum::<usize>()
}

impl Freeform {
    /// Number of Bézier patches.
    #[must_use]
    pub fn patch_count(&self) -> usize {
        self.patches.len()
    }

    /// The Bézier patch of this number, that of `Hit::face`, with the control points that were given, bit by bit; `None` from
    /// [`Freeform::patch_count`] on. Where only powers are stored, its control points are computed by every call.
    #[must_use]
    pub fn patch(&self, face: u32) -> Option<SurfacePatch> {
        match (&*self.patches, &*self.subpatches) {
            (PatchList::Nets(patches) | PatchList::Moved { patches, .. }, _) => {
                patches.get(face as usize).cloned()
            }
            (PatchList::Powers { placements, corrections }, SubpatchList::Polynomial(powers)) => {
                let placement = placements.get(face as usize)?.clone();
                let (p, q) = placement.degrees();
                let mut net = powers.get(face as usize)?.control_points((p, q));
                corrections.correct(face as usize, &mut net)?;
                Some(SurfacePatch { patch: TensorPatch::try_new(p, q, net).ok()?, placement })
            }
            _ => None,
        }
    }

    /// The patch of this number in the surface's own coordinates.
    pub(super) fn own_patch(&self, face: u32) -> Option<SurfacePatch> {
        match &*self.patches {
            PatchList::Moved { own, .. } => own.get(face as usize).cloned(),
            _ => self.patch(face),
        }
    }

    /// All Bézier patches, in the order of `Hit::face`, each as by [`Freeform::patch`].
    pub fn patches(&self) -> impl Iterator<Item = SurfacePatch> + '_ {
        (0..self.patch_count() as u32).filter_map(|face| self.patch(face))
    }

    /// Degrees in u and v of a patch; `None` from [`Freeform::patch_count`] on.
    #[must_use]
    pub fn degrees(&self, face: u32) -> Option<(usize, usize)> {
        self.patches.placement(face).map(PatchPlacement::degrees)
    }

    /// Parameters (u, v) of the surface at (x, y) in the unit square of a patch; `None` from [`Freeform::patch_count`] on.
    #[must_use]
    pub fn parameters(&self, face: u32, x: f64, y: f64) -> Option<DVec2> {
        self.patches.placement(face).map(|placement| placement.parameters(x, y))
    }

    /// The coefficients of a patch, in the surface's own coordinates.
    #[inline]
    pub(super) fn coefficients(&self, face: u32) -> Option<PatchCoefficients<'_>> {
        match (&*self.patches, &*self.subpatches) {
            (PatchList::Nets(patches) | PatchList::Moved { own: patches, .. }, _) => {
                let patch = &patches.get(face as usize)?.patch;
                Some(PatchCoefficients::Net { points: patch.control_points(), degrees: patch.degrees() })
            }
            (PatchList::Powers { .. }, SubpatchList::Polynomial(powers)) => {
                powers.get(face as usize).map(PatchCoefficients::Powers)
            }
            _ => None,
        }
    }

    /// Point and first derivatives of a patch by its own parameters.
    #[inline]
    pub(super) fn first_order(&self, face: u32, x: f64, y: f64) -> Option<PatchJet> {
        let isa = self.bvh.isa();
        let jet = match self.coefficients(face)? {
            PatchCoefficients::Net { points, degrees } => PatchJet::new(isa, points, degrees, x, y),
            PatchCoefficients::Powers(patch) => isa.run(BicubicTangents { patch, x, y }),
        };
        Some(PatchJet { s: self.frame.in_common(jet.s), ..jet })
    }

    /// Point, first and second derivatives of a patch by its own parameters.
    pub(super) fn second_order(&self, face: u32, x: f64, y: f64) -> Option<SecondOrderJet> {
        let jet = match self.coefficients(face)? {
            PatchCoefficients::Net { points, degrees } => second_order_jet(points, degrees, x, y),
            PatchCoefficients::Powers(patch) => self.bvh.isa().run(BicubicJet { patch, x, y }),
        };
        Some(SecondOrderJet { s: self.frame.in_common(jet.s), ..jet })
    }
}
