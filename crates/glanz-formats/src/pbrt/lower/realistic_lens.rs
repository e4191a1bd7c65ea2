//! The lens of a realistic camera.

use glanz_scene::description::{LensDescription, LensInterfaceDescription, StopShape};

use super::Lowering;
use crate::file_list::FileKind;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::{MISSING_FILE, ParseResult};

/// Metres per unit of lens files.
const MILLIMETRE: f64 = 1e-3;

impl Lowering {
    /// The lens in the file `lensfile`, with its stop and focus.
    pub(super) fn realistic_lens(&mut self, list: &mut ParameterList) -> ParseResult<LensDescription> {
        let Some((p, name)) = list.text_parameter("lensfile", &mut self.reporter)? else {
            let message = "camera \"realistic\" has no \"string lensfile\"";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let numbers =
            self.read_file(&name, FileKind::Lens).map_err(|problem| (problem.to_string(), MISSING_FILE));
        let numbers = numbers.and_then(|(path, bytes)| {
            self.floats_of_file(&path, bytes).map_err(|problem| (problem, "lens-file"))
        });
        let rows = numbers.and_then(|numbers| {
            let (rows, rest) = numbers.as_chunks::<4>();
            if rest.is_empty() && !rows.is_empty() {
                return Ok(rows.to_vec());
            }
            let count = numbers.len();
            let what = format!(
                "file {name:?} has {count} numbers; it must have four for each interface: curvature radius, thickness, index, diameter"
            );
            Err((what, "lens-file"))
        });
        let rows = match rows {
            Ok(rows) => rows,
            Err((problem, kind)) => {
                let message = format!("camera \"realistic\": {problem}");
                return Err(self.reporter.error(&p.value_place, kind, message));
            }
        };
        let interface = |[radius, thickness, eta, diameter]: [f64; 4]| LensInterfaceDescription {
            curvature_radius: radius * MILLIMETRE,
            thickness: thickness * MILLIMETRE,
            eta,
            diameter: diameter * MILLIMETRE,
        };
        let stop = self.stop_shape(list)?;
        let relative = list.boolean("simpleweighting", &mut self.reporter)?;
        let r = &mut self.reporter;
        Ok(LensDescription {
            interfaces: rows.into_iter().map(interface).collect(),
            aperture_diameter: list.float_or("aperturediameter", 1.0, r)? * MILLIMETRE,
            focus_distance: list.float_or("focusdistance", 10.0, r)?,
            stop,
            relative_weights: relative.unwrap_or(self.dialect == Dialect::V3),
        })
    }

    /// `aperture`, or blades.
    fn stop_shape(&mut self, list: &mut ParameterList) -> ParseResult<StopShape> {
        let iris = StopShape::Iris(self.iris(list)?);
        let Some((p, name)) = list.text_parameter("aperture", &mut self.reporter)? else { return Ok(iris) };
        Ok(match name.as_str() {
            "" | "circular" => iris,
            "gaussian" => StopShape::Gaussian,
            "square" => StopShape::Square,
            "pentagon" => StopShape::Pentagon,
            "star" => StopShape::Star,
            other => {
                let message = format!(
                    "camera \"realistic\": the aperture {:?} is not available; a circular one stands in",
                    shortened(other)
                );
                self.stand_in(&p.value_place, "stand-in-camera", message);
                iris
            }
        })
    }
}
