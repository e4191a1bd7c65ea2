//! The walls of a room as receivers.

use glanz_math::DVec3;
use glanz_scene::Description;
use glanz_scene::description::{MaterialKind, ShapeDescription};

/// Adds the walls of a box from the origin to `size`, metres, to the shapes of the world.
///
/// They face inwards, absorb all light, and are receivers with the names "floor", "ceiling", "wall x=0" and so on.
pub fn add_walls(description: &mut Description, size: DVec3) {
    let material = description.materials.len();
    description.materials.push(MaterialKind::diffuse(0.0).into());
    let shape = |(name, corner, u, v)| ShapeDescription {
        material,
        ..ShapeDescription::parallelogram(corner, u, v).receiver(name)
    };
    description.world.shapes.extend(walls(size).map(shape));
}

/// Name, corner and sides of each wall of a box; their cross product points inwards.
pub(crate) fn walls(size: DVec3) -> [(String, DVec3, DVec3, DVec3); 6] {
    let [x, y, z] = [DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z];
    let o = DVec3::ZERO;
    [
        ("floor".to_owned(), o, x, y),
        ("ceiling".to_owned(), z, y, x),
        ("wall x=0".to_owned(), o, y, z),
        (format!("wall x={}", size.x), x, z, y),
        ("wall y=0".to_owned(), o, z, x),
        (format!("wall y={}", size.y), y, x, z),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_face_the_room() {
        let size = DVec3::new(2.0, 3.0, 4.0);
        let middle = 0.5 * size;
        for (name, corner, u, v) in walls(size) {
            let towards = middle - (corner + 0.5 * (u + v));
            assert!(u.cross(v).dot(towards) > 0.0, "{name}");
            assert!((u.cross(v).normalize().dot(towards) / towards.length() - 1.0).abs() < 1e-15, "{name}");
        }
    }
}
