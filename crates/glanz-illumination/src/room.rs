//! The walls of a room as receivers.

use glanz_light::SpectralDistribution;
use glanz_math::{DMat4, DVec3};
use glanz_scene::Description;
use glanz_scene::description::{
    GeometryDescription, MaterialDescription, MaterialKind, ReceiverDescription, ReceiverSide,
    ShapeDescription, SpectrumInput,
};

/// Adds the walls of a box from the origin to `size`, metres, to the shapes of the world.
///
/// They face inwards, absorb everything, and are receivers: "floor", "ceiling", "wall x=0" and so on.
pub fn add_walls(description: &mut Description, size: DVec3) {
    let material = description.materials.len();
    let black = SpectrumInput::Value(SpectralDistribution::Constant(0.0));
    let kind = MaterialKind::diffuse(black);
    description.materials.push(MaterialDescription { name: String::new(), kind, location: None });
    for (name, corner, u, v) in walls(size) {
        description.world.shapes.push(ShapeDescription {
            geometry: GeometryDescription::Bilinear {
                positions: vec![corner, corner + u, corner + v, corner + u + v],
                indices: vec![[0, 1, 2, 3]],
            },
            to_parent: DMat4::IDENTITY,
            reverse_orientation: false,
            material,
            emission: None,
            trim: None,
            receiver: Some(ReceiverDescription {
                name,
                cells: None,
                side: ReceiverSide::Front,
                location: None,
            }),
            location: None,
        });
    }
}

/// Name, corner and sides of each; their cross product points inwards.
fn walls(size: DVec3) -> [(String, DVec3, DVec3, DVec3); 6] {
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
