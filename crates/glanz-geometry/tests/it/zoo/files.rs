//! Control points of patches from files.

use glanz_math::glam::DVec4;

/// The bicubic patches of a text in Newell's format (count, 16 indices from 1 per line, count, a point per line) or in
/// RIB (`Patch "bicubic" "P" [48 numbers]`, everything else is skipped).
pub fn bicubic_patches(text: &str) -> Result<Vec<Vec<DVec4>>, String> {
    let patches = if text.contains("Patch") { of_rib(text) } else { of_newell(text) }?;
    if patches.is_empty() { Err("no patches".to_owned()) } else { Ok(patches) }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    words.map(|word| word.parse().map_err(|_| format!("{word:?} is not a number"))).collect()
}

fn of_newell(text: &str) -> Result<Vec<Vec<DVec4>>, String> {
    let short = || "too few numbers".to_owned();
    let all = numbers(text)?;
    let count = *all.first().ok_or_else(short)? as usize;
    let indices = all.get(1..1 + 16 * count).ok_or_else(short)?;
    let points = all.get(2 + 16 * count..).ok_or_else(short)?.as_chunks::<3>().0;
    let point = |&index: &f64| {
        let [x, y, z] = points.get((index as usize).wrapping_sub(1)).ok_or_else(short)?;
        Ok(DVec4::new(*x, *y, *z, 1.0))
    };
    indices.chunks_exact(16).map(|patch| patch.iter().map(point).collect()).collect()
}

fn of_rib(text: &str) -> Result<Vec<Vec<DVec4>>, String> {
    let mut patches = Vec::new();
    for statement in text.split("Patch").skip(1) {
        let Some(list) = statement.trim_start().strip_prefix("\"bicubic\" \"P\"") else { continue };
        let list = list.split_once('[').and_then(|(_, rest)| rest.split_once(']'));
        let all = numbers(list.ok_or("a list has no end")?.0)?;
        let points = all.as_chunks::<3>().0;
        if points.len() != 16 {
            return Err(format!("{} points instead of 16", points.len()));
        }
        patches.push(points.iter().map(|&[x, y, z]| DVec4::new(x, y, z, 1.0)).collect());
    }
    Ok(patches)
}

#[test]
fn both_formats_give_the_same_patch() {
    let points: Vec<[f64; 3]> = (0..16).map(|k| [f64::from(k), 0.5, -1.0]).collect();
    let line = |[x, y, z]: &[f64; 3]| format!("{x},{y},{z}\n");
    let indices: Vec<String> = (1..=16).map(|k: u32| k.to_string()).collect();
    let newell: String = points.iter().map(line).collect();
    let newell = format!("1\n{}\n16\n{newell}", indices.join(","));
    let list: Vec<String> = points.as_flattened().iter().map(f64::to_string).collect();
    let rib = format!("AttributeBegin\nPatch \"bicubic\" \"P\" [{}]\nAttributeEnd\n", list.join(" "));
    let expected: Vec<DVec4> = points.iter().map(|&[x, y, z]| DVec4::new(x, y, z, 1.0)).collect();
    assert_eq!(bicubic_patches(&newell).unwrap(), std::slice::from_ref(&expected));
    assert_eq!(bicubic_patches(&rib).unwrap(), [expected]);
    assert!(
        bicubic_patches("1\n1,2,3").is_err() && bicubic_patches("Patch \"bicubic\" \"P\" [1 2]").is_err()
    );
}
