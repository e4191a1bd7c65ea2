//! Transformations, colours and layers of directory entries.

use glanz_brep::model::ColorStyle;
use glanz_math::{DMat4, DVec3};

use super::entity::IgesEntity;
use super::lowering::MAX_DEPTH;
use crate::cad::{Refusal, bounded};

/// Colours by their numbers from 1.
const NUMBERED_COLORS: [[f64; 3]; 8] = [
    [0.0; 3],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0; 3],
];

/// Difference from a right angle and from length 1 up to which a matrix is a rotation: files write four digits or more.
const RIGID: f64 = 1e-3;

impl IgesEntity<'_> {
    /// Its transformation, in units of the file.
    ///
    /// # Errors
    /// What is wrong with its matrix.
    pub(super) fn matrix(&self) -> Result<DMat4, Refusal> {
        self.transformation(self.entry.matrix)
    }

    /// A transformation to which it refers, in units of the file; `pointer`: the number of its directory entry, 0 for none.
    ///
    /// # Errors
    /// What is wrong with the matrix.
    pub(super) fn transformation(&self, mut pointer: i64) -> Result<DMat4, Refusal> {
        let mut matrix = DMat4::IDENTITY;
        for _ in 0..MAX_DEPTH {
            if pointer == 0 {
                return bounded(self.id(), matrix);
            }
            let number = u32::try_from(pointer.unsigned_abs()).ok();
            let entity = number.and_then(|number| self.file.entity(number));
            let entity = entity.filter(|entity| entity.kind() == 124).ok_or_else(|| {
                self.refuse(format!("its transformation, directory entry {pointer}, is missing"))
            })?;
            let r: [f64; 12] = entity.numbers(1)?;
            let columns = [0, 1, 2, 3].map(|j| DVec3::new(r[j], r[4 + j], r[8 + j]));
            let [x, y, z, t] = columns;
            matrix = DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), t.extend(1.0)) * matrix;
            pointer = entity.entry.matrix;
        }
        Err(self.refuse("transformations refer to one another"))
    }

    /// Its colour.
    pub(super) fn color(&self) -> Option<ColorStyle> {
        let opaque = |rgb| ColorStyle { rgb, transparency: 0.0 };
        let color = self.entry.color;
        if color >= 0 {
            let index = usize::try_from(color).ok()?.checked_sub(1)?;
            return NUMBERED_COLORS.get(index).copied().map(opaque);
        }
        let definition = self.file.entity(u32::try_from(color.unsigned_abs()).ok()?)?;
        if definition.kind() != 314 {
            return None;
        }
        let percent: [f64; 3] = definition.numbers(1).ok()?;
        Some(opaque(percent.map(|value| (0.01 * value).clamp(0.0, 1.0))))
    }

    /// Its level, where it has one.
    pub(super) fn layer(&self) -> String {
        if self.entry.level > 0 { self.entry.level.to_string() } else { String::new() }
    }
}

/// Whether a matrix keeps lengths.
pub(super) fn is_rigid(matrix: &DMat4) -> bool {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|column| column.truncate());
    let faults = [x.dot(y), y.dot(z), z.dot(x), x.length() - 1.0, y.length() - 1.0, z.length() - 1.0];
    matrix.is_finite() && faults.iter().all(|fault| fault.abs() <= RIGID)
}
