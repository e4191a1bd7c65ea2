//! Detection of the dialect of a file: pbrt's language has two families of versions.

use std::sync::Arc;

use glanz_job::ResourceBudget;
use glanz_scene::description::FileId;

use crate::pbrt::lexer::{Lexer, Token};

/// The families; they differ in defaults and in the meaning of some parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dialect {
    /// pbrt 1 to 3.
    V3,
    /// pbrt 4.
    V4,
}

/// Directives that only one family has.
const DIRECTIVES: [(&str, Dialect); 10] = [
    ("Attribute", Dialect::V4),
    ("ColorSpace", Dialect::V4),
    ("Import", Dialect::V4),
    ("Option", Dialect::V4),
    ("Renderer", Dialect::V3),
    ("SearchPath", Dialect::V3),
    ("SurfaceIntegrator", Dialect::V3),
    ("Volume", Dialect::V3),
    ("VolumeIntegrator", Dialect::V3),
    ("WorldEnd", Dialect::V3),
];

/// Types of objects that only one family has, by directive.
const NAMES: [(&str, &[&str], &[&str]); 5] = [
    ("Film", &["image", "multiimage"], &["rgb", "gbuffer", "spectral"]),
    (
        "Sampler",
        &["02sequence", "adaptive", "bestcandidate", "lowdiscrepancy", "maxmindist", "random"],
        &["independent", "paddedsobol", "pmj02bn", "zsobol"],
    ),
    (
        "Integrator",
        &["directlighting", "whitted"],
        &["function", "lightpath", "randomwalk", "simplepath", "simplevolpath"],
    ),
    ("Material", V3_MATERIALS, V4_MATERIALS),
    ("Camera", &["environment"], &["spherical"]),
];

const V3_MATERIALS: &[&str] = &[
    "matte",
    "plastic",
    "glass",
    "mirror",
    "metal",
    "uber",
    "substrate",
    "translucent",
    "shinymetal",
    "fourier",
    "disney",
    "kdsubsurface",
    "none",
];
const V4_MATERIALS: &[&str] = &[
    "coatedconductor",
    "coateddiffuse",
    "conductor",
    "dielectric",
    "diffuse",
    "diffusetransmission",
    "interface",
    "measured",
    "thindielectric",
];
/// Types of parameters.
const V3_TYPES: &[&str] = &["color", "point", "vector"];
const V4_TYPES: &[&str] = &["point2", "point3", "vector2", "vector3"];
/// Parameters of pixel filters.
const V3_FILTER: &[&str] = &["float xwidth", "float ywidth", "float alpha"];
const V4_FILTER: &[&str] = &["float xradius", "float yradius", "float sigma"];

/// Detects the dialect by the first piece of evidence in the file; without any it is version 3.
///
/// Every file with `WorldEnd` is of version 3, but nearly all files have evidence in their first
/// lines. Included files are not examined. The search ends with the budget, as reading does then.
pub(crate) fn detect(bytes: &Arc<[u8]>, budget: &ResourceBudget) -> Dialect {
    // Its tokens count when they are read.
    let mut lexer = Lexer::new(Arc::clone(bytes), FileId(0), &ResourceBudget::default());
    let mut directive = String::new();
    let mut values = 0;
    let mut last_text = String::new();
    while let Some(first) = lexer.peek() {
        if budget.check().is_err() {
            break;
        }
        if first != b'"' && !first.is_ascii_uppercase() {
            lexer.skip_word();
            continue;
        }
        match lexer.next() {
            Ok(Some((Token::Word(word), _))) => {
                if let Some((_, dialect)) = DIRECTIVES.iter().find(|(name, _)| *name == word) {
                    return *dialect;
                }
                directive = word;
                values = 0;
            }
            Ok(Some((Token::Text(text), _))) => {
                if let Some(dialect) = evidence(&directive, values, &last_text, &text) {
                    return dialect;
                }
                values += 1;
                last_text = text;
            }
            // The parser reports the error.
            Ok(_) | Err(_) => {}
        }
    }
    Dialect::V3
}

/// Evidence for a version in text number `index` of a directive.
fn evidence(directive: &str, index: usize, before: &str, text: &str) -> Option<Dialect> {
    let pick = |v3: &[&str], v4: &[&str]| {
        if v3.contains(&text) { Some(Dialect::V3) } else { v4.contains(&text).then_some(Dialect::V4) }
    };
    if index == 0 {
        return NAMES.iter().find(|(d, _, _)| *d == directive).and_then(|(_, v3, v4)| pick(v3, v4));
    }
    if before == "string type" && directive == "MakeNamedMaterial" {
        return pick(V3_MATERIALS, V4_MATERIALS);
    }
    if directive == "PixelFilter"
        && let Some(dialect) = pick(V3_FILTER, V4_FILTER)
    {
        return Some(dialect);
    }
    let declared = text.split_ascii_whitespace().next().unwrap_or_default();
    if !text.trim().contains(' ') {
        return None;
    }
    if V3_TYPES.contains(&declared) {
        Some(Dialect::V3)
    } else {
        V4_TYPES.contains(&declared).then_some(Dialect::V4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_evidence_selects_the_dialect() {
        for (text, dialect) in [
            ("", Dialect::V3),
            ("Shape \"sphere\" \"float radius\" 1", Dialect::V3),
            ("# Film \"rgb\"\nFilm \"image\"", Dialect::V3),
            ("Film \"rgb\" WorldBegin Material \"matte\"", Dialect::V4),
            ("Sampler \"sobol\" PixelFilter \"gaussian\" \"float xradius\" 2", Dialect::V4),
            ("PixelFilter \"gaussian\" \"float alpha\" 2", Dialect::V3),
            ("WorldBegin MakeNamedMaterial \"a\" \"string type\" [\"diffuse\"]", Dialect::V4),
            ("WorldBegin MakeNamedMaterial \"diffuse\" \"string type\" \"matte\"", Dialect::V3),
            ("WorldBegin Shape \"trianglemesh\" \"point P\" [0 0 0]", Dialect::V3),
            ("WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0]", Dialect::V4),
            ("WorldBegin LightSource \"point\" \"rgb I\" [1 1 1] WorldEnd", Dialect::V3),
            ("Option \"bool disablepixeljitter\" true", Dialect::V4),
            ("Material \"point\" \"string name\" \"point\"", Dialect::V3),
        ] {
            assert_eq!(detect(&Arc::from(text.as_bytes()), &ResourceBudget::default()), dialect, "{text}");
        }
    }
}
