//! Models in the scene language, exactly: every number reads back to the same bits.
//!
//! `parameters` writes values, `shape` surfaces with their trimming, `material` materials, `medium` media. Parts are objects, their occurrences instances.

mod material;
mod medium;
mod parameters;
mod shape;

use std::collections::BTreeSet;
use std::fmt::Write;

use glanz_math::DMat4;
use glanz_scene::Description;
use glanz_scene::description::{
    FilterDescription, FilterKind, GroupDescription, InstanceDescription, SurfaceMedia,
};
use glanz_scene::studio::UpAxis;

use parameters::{matrix, quoted};

/// What the scene language cannot say, or what is no part of a model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PbrtWriteError {
    /// A part of a scene that models do not have.
    #[error("{0} cannot be written in the scene language yet")]
    Unsupported(&'static str),
    /// A shape whose numbers the language cannot say.
    #[error("shape {shape} of {group:?}: {reason}")]
    Shape {
        /// Name of its group.
        group: String,
        /// Its number in the group, from 1.
        shape: usize,
        /// What cannot be said.
        reason: &'static str,
    },
}

/// The text of a model in the scene language. `up`: its upward axis, for the studio.
///
/// Groups of the same name, and those without, get numbers; so do materials and media.
///
/// # Errors
/// [`PbrtWriteError`] for lights, textures, emission, receivers and media that emit a spectrum by wavelength, and for numbers that are not finite.
pub fn write(description: &Description, up: UpAxis) -> Result<String, PbrtWriteError> {
    let scene = [
        ("a light", description.lights.is_empty()),
        ("a texture", description.textures.is_empty()),
        ("a section", description.section.is_none()),
        ("a backdrop", description.backdrop.is_none()),
    ];
    if let Some((what, _)) = scene.into_iter().find(|(_, absent)| !absent) {
        return Err(PbrtWriteError::Unsupported(what));
    }
    let mut text = format!("# Glanz {}\n", env!("CARGO_PKG_VERSION"));
    // Writing to a text cannot fail.
    let _ = writeln!(text, "Option \"string studio\" [ \"{}\" ]", up.name());
    let [width, height] = description.film.resolution;
    let _ = writeln!(
        text,
        "Film \"rgb\" \"integer xresolution\" [ {width} ] \"integer yresolution\" [ {height} ]"
    );
    let FilterDescription { kind, radius: [x, y] } = description.filter;
    let FilterKind::Gaussian { sigma } = kind else {
        return Err(PbrtWriteError::Unsupported("a filter that is not a Gaussian"));
    };
    let _ = writeln!(
        text,
        "PixelFilter \"gaussian\" \"float sigma\" [ {sigma} ] \"float xradius\" [ {x} ] \"float yradius\" [ {y} ]"
    );
    for (number, described) in description.media.iter().enumerate() {
        medium::write(&mut text, number, described)?;
    }
    if description.camera_medium.is_some() {
        // The studio replaces all else of the camera.
        medium::write_interface(&mut text, SurfaceMedia { inside: None, outside: description.camera_medium });
        text.push_str("Camera \"perspective\"\n");
        medium::write_interface(&mut text, SurfaceMedia::default());
    }
    text.push_str("WorldBegin\n");
    for (number, described) in description.materials.iter().enumerate() {
        if described.surface_detail.is_some() {
            return Err(PbrtWriteError::Unsupported("a bump or normal map"));
        }
        material::write(&mut text, number, &described.kind)?;
    }
    let names = group_names(&description.groups);
    for (group, name) in description.groups.iter().zip(&names) {
        let _ = writeln!(text, "ObjectBegin {}", quoted(name));
        write_group(&mut text, group, name, &names)?;
        text.push_str("ObjectEnd\n");
    }
    write_group(&mut text, &description.world, "the world", &names)?;
    Ok(text)
}

fn write_group(
    text: &mut String,
    group: &GroupDescription,
    name: &str,
    names: &[String],
) -> Result<(), PbrtWriteError> {
    for (number, described) in group.shapes.iter().enumerate() {
        let refused = |reason| PbrtWriteError::Shape { group: name.to_owned(), shape: number + 1, reason };
        text.push_str("AttributeBegin\n");
        write_transform(text, described.to_parent).map_err(refused)?;
        if described.reverse_orientation {
            text.push_str("ReverseOrientation\n");
        }
        let _ = writeln!(text, "NamedMaterial {}", quoted(&material::name(described.material)));
        if described.media != SurfaceMedia::default() {
            medium::write_interface(text, described.media);
        }
        shape::write(text, described).map_err(refused)?;
        text.push_str("AttributeEnd\n");
    }
    for InstanceDescription { group, to_parent, .. } in &group.instances {
        let Some(inner) = names.get(*group) else { continue };
        text.push_str("AttributeBegin\n");
        let unsaid = |_| PbrtWriteError::Unsupported("an instance with numbers that are not finite");
        write_transform(text, *to_parent).map_err(unsaid)?;
        let _ = writeln!(text, "ObjectInstance {}\nAttributeEnd", quoted(inner));
    }
    Ok(())
}

fn write_transform(text: &mut String, to_parent: DMat4) -> Result<(), &'static str> {
    if !to_parent.is_finite() {
        return Err("its transformation is not finite");
    }
    // By bits: zeros have signs.
    let bits = |matrix: DMat4| matrix.to_cols_array().map(f64::to_bits);
    if bits(to_parent) != bits(DMat4::IDENTITY) {
        let _ = writeln!(text, "Transform {}", matrix(to_parent));
    }
    Ok(())
}

/// Names that differ.
fn group_names(groups: &[GroupDescription]) -> Vec<String> {
    let mut known: BTreeSet<String> = groups.iter().map(|group| group.name.clone()).collect();
    let mut used: BTreeSet<String> = BTreeSet::new();
    let mut names = Vec::with_capacity(groups.len());
    for (number, group) in groups.iter().enumerate() {
        let mut name = group.name.clone();
        if name.is_empty() || used.contains(&name) {
            let stem = if name.is_empty() { "part" } else { &name };
            let mut free = (number + 1..).map(|n| format!("{stem} {n}")).filter(|name| !known.contains(name));
            name = free.next().unwrap_or_default();
            known.insert(name.clone());
        }
        used.insert(name.clone());
        names.push(name);
    }
    names
}
