//! Right files of models: those of `step` and `iges`, which are read only, have many faces each; those of `step-faces` and `iges-faces`, whose faces are trimmed as
//! well, have one face each or few, since trimming takes many times as long.

pub(super) fn ascii_ply() -> Vec<u8> {
    b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n\
      property float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
      0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n3 0 1 2\n4 0 1 2 3\n"
        .to_vec()
}

pub(super) fn binary_ply() -> Vec<u8> {
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

pub(super) fn obj() -> Vec<u8> {
    b"mtllib a.mtl\no x\nv 0 0 0\nv 1 0 0 2\nv 1 1 0\nv 0 1 0 1 0 0\nvt 0 1\nvn 0 0 1\nusemtl a\nf 1/1 2//1 3 -1\nf 1 2 \\\n 3\n\
      cstype rat bspline\ndeg 1 1\nvp 0 0\nvp 1 1 2\ncurv2 1 2\nparm u 0 0 1 1\nend\nsurf 0 1 0 1 1 2 3 4\nparm u 0 0 1 1\nparm v 0 0 1 1\n\
      trim 0 1 1\nend\ncstype bezier\nsurf 0 1 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\nend\n"
        .to_vec()
}

pub(super) fn mtl() -> Vec<u8> {
    b"# colours\nnewmtl a\nKd .1 .2 .3\nKs 1 1 1\nNs 90\nNi 1.5\nd .5\nillum 2\nmap_Kd -s 2 2 1 -o .5 0 0 p.png\nnewmtl b\nKe 5 5 5\nPr .3\nPm 1\n\
      norm n.png\nmap_d -clamp on d.png\n"
        .to_vec()
}

pub(super) fn text_stl() -> Vec<u8> {
    b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"
        .to_vec()
}

pub(super) fn binary_stl() -> Vec<u8> {
    let mut binary = vec![b' '; 80];
    binary.extend(2_u32.to_le_bytes());
    binary.extend((0..100_u8).map(|i| i % 60));
    binary
}

pub(super) fn rib() -> Vec<u8> {
    br#"##RIB
WorldBegin TransformBegin Translate 1 2 3 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 3 4 5 1] Rotate 9 1 0 0
Basis "b-spline" 1 "catmull-rom" 1 PatchMesh "bicubic" 4 "nonperiodic" 4 "periodic" "P" [0 0 0 1 0 0 2 0 0 3 0 0
0 1 0 1 1 0 2 1 0 3 1 0 0 2 0 1 2 0 2 2 0 3 2 0 0 3 0 1 3 0 2 3 0 3 3 0] Patch "bilinear" "Pw" [0 0 0 1 1 0 0 1
0 1 0 1 1 1 0 2] TransformEnd Scale 1 -1 1 NuPatch 3 3 [0 0 0 1 1 1] 0 1 2 2 [0 0 1 1] 0 .5 "P" [1 2 3 4 5 6 7 8 9
0 9 8 7 6 5 4 3 2] Color [1 0 0] "string x" ["a"] WorldEnd"#
        .to_vec()
}

pub(super) fn newell() -> Vec<u8> {
    format!("2\n{}\n{}\n3\n0,1,2\n3 4 5\n6.5,7,8e0\n", "1,2,3,1,".repeat(4), "3,2,1,1,".repeat(4))
        .into_bytes()
}

/// A triangle of 12 numbers with its indices, coordinates and a picture of a pixel, in a buffer that these members describe.
fn gltf_text(buffer: &str) -> String {
    format!(
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
"byteLength":8}}],"buffers":[{{"byteLength":44{buffer}}}]}}"#
    )
}

pub(super) fn gltf() -> Vec<u8> {
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAAAAABAAIAAAA=";
    gltf_text(&format!(r#","uri":"data:;base64,{data}""#)).into_bytes()
}

pub(super) fn glb() -> Vec<u8> {
    let mut json = gltf_text("").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut data: Vec<u8> =
        [0.0_f32, 0., 0., 0., 1., 0., 0., 0., 0., 2.].iter().flat_map(|x| x.to_le_bytes()).collect();
    data.resize(36, 0);
    data.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    let chunk =
        |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), &kind[..], bytes].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &data)].concat();
    [&b"glTF"[..], &2_u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}

/// Faces on all kinds of surfaces; the second file has them in a product that occurs twice, with colours and mapped items. They are read only.
pub(super) fn step() -> Vec<Vec<u8>> {
    files(&[include_bytes!("../../seeds/entities.step"), include_bytes!("../../seeds/assembly.step")])
}

/// Entities of many kinds in one file. They are read only.
pub(super) fn iges() -> Vec<Vec<u8>> {
    files(&[include_bytes!("../../seeds/entities.iges")])
}

fn files(files: &[&[u8]]) -> Vec<Vec<u8>> {
    files.iter().map(|bytes| bytes.to_vec()).collect()
}

/// Faces of one kind of surface with one kind of border, and a small assembly, to be trimmed.
pub(super) fn step_faces() -> Vec<Vec<u8>> {
    files(&[
        include_bytes!("../../seeds/step-faces/assembly-of-disks.step"),
        include_bytes!("../../seeds/step-faces/bounded-plane.step"),
        include_bytes!("../../seeds/step-faces/cone.step"),
        include_bytes!("../../seeds/step-faces/cylinder-with-parameters.step"),
        include_bytes!("../../seeds/step-faces/cylinder.step"),
        include_bytes!("../../seeds/step-faces/disk.step"),
        include_bytes!("../../seeds/step-faces/extrusion.step"),
        include_bytes!("../../seeds/step-faces/half-sphere.step"),
        include_bytes!("../../seeds/step-faces/offset-spline.step"),
        include_bytes!("../../seeds/step-faces/quarter-torus.step"),
        include_bytes!("../../seeds/step-faces/revolution.step"),
        include_bytes!("../../seeds/step-faces/sphere.step"),
        include_bytes!("../../seeds/step-faces/spline.step"),
        include_bytes!("../../seeds/step-faces/torus.step"),
        include_bytes!("../../seeds/step-faces/triangle.step"),
        include_bytes!("../../seeds/step-faces/trimmed-cylinder.step"),
        include_bytes!("../../seeds/step-faces/whole-offset.step"),
        include_bytes!("../../seeds/step-faces/whole-revolution.step"),
    ])
}

/// The same of IGES, and faces of solids and of subfigures.
pub(super) fn iges_faces() -> Vec<Vec<u8>> {
    files(&[
        include_bytes!("../../seeds/iges-faces/assembly-of-solids.iges"),
        include_bytes!("../../seeds/iges-faces/bounded-spline.iges"),
        include_bytes!("../../seeds/iges-faces/revolution.iges"),
        include_bytes!("../../seeds/iges-faces/ruled.iges"),
        include_bytes!("../../seeds/iges-faces/subfigures.iges"),
        include_bytes!("../../seeds/iges-faces/tabulated-cylinder.iges"),
        include_bytes!("../../seeds/iges-faces/trimmed-in-space.iges"),
        include_bytes!("../../seeds/iges-faces/trimmed-spline.iges"),
    ])
}
