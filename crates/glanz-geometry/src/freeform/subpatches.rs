//! What leaves are parts of, as rays need it: patches, cut where their weights differ much.

use glanz_math::glam::DVec4;

use super::bicubic::Bicubic;
use super::draft::bends_along_u;
use super::leaf::{Leaf, Look};
use super::net;
use super::part::Part;
use super::piece::Piece;
use super::search::{self, Net, OnRoot, Probe, Scratch};
use crate::bvh::simd::Simd;

/// Patches are cut until the ratio of their weights is this or less. The rounding of powers is that of the largest
/// weight, and counts by the smallest; and next to a small weight a bit of a parameter is far on the surface.
const EVEN_WEIGHTS: f64 = 4.0;

/// A patch, or a part of it.
#[derive(Debug)]
pub(super) struct Subpatch {
    pub(super) place: Place,
    pub(super) degrees: (usize, usize),
    /// Homogeneous coefficients.
    pub(super) net: Vec<DVec4>,
}

/// Which part of which piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) piece: u32,
    pub(super) part: Part,
}

/// All of them of one kind, so that the search branches once per ray.
#[derive(Debug)]
pub(super) enum Forms {
    /// Degrees up to (3, 3), all weights equal within each patch.
    Polynomial(Vec<Bicubic<3>>),
    /// Degrees up to (3, 3), weights that vary little.
    Rational(Vec<Bicubic<4>>),
    /// Any degrees and weights.
    General(Vec<Subpatch>),
}

/// A subpatch whose leaves can be asked for roots.
pub(super) trait Form {
    /// Reports every root of the leaf, in no order and in the parameters of the subpatch.
    fn roots<S: Simd>(
        &self,
        simd: S,
        leaf: &Leaf,
        look: &Look,
        probe: &Probe,
        scratch: &mut Scratch,
        report: &mut impl OnRoot,
    );
}

/// The subpatches of `pieces`, none halved more often than `most_halvings`.
pub(super) fn cut(pieces: &[Piece], most_halvings: usize) -> Vec<Subpatch> {
    let mut done = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        let mut open = vec![Subpatch::whole(index as u32, piece)];
        while let Some(subpatch) = open.pop() {
            if subpatch.weight_ratio() <= EVEN_WEIGHTS || subpatch.place.part.count() == most_halvings {
                done.push(subpatch);
            } else {
                open.extend(subpatch.halves());
            }
        }
    }
    done
}

impl Subpatch {
    fn whole(piece: u32, from: &Piece) -> Self {
        let place = Place { piece, part: Part::WHOLE };
        Self { place, degrees: from.patch.degrees(), net: from.patch.control_points().to_vec() }
    }

    /// Whether all weights are 1.
    fn is_polynomial(&self) -> bool {
        self.net.iter().all(|p| p.w == 1.0)
    }

    /// The largest weight over the smallest.
    fn weight_ratio(&self) -> f64 {
        let weights = || self.net.iter().map(|p| p.w);
        weights().fold(0.0, f64::max) / weights().fold(f64::INFINITY, f64::min)
    }

    /// Whether it can be stored by powers.
    fn is_simple(&self) -> bool {
        self.degrees.0.max(self.degrees.1) <= 3 && self.weight_ratio() <= EVEN_WEIGHTS
    }

    fn halves(&self) -> [Self; 2] {
        let Self { place: Place { piece, part }, degrees, ref net } = *self;
        let across_u = bends_along_u(net, degrees);
        let [low, high] = part.halves(across_u);
        let [below, above] = net::split(net, degrees, across_u);
        [(low, below), (high, above)].map(|(part, net)| Self { place: Place { piece, part }, degrees, net })
    }
}

impl Forms {
    pub(super) fn new(subpatches: Vec<Subpatch>) -> Self {
        let all = |is: fn(&Subpatch) -> bool| subpatches.iter().all(is);
        if !all(Subpatch::is_simple) {
            Self::General(subpatches)
        } else if all(Subpatch::is_polynomial) {
            Self::Polynomial(subpatches.iter().map(|s| Bicubic::new(&s.net, s.degrees)).collect())
        } else {
            Self::Rational(subpatches.iter().map(|s| Bicubic::new(&s.net, s.degrees)).collect())
        }
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Polynomial(list) => size_of_val(&**list),
            Self::Rational(list) => size_of_val(&**list),
            Self::General(list) => {
                size_of_val(&**list) + list.iter().map(|s| size_of_val(&*s.net)).sum::<usize>()
            }
        }
    }
}

impl Form for Subpatch {
    #[inline(always)]
    fn roots<S: Simd>(
        &self,
        simd: S,
        leaf: &Leaf,
        look: &Look,
        probe: &Probe,
        scratch: &mut Scratch,
        report: &mut impl OnRoot,
    ) {
        let net = Net { degrees: self.degrees, points: &self.net };
        search::roots(simd, net, leaf, look, probe, scratch, report);
    }
}
