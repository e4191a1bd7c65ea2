//! Models: meshes, patches and CAD. Each is read by itself, and as a file that a user opens; CAD has a target for each of the two: opening also trims its faces.

use glanz::formats::cad::{BrepFile, ReadingReport};
use glanz::formats::{Diagnostics, Loaded, Options, iges, load, newell, obj, ply, rib, step, stl};
use glanz::job::{CancelFlag, ResourceBudget};
use glanz::math::DVec3;

use super::{ReadOutcome, Target, loaded, model_seeds as seeds, with_file};
use crate::limits;
use crate::mutation::Syntax;

/// A target of files of this name.
macro_rules! model {
    ($name:literal, $file:literal, $syntax:expr, $seeds:expr, $check:expr, $divisor:expr) => {
        Target {
            name: $name,
            syntax: $syntax,
            seeds: $seeds,
            run: |bytes| {
                ($check)(bytes);
                with_file($file, bytes, |path| {
                    let limits = limits::of_reading();
                    let options = Options { edges: true, confined: true, limits, ..Options::default() };
                    opened(load(path, &options), bytes.len())
                })
            },
            memory_factor: FACTOR,
            divisor: $divisor,
        }
    };
}

/// The number of shapes is that of the CAD report, if there is one.
fn opened(result: Result<Loaded, Diagnostics>, length: usize) -> ReadOutcome {
    if let Ok(scene) = &result
        && let Some(cad) = &scene.cad
    {
        let description = &scene.description;
        let groups: usize = description.groups.iter().map(|group| group.shapes.len()).sum();
        assert_eq!(cad.shapes.len(), groups + description.world.shapes.len());
        // Points along edges and the parts of surfaces are as many as their curvature needs.
        return noted(&cad.reading);
    }
    loaded(result, length)
}

/// Bytes of memory per byte of a model: a point in a text takes few bytes, and becomes control points, parts of surfaces and names.
const FACTOR: usize = 2000;

pub(super) const TARGETS: &[Target] = &[
    model!("ply", "a.ply", Syntax::Text(PLY), || vec![seeds::ascii_ply()], mesh, 1),
    model!("binary-ply", "a.ply", Syntax::Binary(360), || vec![seeds::binary_ply()], mesh, 1),
    model!("obj", "a.obj", Syntax::Text(OBJ), || vec![seeds::obj()], obj, 1),
    Target {
        name: "mtl",
        syntax: Syntax::Text(MTL),
        seeds: || vec![seeds::mtl()],
        run: |bytes| obj::read_materials(bytes).into(),
        memory_factor: FACTOR,
        divisor: 1,
    },
    model!("stl", "a.stl", Syntax::Text(STL), || vec![seeds::text_stl()], triangles, 1),
    model!("binary-stl", "a.stl", Syntax::Binary(134), || vec![seeds::binary_stl()], triangles, 1),
    model!("rib", "a.rib", Syntax::Text(RIB), || vec![seeds::rib()], surfaces, 1),
    model!(
        "newell",
        "a.txt",
        Syntax::Text(&["0", "0 0", ",,", "3", "1,2,3"]),
        || vec![seeds::newell()],
        patches,
        1
    ),
    model!("gltf", "a.gltf", Syntax::Text(GLTF), || vec![seeds::gltf()], |_: &[u8]| (), 1),
    model!("glb", "a.glb", Syntax::Binary(24), || vec![seeds::glb()], |_: &[u8]| (), 1),
    Target {
        name: "step",
        syntax: Syntax::Text(STEP),
        seeds: seeds::step,
        run: |bytes| cad(step::read_with(bytes, &budget())),
        memory_factor: FACTOR,
        divisor: 1,
    },
    Target {
        name: "iges",
        syntax: Syntax::Text(IGES),
        seeds: seeds::iges,
        run: |bytes| cad(iges::read_with(bytes, &budget())),
        memory_factor: FACTOR,
        divisor: 1,
    },
    // Faces are trimmed and their edges sampled, which takes many times as long as reading.
    model!("step-faces", "a.step", Syntax::Text(STEP), seeds::step_faces, |_: &[u8]| (), 20),
    model!("iges-faces", "a.iges", Syntax::Text(IGES), seeds::iges_faces, |_: &[u8]| (), 20),
];

const PLY: &[&str] = &[
    "element face 18446744073709551615\n",
    "property list uint uint vertex_indices\n",
    "property double x\n",
    "property list float double x\n",
    "element vertex 0\n",
    "end_header\n",
    "format binary_big_endian 1.0\n",
    "comment",
];
const OBJ: &[&str] = &[
    "/",
    "\\\n",
    "deg 100\n",
    "deg 1 1\n",
    "f 1 2 3 4 1 2 3\n",
    "end\n",
    "cstype bezier\n",
    "cstype rat bspline\n",
    "v 1 2 3\n",
    "parm u 0 0 1 1\n",
    "trim 0 1 1\n",
    "hole 0 1 1\n",
    "curv2 1 2\n",
    "usemtl b\n",
    "g x\n",
    "#",
];
const MTL: &[&str] = &[
    "newmtl b\n",
    "Kd",
    "Ks .5 .5 .5\n",
    "map_Kd -s 2 2 2 x.png\n",
    "-o",
    "d",
    "Tr",
    "illum 7\n",
    "Pr",
    "xyz",
    "spectral x\n",
];
const STL: &[&str] =
    &["endsolid\nsolid\n", "facet normal 0 0 1", "vertex", "outer loop", "endloop", "endfacet", "\0"];
const RIB: &[&str] = &[
    "AttributeBegin",
    "TransformEnd",
    "TransformBegin",
    "\"periodic\"",
    "\"bilinear\"",
    "\"power\"",
    "ReverseOrientation",
    "2",
    "[",
    "]",
    "Basis \"bezier\" 3 \"b-spline\" 1",
    "TrimCurve",
    "ObjectBegin 1",
    "Scale 0 0 0",
    "Patch \"bicubic\" \"P\"",
];
const GLTF: &[&str] = &[
    "null",
    "[",
    "]",
    "{",
    "}",
    ",",
    "\"mode\":6,",
    "\"byteStride\":1,",
    "\"count\":1000,",
    "\"normalized\":true,",
    "\"scale\":[0,1e300,1],",
    "\"children\":[0,1,2],",
    "\"sparse\":{},",
    "\"componentType\":5121,",
    "\"bufferView\":0,",
];
const STEP: &[&str] = &[
    "(",
    ")",
    ";",
    "$",
    "*",
    ".T.",
    ".F.",
    "#1",
    "''",
    "/*",
    "(#1,#1,#1)",
    "\\X2\\03A6\\X0\\",
    "ENDSEC;",
    "DATA;",
];
const IGES: &[&str] =
    &[",", ";", "4Hname", "99999H", "144", "128", "0", "1.D0", "-1", "S0000001\n", "P0000001\n"];

/// Entries take bytes, and indices are those of vertices.
fn mesh(bytes: &[u8]) {
    let Ok(mesh) = ply::read(bytes) else { return };
    let entries = mesh.positions.len() + mesh.triangles.len();
    assert!(entries <= bytes.len(), "{entries} entries of {} bytes", bytes.len());
    let count = mesh.positions.len() as u32;
    assert!(mesh.triangles.as_flattened().iter().all(|&i| i < count), "an index without a vertex");
}

fn triangles(bytes: &[u8]) {
    let Ok(mesh) = stl::read(bytes) else { return };
    assert!(
        50 * mesh.triangles.len() <= bytes.len(),
        "{} facets of {} bytes",
        mesh.triangles.len(),
        bytes.len()
    );
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    let count = mesh.positions.len() as u32;
    assert!(mesh.triangles.as_flattened().iter().all(|&i| i < count), "an index without a vertex");
}

fn obj(bytes: &[u8]) {
    let Ok(file) = obj::read(bytes) else { return };
    let entries = file.meshes.iter().map(|mesh| mesh.positions.len() + mesh.triangles.len());
    let points = file.surfaces.iter().map(|s| s.surface.points.len() + s.surface.knots_u.len());
    assert!(entries.chain(points).sum::<usize>() <= bytes.len());
    for mesh in &file.meshes {
        let count = mesh.positions.len() as u32;
        assert!(mesh.triangles.as_flattened().iter().all(|&i| i < count), "an index without a vertex");
    }
}

fn patches(bytes: &[u8]) {
    let Ok(mesh) = newell::read(bytes) else { return };
    assert!(mesh.positions.len() + 16 * mesh.patches.len() <= bytes.len());
    let count = mesh.positions.len() as u32;
    assert!(mesh.patches.as_flattened().iter().all(|&i| i < count), "an index without a vertex");
    assert!(mesh.positions.iter().all(|p: &DVec3| p.is_finite()));
}

/// A point takes six bytes and is part of up to sixteen patches.
fn surfaces(bytes: &[u8]) {
    let Ok(file) = rib::read(bytes) else { return };
    let of_patches = file.patches.iter().flat_map(|p| &p.patches).flatten();
    let points: Vec<_> = of_patches.chain(file.splines.iter().flat_map(|s| &s.points)).collect();
    assert!(points.len() <= 3 * bytes.len(), "{} points of {} bytes", points.len(), bytes.len());
    assert!(points.iter().all(|p| p.iter().all(|x| x.is_finite()) && p[3] > 0.0));
    assert!(file.skipped.len() <= bytes.len());
}

fn budget() -> ResourceBudget {
    ResourceBudget::new(limits::of_reading(), CancelFlag::default())
}

/// Every face is counted, and what is referred to exists.
fn cad<E: std::fmt::Display>(result: Result<BrepFile, E>) -> ReadOutcome {
    let file = match result {
        Ok(file) => file,
        Err(error) => return Err::<(), E>(error).into(),
    };
    let faces = file.report.faces;
    assert_eq!(faces.total, faces.read + faces.refused + faces.hidden + faces.unreachable);
    let model = &file.model;
    assert!(model.faces.iter().all(|face| face.surface < model.surfaces.len()), "a face without its surface");
    for (i, part) in model.parts.iter().enumerate() {
        assert!(part.occurrences.iter().all(|occurrence| occurrence.part < i), "a part in itself");
    }
    noted(&file.report)
}

/// The last note of each kind.
fn noted(report: &ReadingReport) -> ReadOutcome {
    let lists = [&report.faults, &report.omissions, &report.repairs];
    let notes = lists.map(|list| list.notes().last().map_or("", |note| note.reason.as_str()));
    ReadOutcome::Read(notes.join("; "))
}
