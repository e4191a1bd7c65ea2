//! The task of an inverse design: numbers that may change, and targets.

use std::collections::BTreeMap;

use glanz_math::DVec3;
use glanz_scene::Location;
use glanz_scene::description::{
    FileId, GeometryDescription, TargetDescription, TargetKind, VariableDescription, VariableNumbers,
    VariableQuantity,
};

use super::{EntityState, Lowering};
use crate::pbrt::parameters::{Parameter, ParameterList, ParameterType, Values, shortened};
use crate::source::{ParseResult, ReportedError, Span};

/// Names of the numbers of a shape that may be free.
const QUANTITIES: &str = "free numbers are P (or Pw), offset and radius";

/// The part of the parameters of a shape that belongs to an inverse design.
#[derive(Debug, Default)]
pub(super) struct ShapeDesign {
    /// `offset`: how far the shape is moved in its own frame.
    pub(super) offset: DVec3,
    free: Option<FreeNumbers>,
    target: Option<(Span, TargetDescription)>,
    subject: String,
}

/// `free` and what belongs to it.
#[derive(Debug)]
struct FreeNumbers {
    /// Name of the list.
    name: String,
    place: Span,
    /// Place of its first number.
    first: Location,
    /// Number of its numbers.
    count: usize,
    /// Of patches that share the points of the list: the number of each of their points in it.
    indices: Option<Vec<usize>>,
    /// Unit vectors.
    directions: Vec<DVec3>,
    range: [f64; 2],
    groups: Option<(Parameter, Vec<i32>)>,
}

impl Lowering {
    /// Takes the parameters of an inverse design from those of a shape, before the numbers themselves are taken.
    pub(super) fn design_of_shape(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<ShapeDesign> {
        let free = self.free_numbers(list)?;
        let indices =
            list.get("indices").filter(|_| kind == "patchmesh" && free.is_some()).map(point_numbers);
        let free = free.map(|free| FreeNumbers { indices, ..free });
        let target = self.target_of_shape(list, context)?;
        let offset = list.vec3("offset", &mut self.reporter)?.unwrap_or(DVec3::ZERO);
        let subject = list.subject.clone();
        Ok(ShapeDesign { offset, free, target, subject })
    }

    /// Refuses free numbers that stay in the list of a shape after its surface was read.
    pub(super) fn check_free(&mut self, design: &ShapeDesign, list: &ParameterList) -> ParseResult<()> {
        match &design.free {
            Some(free) if can_be_free(&free.name) && list.has(&free.name) => {
                let help = "this shape does not use these numbers, or they are given twice";
                Err(self.not_free(free, &design.subject, help))
            }
            _ => Ok(()),
        }
    }

    /// Adds the design of a shape that is about to be added to the current group.
    pub(super) fn add_design(
        &mut self,
        design: ShapeDesign,
        surfaces: &[GeometryDescription],
    ) -> ParseResult<()> {
        let ShapeDesign { free, target, subject, .. } = design;
        let place = match (&free, &target) {
            (Some(free), _) => free.place,
            (None, Some((place, _))) => *place,
            (None, None) => return Ok(()),
        };
        let ([geometry], None) = (surfaces, &self.object) else {
            let message =
                format!("{subject}: \"free\" and \"target\" belong to a single surface of the world");
            let help = Some(
                "move the shape out of ObjectBegin and ObjectEnd, and give one shape per surface".into(),
            );
            return Err(self.reporter.error_with_help(&place, "design", message, help));
        };
        let shape = self.description.world.shapes.len();
        self.description
            .design
            .targets
            .extend(target.map(|(_, target)| TargetDescription { shape, ..target }));
        if let Some(free) = free {
            let variables = self.variables(free, shape, geometry, &subject)?;
            self.description.design.variables.extend(variables);
        }
        Ok(())
    }

    /// The variables of the position of a point light.
    pub(super) fn free_position(
        &mut self,
        list: &mut ParameterList,
        kind: &str,
    ) -> ParseResult<Vec<VariableDescription>> {
        let Some(free) = self.free_numbers(list)? else { return Ok(Vec::new()) };
        if kind != "point" || free.name != "from" {
            return Err(self.not_free(
                &free,
                &list.subject,
                "of lights, only \"from\" of a \"point\" can be free",
            ));
        }
        let quantity = VariableQuantity::LightPosition { light: self.description.lights.len() };
        Ok(free.along_directions(&quantity, &[(0, 1.0)]))
    }

    fn free_numbers(&mut self, list: &mut ParameterList) -> ParseResult<Option<FreeNumbers>> {
        let Some((p, name)) = list.text_parameter("free", &mut self.reporter)? else { return Ok(None) };
        let place = p.value_place;
        let Some(numbers) = list.get(&name) else {
            let message = format!("{}: {:?} is free, but not given", list.subject, shortened(&name));
            let help = match name.as_str() {
                "offset" => "add \"vector3 offset\" [0 0 0]",
                _ => "write its numbers into the same shape; only written numbers can be replaced",
            };
            return Err(self.reporter.error_with_help(&place, "design", message, Some(help.to_owned())));
        };
        let (first, count) = (numbers.value_place.location, numbers.values.len());
        // Other names are refused whatever their numbers are.
        if can_be_free(&name) {
            self.check_free_numbers(list, numbers, &place)?;
        }
        let directions = self.free_directions(list)?;
        let range_place = list.value_place("freerange");
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        let range = list.float_array("freerange", &mut self.reporter)?.unwrap_or(all);
        if !(range[0] <= 0.0 && range[1] >= 0.0 && range[0] < range[1]) {
            let message = format!("{}: \"freerange\" is {} to {}", list.subject, range[0], range[1]);
            let help = Some(
                "displacements begin with 0: the first number must not be above it, the second not below"
                    .to_owned(),
            );
            return Err(self.reporter.error_with_help(&range_place, "parameter-range", message, help));
        }
        let groups = list.integers("freegroups", &mut self.reporter)?;
        Ok(Some(FreeNumbers { name, place, first, count, indices: None, directions, range, groups }))
    }

    /// Refuses numbers that cannot be replaced where they stand, or not by fractions. `place`: that of `free`.
    fn check_free_numbers(
        &mut self,
        list: &ParameterList,
        numbers: &Parameter,
        place: &Span,
    ) -> ParseResult<()> {
        let (declaration, name) = (numbers.place, numbers.name.as_str());
        if declaration.location.file != list.place.location.file || declaration.offset < list.place.offset {
            let message = format!("{}: the free {name:?} stands in an Attribute", list.subject);
            let help = "write it into the shape or light itself: the numbers of an Attribute are those of all that follows it";
            let help = Some(help.to_owned());
            return Err(self.reporter.error_with_help(&declaration, "design", message, help));
        }
        if numbers.value_place.location.file != FileId(0) {
            let message = format!("{}: free numbers stand in an included file", list.subject);
            let help = Some("move the shape into the scene file itself, which is written anew".to_owned());
            return Err(self.reporter.error_with_help(place, "design", message, help));
        }
        if numbers.kind == ParameterType::Integer {
            let message = format!("{}: {name:?} is free, but of type integer", list.subject);
            let kind = match name {
                "P" | "from" => "point3",
                "offset" => "vector3",
                _ => "float",
            };
            let help = Some(format!("write it as \"{kind} {name}\", which may have fractions"));
            return Err(self.reporter.error_with_help(&declaration, "parameter-type", message, help));
        }
        Ok(())
    }

    /// The unit vectors along which numbers are free.
    fn free_directions(&mut self, list: &mut ParameterList) -> ParseResult<Vec<DVec3>> {
        let Some((p, vectors)) = list.vec3s("freedirection", &mut self.reporter)? else {
            return Ok(vec![DVec3::Z]);
        };
        if vectors.len() > 3 {
            let message = format!(
                "{}: \"freedirection\" has {} vectors; 1 to 3 are needed",
                list.subject,
                vectors.len()
            );
            return Err(self.reporter.error(&p.value_place, "parameter-count", message));
        }
        let units: Option<Vec<DVec3>> = vectors.iter().map(|vector| vector.try_normalize()).collect();
        let units = units.filter(|units| !units.is_empty()).ok_or_else(|| {
            let message = format!("{}: \"freedirection\" needs vectors that are not zero", list.subject);
            self.reporter.error(&p.value_place, "parameter-range", message)
        })?;
        // Unit vectors are rounded.
        let is_same = |a: &DVec3, b: &DVec3| a.cross(*b).length() < 8.0 * f64::EPSILON;
        if (1..).zip(&units).any(|(next, a)| units.iter().skip(next).any(|b| is_same(a, b))) {
            let message =
                format!("{}: \"freedirection\" has the same or opposite direction twice", list.subject);
            let help = Some("each moves the numbers by itself; leave out one of them".to_owned());
            return Err(self.reporter.error_with_help(&p.value_place, "parameter-range", message, help));
        }
        Ok(units)
    }

    fn not_free(&mut self, free: &FreeNumbers, subject: &str, help: &str) -> ReportedError {
        let message = format!("{subject}: {:?} cannot be free", shortened(&free.name));
        self.reporter.error_with_help(&free.place, "design", message, Some(help.to_owned()))
    }

    fn variables(
        &mut self,
        free: FreeNumbers,
        shape: usize,
        geometry: &GeometryDescription,
        subject: &str,
    ) -> ParseResult<Vec<VariableDescription>> {
        if free.groups.is_some() && !matches!(free.name.as_str(), "P" | "Pw") {
            return Err(self.not_free(&free, subject, "\"freegroups\" are those of control points"));
        }
        match free.name.as_str() {
            "offset" => Ok(free.along_directions(&VariableQuantity::ShapeOffset { shape }, &[(0, 1.0)])),
            "radius" => {
                let quantity = VariableQuantity::Radius { shape };
                let mut variables = free.along_directions(&quantity, &[(0, 1.0)]);
                variables.truncate(1);
                variables.iter_mut().for_each(|variable| variable.direction = DVec3::ZERO);
                Ok(variables)
            }
            "P" | "Pw" => self.free_points(&free, shape, geometry, subject),
            _ => Err(self.not_free(&free, subject, QUANTITIES)),
        }
    }

    /// The variables of control points: one for each group of them and direction.
    fn free_points(
        &mut self,
        free: &FreeNumbers,
        shape: usize,
        geometry: &GeometryDescription,
        subject: &str,
    ) -> ParseResult<Vec<VariableDescription>> {
        let Some(points) = points_in_file(geometry) else {
            let help = "control points are those of nurbs, bezierpatch, beziertriangle and patchmesh";
            return Err(self.not_free(free, subject, help));
        };
        let is_weighted = free.name == "Pw";
        let count = free.count / if is_weighted { 4 } else { 3 };
        let groups: Vec<i32> = match &free.groups {
            None => (0..).take(count).collect(),
            Some((_, groups)) if groups.len() == count => groups.clone(),
            Some((p, groups)) => {
                let message = format!(
                    "{subject}: \"freegroups\" has {} numbers, there are {count} points",
                    groups.len()
                );
                let help =
                    Some("one per point in the order of the points; -1 for a point that stays".to_owned());
                return Err(self.reporter.error_with_help(&p.value_place, "parameter-count", message, help));
            }
        };
        // Of each group, its points in the list and the control points that these are.
        let mut members: BTreeMap<i32, [Vec<usize>; 2]> = BTreeMap::new();
        for (point, group) in groups.iter().enumerate().filter(|(_, group)| **group >= 0) {
            let [listed, _] = members.entry(*group).or_default();
            listed.push(point);
        }
        for (corner, (index, _)) in points.iter().enumerate() {
            if let Some(group) = groups.get(free.point(corner))
                && let Some([_, moved]) = members.get_mut(group)
            {
                moved.push(*index);
            }
        }
        let position = |point: usize| match points.get(point) {
            Some((_, weight)) if is_weighted => (4 * point, *weight),
            _ => (3 * point, 1.0),
        };
        let mut variables = Vec::new();
        // The list may have points that no patch has.
        for [listed, moved] in members.into_values().filter(|[_, moved]| !moved.is_empty()) {
            let positions: Vec<(usize, f64)> = listed.into_iter().map(position).collect();
            let quantity = VariableQuantity::ControlPoints { shape, points: moved };
            variables.extend(free.along_directions(&quantity, &positions));
        }
        Ok(variables)
    }

    fn target_of_shape(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<Option<(Span, TargetDescription)>> {
        let margin_place = list.value_place("targetmargin");
        let weight_place = list.value_place("targetweight");
        let Some((p, name)) = list.text_parameter("target", &mut self.reporter)? else { return Ok(None) };
        let margin = list.float_or("targetmargin", 0.0, &mut self.reporter)?;
        let weight = list.float_or("targetweight", 1.0, &mut self.reporter)?;
        for (name, value, place, fits) in [
            ("targetmargin", margin, margin_place, margin >= 0.0),
            ("targetweight", weight, weight_place, weight > 0.0),
        ] {
            if !fits {
                let message = format!("{}: {name:?} is {value}, it must be positive", list.subject);
                return Err(self.reporter.error(&place, "parameter-range", message));
            }
        }
        let kind = match name.as_str() {
            "even" => TargetKind::Even { margin },
            "values" => self.target_values(list)?,
            "peak" => TargetKind::Peak,
            "flux" => TargetKind::Flux,
            "collimation" => {
                let place = list.value_place("targetdirection");
                let direction = list.vec3("targetdirection", &mut self.reporter)?.unwrap_or(DVec3::Z);
                let direction = context.ctm.transform_vector3(direction).try_normalize();
                TargetKind::Collimation {
                    direction: direction.ok_or_else(|| {
                        let message = format!("{}: \"targetdirection\" must not be zero", list.subject);
                        self.reporter.error(&place, "parameter-range", message)
                    })?,
                }
            }
            other => {
                let message = format!("{}: target {:?} is unknown", list.subject, shortened(other));
                let help = Some("targets are even, values, peak, flux and collimation".to_owned());
                return Err(self.reporter.error_with_help(&p.value_place, "parameter-range", message, help));
            }
        };
        // The index is set when the shape is added.
        let location = Some(p.value_place.location);
        Ok(Some((p.value_place, TargetDescription { shape: 0, kind, weight, location })))
    }

    fn target_values(&mut self, list: &mut ParameterList) -> ParseResult<TargetKind> {
        let Some((_, [nx, ny])) = list.integer_array("targetcells", &mut self.reporter)? else {
            let message = format!("{}: target \"values\" has no \"integer targetcells\"", list.subject);
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let Some((p, values)) = list.floats("targetvalues", &mut self.reporter)? else {
            let message = format!("{}: target \"values\" has no \"float targetvalues\"", list.subject);
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let is_light = values.iter().all(|value| *value >= 0.0) && values.iter().sum::<f64>() > 0.0;
        let cells = [nx, ny].map(|n| u32::try_from(n).unwrap_or_default());
        let fits = cells.iter().map(|n| *n as usize).product::<usize>() == values.len();
        if !(is_light && fits) {
            let message = format!(
                "{}: \"targetvalues\" has {} numbers; {nx} times {ny} are needed, not negative and not all 0",
                list.subject,
                values.len()
            );
            return Err(self.reporter.error(&p.value_place, "parameter-count", message));
        }
        Ok(TargetKind::Values { cells, values })
    }
}

/// Whether numbers of this name are free in any shape or light.
fn can_be_free(name: &str) -> bool {
    matches!(name, "P" | "Pw" | "offset" | "radius" | "from")
}

impl FreeNumbers {
    /// The number in the list of a control point, by its number in the order of files over all patches.
    fn point(&self, corner: usize) -> usize {
        match &self.indices {
            Some(indices) => indices.get(corner).copied().unwrap_or(usize::MAX),
            None => corner,
        }
    }

    /// A variable for each direction.
    fn along_directions(
        &self,
        quantity: &VariableQuantity,
        positions: &[(usize, f64)],
    ) -> Vec<VariableDescription> {
        let variable = |&direction: &DVec3| VariableDescription {
            quantity: quantity.clone(),
            direction,
            range: self.range,
            numbers: Some(VariableNumbers { first: self.first, positions: positions.to_vec() }),
        };
        self.directions.iter().map(variable).collect()
    }
}

/// Numbers of points, of which reading the surface checks that they exist.
fn point_numbers(indices: &Parameter) -> Vec<usize> {
    match &indices.values {
        Values::Integers(numbers) => {
            numbers.iter().map(|n| usize::try_from(*n).unwrap_or(usize::MAX)).collect()
        }
        Values::Floats(numbers) => numbers.iter().map(|n| *n as usize).collect(),
        Values::Texts(_) | Values::Bools(_) => Vec::new(),
    }
}

/// The control points of a freeform surface in the order of files: their indices in the description and their weights.
fn points_in_file(geometry: &GeometryDescription) -> Option<Vec<(usize, f64)>> {
    // In files, u runs fastest.
    let grid = |points: &[[f64; 4]], count_v: usize, before: usize| {
        let count_u = points.len() / count_v.max(1);
        let indices = (0..count_v).flat_map(move |j| (0..count_u).map(move |i| i * count_v + j));
        let weighted = indices.filter_map(|index| Some((before + index, points.get(index)?[3])));
        weighted.collect::<Vec<_>>()
    };
    match geometry {
        GeometryDescription::Nurbs(nurbs) => {
            Some(grid(&nurbs.points, nurbs.knots_v.len().saturating_sub(nurbs.degree_v + 1), 0))
        }
        GeometryDescription::BezierPatches(patches) => {
            let count = (patches.degree_u + 1) * (patches.degree_v + 1);
            let numbered = patches.patches.iter().enumerate();
            Some(numbered.flat_map(|(n, patch)| grid(patch, patches.degree_v + 1, n * count)).collect())
        }
        GeometryDescription::BezierTriangles(triangles) => {
            let points = triangles.patches.iter().flatten().enumerate();
            Some(points.map(|(index, point)| (index, point[3])).collect())
        }
        _ => None,
    }
}
