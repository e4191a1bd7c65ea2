//! Shapes in addition to those of pbrt; `docs/scene-format.md` describes them.

use glanz_math::DVec3;
use glanz_scene::description::GeometryDescription;

use super::Lowering;
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;

/// The largest total degree of an algebraic surface.
const MAX_DEGREE: i32 = 4;

impl Lowering {
    /// Lowers a shape in addition to those of pbrt.
    pub(super) fn extension(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
    ) -> ParseResult<GeometryDescription> {
        match kind {
            "twosheetedhyperboloid" => self.two_sheeted_hyperboloid(list),
            "plane" => self.plane(list),
            "torus" => Ok(GeometryDescription::Torus {
                major_radius: list.float_or("majorradius", 1.0, &mut self.reporter)?,
                minor_radius: list.float_or("minorradius", 0.25, &mut self.reporter)?,
                phi_max: self.phi_max(list)?,
            }),
            "polyhedron" => self.polyhedron(list),
            "box" => self.cuboid(list),
            _ => self.algebraic(list),
        }
    }

    fn two_sheeted_hyperboloid(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let a = list.float_or("a", 1.0, &mut self.reporter)?;
        let c = list.float_or("c", 1.0, &mut self.reporter)?;
        Ok(GeometryDescription::TwoSheetedHyperboloid {
            a,
            c,
            z: self.z_range(list, [-2.0 * c, 2.0 * c])?,
            phi_max: self.phi_max(list)?,
        })
    }

    fn plane(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let everything = [f64::NEG_INFINITY, f64::INFINITY];
        let x = list.float_array("x", &mut self.reporter)?.unwrap_or(everything);
        let y = list.float_array("y", &mut self.reporter)?.unwrap_or(everything);
        Ok(GeometryDescription::Plane { x, y })
    }

    fn polyhedron(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let normals = list.vec3s("N", &mut self.reporter)?;
        let offsets = list.floats("d", &mut self.reporter)?;
        let (Some((p, normals)), Some((_, offsets))) = (normals, offsets) else {
            let message = "shape \"polyhedron\" needs \"normal N\" and \"float d\"";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        if normals.len() != offsets.len() {
            let message = format!(
                "shape \"polyhedron\": there are {} normals \"N\" and {} offsets \"d\"",
                normals.len(),
                offsets.len()
            );
            return Err(self.reporter.error(&p.value_place, "parameter-count", message));
        }
        let half_spaces = normals.into_iter().zip(offsets).collect();
        Ok(GeometryDescription::Polyhedron { half_spaces })
    }

    /// A box by two corners, or by its size around the origin.
    fn cuboid(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let size_place = list.value_place("size");
        let size = list.vec3("size", &mut self.reporter)?;
        let a = list.vec3("min", &mut self.reporter)?;
        let b = list.vec3("max", &mut self.reporter)?;
        let (a, b) = match (size, a, b) {
            (Some(_), Some(_), _) | (Some(_), _, Some(_)) => {
                let message = "shape \"box\": give either \"size\" or \"min\" and \"max\"";
                return Err(self.reporter.error(&size_place, "parameter-count", message));
            }
            (Some(size), None, None) => (-0.5 * size, 0.5 * size),
            (None, a, b) => (a.unwrap_or(DVec3::splat(-0.5)), b.unwrap_or(DVec3::splat(0.5))),
        };
        Ok(GeometryDescription::Cuboid { min: a.min(b), max: a.max(b) })
    }

    fn algebraic(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let exponents = list.integers("exponents", &mut self.reporter)?;
        let coefficients = list.floats("coefficients", &mut self.reporter)?;
        let (Some((p, exponents)), Some((_, coefficients))) = (exponents, coefficients) else {
            let message = "shape \"algebraic\" needs \"integer exponents\" and \"float coefficients\"";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        if exponents.len() != 3 * coefficients.len() {
            let message = format!(
                "shape \"algebraic\": {} coefficients need {} exponents; there are {}",
                coefficients.len(),
                3 * coefficients.len(),
                exponents.len()
            );
            return Err(self.reporter.error(&p.value_place, "parameter-count", message));
        }
        let wrong = |e: &&[i32]| {
            let fits = e.iter().all(|x| (0..=MAX_DEGREE).contains(x));
            !fits || e.iter().sum::<i32>() > MAX_DEGREE
        };
        if let Some(e) = exponents.chunks_exact(3).find(wrong) {
            let message = format!(
                "shape \"algebraic\": the term with exponents {} {} {} is not of degree 0 to {MAX_DEGREE}",
                e[0], e[1], e[2]
            );
            return Err(self.reporter.error(&p.value_place, "parameter-range", message));
        }
        let exponents = exponents.chunks_exact(3).map(|e| std::array::from_fn(|i| e[i].unsigned_abs() as u8));
        let terms = exponents.zip(coefficients).collect();
        let clip_place = list.value_place("clip");
        let clip = match list.vec3s("clip", &mut self.reporter)? {
            None => [DVec3::splat(-1.0), DVec3::splat(1.0)],
            Some((_, corners)) => match corners[..] {
                [a, b] => [a.min(b), a.max(b)],
                _ => {
                    let message = format!(
                        "shape \"algebraic\": \"clip\" has {} points; 2 corners are needed",
                        corners.len()
                    );
                    return Err(self.reporter.error(&clip_place, "parameter-count", message));
                }
            },
        };
        Ok(GeometryDescription::Algebraic { terms, clip })
    }
}
