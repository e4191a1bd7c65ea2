//! PLY: triangles with a colour each.

use std::io::Write;

use glanz_light::rgb::srgb_byte;

use super::{TessellatedError, TessellatedScene};

/// The bytes of a binary PLY file (little endian): positions in double precision, triangles with the colour of their material.
///
/// # Errors
/// [`TessellatedError`].
pub fn write_ply(scene: &TessellatedScene<'_>) -> Result<Vec<u8>, TessellatedError> {
    let placed = scene.placed()?;
    let [vertices, triangles] = scene.counts()?;
    if u32::try_from(vertices).is_err() {
        return Err(TessellatedError::Size);
    }
    let mut file = Vec::with_capacity(24 * vertices + 16 * triangles + 400);
    // Writing to a list cannot fail.
    let _ = write!(
        file,
        "ply\nformat binary_little_endian 1.0\ncomment Glanz {}, metres\nelement vertex {vertices}\n\
         property double x\nproperty double y\nproperty double z\nelement face {triangles}\n\
         property list uchar uint vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         end_header\n",
        env!("CARGO_PKG_VERSION"),
    );
    for group in &placed {
        let positions = group.mesh.positions.iter().map(|&point| group.position(point));
        file.extend(positions.flat_map(|point| point.to_array()).flat_map(f64::to_le_bytes));
    }
    let mut base = 0;
    for group in &placed {
        for (description, shape) in group.group.shapes.iter().zip(&group.mesh.shapes) {
            let color = scene.materials.get(description.material).map_or([1.0; 3], |material| material.base);
            for &corners in &shape.triangles {
                let position = |i: u32| shape.vertices.get(i as usize).map_or(0, |vertex| vertex.position);
                let corners = group.turned(corners).map(|i| base + position(i));
                file.push(3);
                file.extend(corners.into_iter().flat_map(u32::to_le_bytes));
                file.extend(color.map(srgb_byte));
            }
        }
        base += group.mesh.positions.len() as u32;
    }
    Ok(file)
}
