//! Whatever bytes come: a result or errors, no panic, no hang, and no more memory than the input warrants.

use glanz_formats::Diagnostics;
use glanz_formats::{Options, load_str, newell, obj, ply, rib, stl};
use glanz_scene::Description;
use glanz_scene::description::{GeometryDescription, GroupDescription, TrimDescription};

/// SplitMix64 (@steele2014): the same cases on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

const SCENES: &[&str] = &[
    r#"Scale -1 1 1 LookAt 0 3 8  0 .8 0  0 1 0 Camera "perspective" "float fov" [21] # note
    Film "image" "integer xresolution" [150] "float cropwindow" [0 1 0 .5] Sampler "halton" "integer pixelsamples" 8
    PixelFilter "gaussian" "float alpha" 2 Integrator "directlighting" WorldBegin AttributeBegin
    CoordSysTransform "camera" AreaLightSource "diffuse" "color L" [8 8 8] Translate 0 2 -10
    Shape "disk" "float radius" [3] AttributeEnd Material "plastic" "rgb Kd" [.1 .2 .3] "float roughness" .1
    Shape "trianglemesh" "integer indices" [0 1 2 2 0 3] "point P" [-10 0 -10 10 0 -10 10 0 10 -10 0 10] WorldEnd"#,
    r#"Film "rgb" "string filename" "x.exr" "integer pixelbounds" [0 10 0 10] ColorSpace "rec2020" WorldBegin
    Attribute "shape" "float radius" 2 MakeNamedMaterial "a" "string type" "conductor" "spectrum eta" "metal-Au-eta"
    "spectrum k" [400 1 500 2] NamedMaterial "a" ObjectBegin "o" Shape "sphere" "bool x" true ObjectEnd
    TransformBegin ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 3 4 5 1] ObjectInstance "o" TransformEnd
    LightSource "spot" "blackbody I" 3000 "float power" 10 "point3 from" [0 0 1] LightSource "infinite" "float illuminance" 3"#,
    r#"WorldBegin Texture "c" "color" "checkerboard" "string mapping" "planar" "vector v1" [1 0 0]
    Texture "d" "spectrum" "mix" "rgb tex1" [1 0 0] "texture tex2" "c" "float amount" .5 Texture "i" "float" "imagemap" "string filename" "p\n.png"
    Material "matte" "texture Kd" "c" Shape "algebraic" "integer exponents" [2 0 0 0 2 0 0 0 0] "float coefficients" [1 1 -1]
    Shape "polyhedron" "normal N" [1 0 0 0 1 0] "float d" [1 1] Shape "torus" Shape "box" "vector size" [1 2 3]
    ReverseOrientation ActiveTransform EndTime Rotate 90 1 0 0 ActiveTransform All MakeNamedMedium "a" "string type" "uniformgrid"
    "integer nx" 2 "float density" [1 2] "rgb sigma_a" [1 2 3] "float g" .5 MediumInterface "a" ""
    Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] MakeNamedMaterial "q" "string type" "glass"
    Material "mix" "string namedmaterial1" "q" "string namedmaterial2" "q""#,
    r#"Option "string studio" "z" WorldBegin Shape "nurbs" "integer nu" 2 "integer nv" 3 "integer uorder" 2 "integer vorder" [3] "float uknots" [0 0 1 1]
    "float vknots" [0 0 0 2 2 2] "float Pw" [0 0 0 1 1 0 0 1 0 1 0 .5 1 1 0 .5 0 2 0 1 1 2 0 1] "float v1" 1.5
    "float trimellipse" [.5 1 .2 .3] "float trimpolygon" [0 0 1 0 1 1] "string trimside" "inside" Shape "bezierpatch" "integer udegree" 1
    "integer vdegree" 1 "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] "float weights" [1 2 3 4] "integer trimloops" 1 "integer trimorders" 2
    "integer trimcounts" 4 "float trimknots" [0 0 1 2 3 3] "float trimpoints" [0 0 1 1 0 1 0 1 1 0 0 1] "float trimwidths" 1e-3
    "float trimscale" [2 3] "float trimdomain" [0 0 1 1] "integer trimedges" [0 1 2] "float trimedgeranges" [1 0] "integer solid" 1
    Shape "beziertriangle"
    "integer degree" 1 "point3 P" [0 0 0 1 0 0 0 1 0] Shape "patchmesh" "point3 P" [0 0 0] "integer indices" [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0]"#,
];

const WORDS: &[&[u8]] = &[
    b"AttributeBegin ",
    b"AttributeEnd ",
    b"WorldBegin ",
    b"WorldEnd ",
    b"ObjectBegin \"o\" ",
    b"ObjectInstance \"o\" ",
    b"\"",
    b"[",
    b"]",
    b"#",
    b"\\",
    b"\n",
    b"1e308 ",
    b"-1 ",
    b"2147483648 ",
    b"nan ",
    b"\xff\xfe",
    b"\0",
    b"[ ] ",
    b"\"float radius\" ",
    b"\"texture Kd\" \"c\" ",
    b"Transform [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0] ",
    b"Identity ",
    b"\"integer indices\" [4294967295] ",
    b"Shape \"sphere\" ",
    b"99999999999999999999999999 ",
    b"true ",
];

fn ascii_ply() -> Vec<u8> {
    b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n\
      property float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
      0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n3 0 1 2\n4 0 1 2 3\n"
        .to_vec()
}

fn binary_ply() -> Vec<u8> {
    let mut out =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property double z\nelement face 1\nproperty list uint uint vertex_index\nelement tristrips 1\n\
        property list int int vertex_indices\nend_header\n"
            .to_vec();
    for v in [[0f32, 0.0], [1.0, 0.0], [0.0, 1.0]] {
        out.extend(v.iter().flat_map(|x| x.to_le_bytes()));
        out.extend(0.5f64.to_le_bytes());
    }
    for i in [3u32, 0, 1, 2, 4, 0, 1, 2, u32::MAX] {
        out.extend(i.to_le_bytes());
    }
    out
}

/// A few random changes: cut, drop, repeat, overwrite, insert.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random, words: &[&[u8]]) {
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len() + 1);
        let length = random.below(40).min(bytes.len() - at);
        match random.below(7) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..at + length)),
            2 => {
                let part = bytes[at..at + length].to_vec();
                let times = 1 + random.below(8);
                bytes.splice(at..at, part.repeat(times));
            }
            3 if at < bytes.len() => bytes[at] = random.next() as u8,
            4 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            5 if !bytes.is_empty() => {
                let to = random.below(bytes.len());
                let part = bytes[at..at + length].to_vec();
                bytes.splice(to..to, part);
            }
            _ => {
                let word = words[random.below(words.len())];
                bytes.splice(at..at, word.iter().copied());
            }
        }
    }
}

/// Reads mutated copies of files in turn. Both outcomes of `read`, a result or not, must be common, or the test tests little.
fn assert_both_outcomes(
    seed: u64,
    cases: usize,
    files: &[&[u8]],
    words: &[&[u8]],
    mut read: impl FnMut(&[u8]) -> bool,
) {
    let (mut random, mut count) = (Random(seed), 0);
    for case in 0..cases {
        let mut bytes = files[case % files.len()].to_vec();
        mutate(&mut bytes, &mut random, words);
        count += usize::from(read(&bytes));
    }
    assert!(count > cases / 50 && count < cases, "{count} of {cases} were read");
}

/// Everything a description holds, counted.
fn size(d: &Description) -> usize {
    let of_group = |g: &GroupDescription| {
        let of_trim = |t: &TrimDescription| {
            let curves = t.loops.iter().flat_map(|l| &l.curves);
            t.loops.len() + curves.map(|c| 1 + c.knots.len() + c.points.len()).sum::<usize>()
        };
        let trims = g.shapes.iter().filter_map(|s| s.trim.as_ref()).map(of_trim).sum::<usize>();
        let of_patches =
            |patches: &[Vec<[f64; 4]>]| 1 + patches.len() + patches.iter().map(Vec::len).sum::<usize>();
        let of_shapes = g.shapes.iter().map(|s| match &s.geometry {
            GeometryDescription::Nurbs(n) => 1 + n.knots_u.len() + n.knots_v.len() + n.points.len(),
            GeometryDescription::BezierPatches(b) => of_patches(&b.patches),
            GeometryDescription::BezierTriangles(b) => of_patches(&b.patches),
            GeometryDescription::Triangles { positions, indices, normals, uvs } => {
                let more = normals.as_ref().map_or(0, Vec::len) + uvs.as_ref().map_or(0, Vec::len);
                1 + positions.len() + indices.len() + more
            }
            GeometryDescription::Bilinear { positions, indices } => 1 + positions.len() + indices.len(),
            GeometryDescription::Algebraic { terms, .. } => 1 + terms.len(),
            GeometryDescription::Polyhedron { half_spaces } => 1 + half_spaces.len(),
            _ => 1,
        });
        trims + of_shapes.sum::<usize>() + g.instances.len() + g.name.len()
    };
    let groups = d.groups.iter().chain([&d.world]).map(of_group).sum::<usize>();
    groups + d.textures.len() + d.materials.len() + d.lights.len() + d.images.len()
}

fn check(result: Result<glanz_formats::Loaded, Diagnostics>, length: usize) -> bool {
    match result {
        Ok(loaded) => {
            // No number makes more than one entry, nothing makes an entry of no bytes, and a directive makes at most
            // a material and two textures.
            assert!(size(&loaded.description) <= 3 * length + 1, "{} of {length}", size(&loaded.description));
            assert!(!loaded.diagnostics.has_errors());
            assert!(loaded.diagnostics.to_string().len() <= 1_000 * (length + 1));
            true
        }
        Err(errors) => {
            assert!(errors.has_errors());
            false
        }
    }
}

#[test]
fn the_scenes_are_right_before_they_are_mutated() {
    for text in SCENES {
        load_str("whole", text, &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    }
}

#[test]
fn mutated_scenes_end_in_a_result_or_errors() {
    let mut random = Random(1);
    let mut read = 0;
    let cases = 12_000;
    for case in 0..cases {
        let mut bytes = SCENES[case % SCENES.len()].as_bytes().to_vec();
        mutate(&mut bytes, &mut random, WORDS);
        let text = String::from_utf8_lossy(&bytes);
        let options = Options { strict: case % 5 == 0, ..Options::default() };
        read += usize::from(check(load_str("mutated", &text, &options), text.len()));
    }
    // Both outcomes must be common, or the test tests little.
    assert!(read > cases / 50 && read < cases / 2, "{read} of {cases} were read");
}

#[test]
fn scenes_of_words_in_any_order_end_in_a_result_or_errors() {
    let mut random = Random(2);
    for _ in 0..4_000 {
        let mut bytes = Vec::new();
        for _ in 0..random.below(40) {
            if random.below(2) == 0 {
                bytes.extend_from_slice(WORDS[random.below(WORDS.len())]);
            } else {
                let scene = SCENES[random.below(SCENES.len())];
                let words: Vec<&str> = scene.split(' ').collect();
                bytes.extend_from_slice(words[random.below(words.len())].as_bytes());
                bytes.push(b' ');
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        check(load_str("words", &text, &Options::default()), text.len());
    }
}

#[test]
fn mutated_meshes_end_in_a_mesh_or_an_error() {
    let words: &[&[u8]] = &[
        b"element face 18446744073709551615\n",
        b"property list uint uint vertex_indices\n",
        b"4294967295 ",
        b"-1 ",
        b"property double x\n",
        b"element vertex 0\n",
        b"end_header\n",
        b"\xff\xff\xff\xff",
        b"1e400 ",
        b"nan ",
        b"format binary_big_endian 1.0\n",
    ];
    assert_both_outcomes(3, 20_000, &[&ascii_ply(), &binary_ply()], words, |bytes| {
        let Ok(mesh) = ply::read(bytes) else { return false };
        let entries = mesh.positions.len() + mesh.triangles.len();
        assert!(entries <= bytes.len(), "{entries} of {}", bytes.len());
        let count = mesh.positions.len() as u32;
        assert!(mesh.triangles.iter().flatten().all(|&i| i < count));
        true
    });
}

#[test]
fn mutated_lists_of_patches_end_in_patches_or_an_error() {
    let whole =
        format!("2\n{}\n{}\n3\n0,1,2\n3 4 5\n6.5,7,8e0\n", "1,2,3,1,".repeat(4), "3,2,1,1,".repeat(4));
    let words: &[&[u8]] = &[b"4294967295,", b"-1,", b"1e400,", b"nan,", b",,\n", b"\xff\xff", b"0 0\n"];
    assert_both_outcomes(4, 10_000, &[whole.as_bytes()], words, |bytes| {
        let Ok(mesh) = newell::read(bytes) else { return false };
        assert!(mesh.positions.len() + 16 * mesh.patches.len() <= bytes.len());
        let count = mesh.positions.len() as u32;
        assert!(mesh.patches.as_flattened().iter().all(|&i| i < count));
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        true
    });
}

#[test]
fn mutated_rib_files_end_in_surfaces_or_an_error() {
    let whole = r#"##RIB
        WorldBegin TransformBegin Translate 1 2 3 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 3 4 5 1] Rotate 9 1 0 0
        Basis "b-spline" 1 "catmull-rom" 1 PatchMesh "bicubic" 4 "nonperiodic" 4 "periodic" "P" [0 0 0 1 0 0 2 0 0 3 0 0
        0 1 0 1 1 0 2 1 0 3 1 0 0 2 0 1 2 0 2 2 0 3 2 0 0 3 0 1 3 0 2 3 0 3 3 0] Patch "bilinear" "Pw" [0 0 0 1 1 0 0 1
        0 1 0 1 1 1 0 2] TransformEnd Scale 1 -1 1 NuPatch 3 3 [0 0 0 1 1 1] 0 1 2 2 [0 0 1 1] 0 .5 "P" [1 2 3 4 5 6 7 8 9
        0 9 8 7 6 5 4 3 2] Color [1 0 0] "string x" ["a"] WorldEnd"#;
    let words: &[&[u8]] = &[
        b"4294967295 ",
        b"-1 ",
        b"1e308 ",
        b"nan ",
        b"[",
        b"]",
        b"\"",
        b"#",
        b"\xff\xfe",
        b"AttributeBegin ",
        b"TransformEnd ",
        b"\"periodic\" ",
        b"\"bilinear\" ",
        b"\"power\" ",
        b"ReverseOrientation ",
        b"2 ",
    ];
    assert_both_outcomes(5, 10_000, &[whole.as_bytes()], words, |bytes| {
        let Ok(file) = rib::read(bytes) else { return false };
        let of_patches = file.patches.iter().flat_map(|p| &p.patches).flatten();
        let points: Vec<_> = of_patches.chain(file.splines.iter().flat_map(|s| &s.points)).collect();
        // A point takes six bytes and is part of up to sixteen patches.
        assert!(points.len() <= 3 * bytes.len(), "{} of {}", points.len(), bytes.len());
        assert!(points.iter().all(|p| p.iter().all(|x| x.is_finite()) && p[3] > 0.0));
        assert!(file.skipped.len() <= bytes.len());
        true
    });
}

#[test]
fn mutated_gltf_files_end_in_a_result_or_errors() {
    // A triangle of 12 numbers with its indices, coordinates and a picture of a pixel.
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAAAAABAAIAAAA=";
    let whole = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,2]}}],"nodes":[{{"mesh":0,"children":[1],"rotation":[0,0,0,1]}},
        {{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,3,4,5,1]}},{{"camera":0,"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":1,"aspectRatio":1.5,"znear":1}}}}],"extensions":{{"KHR_lights_punctual":
        {{"lights":[{{"type":"spot","intensity":5,"spot":{{"outerConeAngle":0.5}}}}]}}}},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,
        "NORMAL":0,"TEXCOORD_0":2}},"indices":1,"material":0,"mode":4}},{{"attributes":{{"POSITION":3}},"mode":5}}]}}],"materials":[{{"pbrMetallicRoughness":
        {{"baseColorTexture":{{"index":0,"extensions":{{"KHR_texture_transform":{{"scale":[2,2]}}}}}},"metallicFactor":0.5}},"emissiveFactor":[1,0,0]}}],
        "textures":[{{"source":0,"sampler":0}}],"samplers":[{{"wrapS":10497,"magFilter":9728}}],"images":[{{"uri":"data:image/x-portable-graymap;base64,UDIKMSAxCjI1NQo3Cg=="}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},{{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}},
        {{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}},{{"componentType":5126,"count":3,"type":"VEC3","sparse":{{"count":2,"indices":
        {{"bufferView":1,"componentType":5123}},"values":{{"bufferView":0}}}}}}],"bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,
        "byteLength":8}}],"buffers":[{{"byteLength":44,"uri":"data:;base64,{data}"}}]}}"#
    );
    load_str("whole", &whole, &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    let words: &[&[u8]] = &[
        b"4294967295",
        b"18446744073709551615",
        b"-1",
        b"1e308",
        b"null",
        b"[",
        b"]",
        b"{",
        b"}",
        b",",
        b"\"",
        b"\"mode\":6,",
        b"\"byteStride\":1,",
        b"\"count\":1000,",
        b"\"normalized\":true,",
        b"\"scale\":[0,1e300,1],",
        b"0,",
        b"\xff",
    ];
    let mut random = Random(6);
    let (mut read, cases) = (0, 10_000);
    for _ in 0..cases {
        let mut bytes = whole.clone().into_bytes();
        // Single characters, so that some files remain JSON.
        match random.below(3) {
            0 => mutate(&mut bytes, &mut random, words),
            _ => {
                let at = random.below(bytes.len());
                bytes[at] = b"0123456789"[random.below(10)];
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        read += usize::from(check(load_str("mutated", &text, &Options::default()), text.len()));
    }
    assert!(read > cases / 50 && read < cases, "{read} of {cases} were read");
}

#[test]
fn mutated_obj_files_end_in_surfaces_or_an_error() {
    let whole = "mtllib a.mtl\no x\nv 0 0 0\nv 1 0 0 2\nv 1 1 0\nv 0 1 0 1 0 0\nvt 0 1\nvn 0 0 1\nusemtl a\nf 1/1 2//1 3 -1\nf 1 2 \\\n 3\n\
        cstype rat bspline\ndeg 1 1\nvp 0 0\nvp 1 1 2\ncurv2 1 2\nparm u 0 0 1 1\nend\nsurf 0 1 0 1 1 2 3 4\nparm u 0 0 1 1\nparm v 0 0 1 1\n\
        trim 0 1 1\nend\ncstype bezier\nsurf 0 1 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\nend\n";
    let words: &[&[u8]] = &[
        b"4294967296 ",
        b"-1 ",
        b"1e400 ",
        b"nan ",
        b"/",
        b"\\\n",
        b"deg 100\n",
        b"\xff\xfe",
        b"f 1 2 3 4 1 2 3\n",
        b"end\n",
    ];
    assert_both_outcomes(7, 10_000, &[whole.as_bytes()], words, |bytes| {
        let _ = obj::read_materials(bytes);
        let Ok(file) = obj::read(bytes) else { return false };
        let entries = file.meshes.iter().map(|mesh| mesh.positions.len() + mesh.triangles.len());
        let points = file.surfaces.iter().map(|s| s.surface.points.len() + s.surface.knots_u.len());
        assert!(entries.chain(points).sum::<usize>() <= bytes.len());
        for mesh in &file.meshes {
            let count = mesh.positions.len() as u32;
            assert!(mesh.triangles.iter().flatten().all(|&i| i < count));
        }
        true
    });
}

#[test]
fn mutated_stl_files_end_in_a_mesh_or_an_error() {
    let text = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
    let mut binary = vec![b' '; 80];
    binary.extend(2_u32.to_le_bytes());
    binary.extend((0..100_u8).map(|i| i % 60));
    let words: &[&[u8]] = &[b"endsolid\nsolid\n", b"1e999 ", b"nan ", b"\xff\xff\xff\xff", b"facet ", b"\0"];
    assert_both_outcomes(8, 10_000, &[text, &binary], words, |bytes| {
        let Ok(mesh) = stl::read(bytes) else { return false };
        assert!(50 * mesh.triangles.len() <= bytes.len(), "{} facets", mesh.triangles.len());
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        true
    });
}
