//! Freeform surfaces.
//!
//! `cstype` and `deg` hold for what follows. `surf` and `curv2` begin an element, which `parm`, `trim` and `hole` complete and `end` makes. The first
//! parameter of a surface is u, and its points are listed with u advancing first.

use glanz_scene::description::{
    NurbsDescription, TrimCurveDescription, TrimDescription, TrimLoopDescription,
};

use super::error::{ObjError, ObjErrorKind};
use super::statement::{ObjWord, Statements};
use super::{ObjFile, ObjSurface, SkippedStatement};
use crate::source::shortened;

/// Largest degree.
const MAX_DEGREE: usize = 100;

/// The kinds of curves that are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum CurveKind {
    #[default]
    BSpline,
    Bezier,
}

/// An element between its first statement and `end`.
#[derive(Debug)]
enum ObjElement {
    /// A surface: the ranges of u and v, and its points.
    Surface { range: [[f64; 2]; 2], points: Vec<[f64; 4]>, loops: Vec<TrimLoopDescription> },
    /// A curve in the parameters of surfaces.
    Curve { points: Vec<[f64; 3]> },
    /// A curve in the parameters of surfaces that is not read.
    SkippedCurve,
    /// A surface or a curve in space that is not read.
    Skipped,
}

/// State of the freeform statements.
#[derive(Debug, Default)]
pub(super) struct FreeformState {
    kind: CurveKind,
    /// Whether `cstype` names a kind that is not read.
    unknown: bool,
    rational: bool,
    degrees: [Option<usize>; 2],
    parameters: [Vec<f64>; 2],
    /// Points with their weights.
    parameter_points: Vec<[f64; 3]>,
    /// `None`: a curve that could not be read.
    curves: Vec<Option<TrimCurveDescription>>,
    element: Option<ObjElement>,
    /// Points of curves that loops may still use.
    points_left: usize,
}

impl FreeformState {
    /// The state before the first statement of a file of so many bytes.
    ///
    /// A curve takes at least two of them per point, and is part of a loop or two: loops may use as many points as there are bytes.
    pub(super) fn new(bytes: usize) -> Self {
        Self { points_left: bytes, ..Self::default() }
    }

    /// How many points loops may still use.
    pub(super) fn points_left(&self) -> usize {
        self.points_left
    }

    /// Reads a statement; `false` if it is none of freeform geometry.
    pub(super) fn statement(
        &mut self,
        s: &Statements<'_>,
        positions: &[[f64; 4]],
        material: Option<usize>,
        file: &mut ObjFile,
    ) -> Result<bool, ObjError> {
        match s.keyword() {
            "vp" => {
                let [u, v, w] = s.numbers(1, 1.0)?;
                self.parameter_points.push([u, if s.values().len() > 1 { v } else { 0.0 }, w]);
            }
            "cstype" => self.curve_type(s)?,
            "deg" => self.degree(s)?,
            "surf" => self.surface(s, positions, file)?,
            "curv2" => {
                let words = s.at_least(2)?;
                let points = self.curve_points(s, words)?;
                let curve =
                    if self.unknown { ObjElement::SkippedCurve } else { ObjElement::Curve { points } };
                self.begin(curve);
            }
            "curv" => {
                self.skip(s, file, "curves in space are left out");
                self.begin(ObjElement::Skipped);
            }
            "parm" if self.element.is_some() => self.parameters(s)?,
            "trim" | "hole" if self.element.is_some() => self.trim(s, file)?,
            "scrv" | "sp" if self.element.is_some() => {}
            "end" => self.end(s, material, file)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn skip(&self, s: &Statements<'_>, file: &mut ObjFile, what: &str) {
        SkippedStatement::add(&mut file.skipped, s.place(), what.to_owned());
    }

    fn begin(&mut self, element: ObjElement) {
        self.element = Some(element);
        self.parameters = Default::default();
    }

    fn curve_type(&mut self, s: &Statements<'_>) -> Result<(), ObjError> {
        let words = s.at_least(1)?;
        self.rational = words.first().is_some_and(|word| word.text == "rat");
        let kind = words.get(usize::from(self.rational)).map_or("", |word| word.text);
        self.unknown = !matches!(kind, "bspline" | "bezier");
        self.kind = if kind == "bezier" { CurveKind::Bezier } else { CurveKind::BSpline };
        Ok(())
    }

    fn degree(&mut self, s: &Statements<'_>) -> Result<(), ObjError> {
        self.degrees = [None; 2];
        s.at_least(1)?;
        for (degree, word) in self.degrees.iter_mut().zip(s.values()) {
            let number = word.text.parse().ok().filter(|degree| (1..=MAX_DEGREE).contains(degree));
            let wrong = || s.error(Some(word), ObjErrorKind::Degree(shortened(word.text)));
            *degree = Some(number.ok_or_else(wrong)?);
        }
        Ok(())
    }

    fn surface(
        &mut self,
        s: &Statements<'_>,
        positions: &[[f64; 4]],
        file: &mut ObjFile,
    ) -> Result<(), ObjError> {
        if self.unknown {
            self.skip(s, file, "a surface that is neither \"bspline\" nor \"bezier\" is left out");
            self.begin(ObjElement::Skipped);
            return Ok(());
        }
        let words = s.at_least(5)?;
        let [u0, u1, v0, v1] = s.numbers(4, 0.0)?;
        let mut points = Vec::with_capacity(words.len());
        for word in words.iter().skip(4) {
            // Texture coordinates and normals of control points have no meaning here.
            let text = word.text.split('/').next().unwrap_or_default();
            let index = s.index(word, text, "vertex", positions.len())?;
            let [x, y, z, w] = positions.get(index).copied().unwrap_or_default();
            let w = if self.rational { w } else { 1.0 };
            points.push([w * x, w * y, w * z, w]);
        }
        self.begin(ObjElement::Surface { range: [[u0, u1], [v0, v1]], points, loops: Vec::new() });
        Ok(())
    }

    fn curve_points(&self, s: &Statements<'_>, words: &[ObjWord<'_>]) -> Result<Vec<[f64; 3]>, ObjError> {
        let point = |word: &ObjWord<'_>| {
            let index = s.index(word, word.text, "parameter vertex", self.parameter_points.len())?;
            let [u, v, w] = self.parameter_points.get(index).copied().unwrap_or_default();
            let w = if self.rational { w } else { 1.0 };
            Ok([w * u, w * v, w])
        };
        words.iter().map(point).collect()
    }

    fn parameters(&mut self, s: &Statements<'_>) -> Result<(), ObjError> {
        let words = s.at_least(2)?;
        let mut list: Vec<f64> = Vec::with_capacity(words.len());
        for word in words.iter().skip(1) {
            let after = s.number(word)?;
            if let Some(&before) = list.last().filter(|before| **before > after) {
                return Err(s.error(Some(word), ObjErrorKind::Decreasing { before, after }));
            }
            list.push(after);
        }
        let axis = usize::from(words.first().is_some_and(|word| word.text == "v"));
        self.parameters[axis] = list;
        Ok(())
    }

    /// A loop of parts of curves: triples of a range and the number of a curve.
    fn trim(&mut self, s: &Statements<'_>, file: &mut ObjFile) -> Result<(), ObjError> {
        let mut curves = Vec::new();
        let mut complete = true;
        for part in s.at_least(3)?.as_chunks::<3>().0 {
            let [from, to, number] = part;
            let (from, to) = (s.number(from)?, s.number(to)?);
            let index = s.index(number, number.text, "curve", self.curves.len())?;
            match self.curves.get(index).and_then(Option::as_ref) {
                Some(curve) if ends(curve) == Some([from, to]) => {
                    let left = self.points_left.checked_sub(curve.points.len());
                    self.points_left = left.ok_or_else(|| s.error(Some(number), ObjErrorKind::CurveUses))?;
                    curves.push(curve.clone());
                }
                _ => complete = false,
            }
        }
        if !complete {
            self.skip(s, file, "a loop with a part of a curve, or with one that is not read, is left out");
        } else if let Some(ObjElement::Surface { loops, .. }) = &mut self.element {
            loops.push(TrimLoopDescription { curves });
        }
        Ok(())
    }

    fn end(
        &mut self,
        s: &Statements<'_>,
        material: Option<usize>,
        file: &mut ObjFile,
    ) -> Result<(), ObjError> {
        match self.element.take() {
            Some(ObjElement::Surface { range, points, loops }) => {
                let surface = self.finished_surface(s, range, points)?;
                let trim = (!loops.is_empty()).then(|| TrimDescription::from(loops));
                file.surfaces.push(ObjSurface { material, surface, trim });
            }
            Some(ObjElement::Curve { points }) => {
                let (degree, count) = self.axis(s, 0)?;
                let curve = (count == points.len()).then(|| {
                    let knots = self.knots(0, degree);
                    TrimCurveDescription { degree, knots, points, width: None, edge: None }
                });
                if curve.is_none() {
                    self.skip(s, file, "a curve whose points do not match its parameters is left out");
                }
                self.curves.push(curve);
            }
            Some(ObjElement::SkippedCurve) => self.curves.push(None),
            Some(ObjElement::Skipped) | None => {}
        }
        Ok(())
    }

    fn finished_surface(
        &self,
        s: &Statements<'_>,
        range: [[f64; 2]; 2],
        points: Vec<[f64; 4]>,
    ) -> Result<NurbsDescription, ObjError> {
        let (degree_u, count_u) = self.axis(s, 0)?;
        let (degree_v, count_v) = self.axis(s, 1)?;
        if points.len() != count_u.saturating_mul(count_v) {
            let kind = ObjErrorKind::SurfacePoints { found: points.len(), u: count_u, v: count_v };
            return Err(s.error(None, kind));
        }
        let [knots_u, knots_v] = [self.knots(0, degree_u), self.knots(1, degree_v)];
        let whole = [[knots_u[degree_u], knots_u[count_u]], [knots_v[degree_v], knots_v[count_v]]];
        for ([low, high], [start, end]) in whole.into_iter().zip(range) {
            if !(low <= start && start < end && end <= high) {
                return Err(s.error(None, ObjErrorKind::Range(start, end)));
            }
        }
        // From u advancing first to v advancing first.
        let transposed = (0..count_u).flat_map(|i| (0..count_v).map(move |j| j * count_u + i));
        let points = transposed.filter_map(|index| points.get(index).copied()).collect();
        let domain = (whole != range).then_some(range);
        Ok(NurbsDescription { degree_u, degree_v, knots_u, knots_v, points, domain })
    }

    /// Degree and number of points along u or v.
    fn axis(&self, s: &Statements<'_>, axis: usize) -> Result<(usize, usize), ObjError> {
        let degree = self.degrees[axis].or(self.degrees[0]).unwrap_or(3);
        let found = self.parameters[axis].len();
        let count = match self.kind {
            CurveKind::BSpline => found.checked_sub(degree + 1).filter(|&count| count > degree),
            CurveKind::Bezier => {
                found.checked_sub(1).filter(|&s| s > 0).map(|segments| degree * segments + 1)
            }
        };
        let too_few = || {
            let axis = if axis == 0 { 'u' } else { 'v' };
            s.error(None, ObjErrorKind::Parameters { axis, found, degree })
        };
        Ok((degree, count.ok_or_else(too_few)?))
    }

    /// Knots along u or v, `degree + 1` more than points. Made after the points are counted, since Bézier segments need many more than the file lists.
    fn knots(&self, axis: usize, degree: usize) -> Vec<f64> {
        let found = &self.parameters[axis];
        match self.kind {
            CurveKind::BSpline => found.clone(),
            CurveKind::Bezier => {
                // Ends of segments have as many knots as the degree, and one more at both ends of the curve.
                let segments = found.iter().flat_map(|&end| std::iter::repeat_n(end, degree));
                found.first().copied().into_iter().chain(segments).chain(found.last().copied()).collect()
            }
        }
    }
}

/// The ends of the parameters of a curve.
fn ends(curve: &TrimCurveDescription) -> Option<[f64; 2]> {
    Some([*curve.knots.get(curve.degree)?, *curve.knots.get(curve.points.len())?])
}
