//! Triangles of primitives.

use super::*;

#[test]
fn strips_and_fans_keep_their_orientation_and_unused_vertices_are_dropped() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &CORNERS);
    let strip = data.bytes(&[0, 1, 2, 3]);
    let fan = data.bytes(&[1, 3, 2, 0]);
    let attributes = json!({ "POSITION": position });
    let primitive =
        |mode: u32, indices: usize| json!({ "attributes": attributes, "mode": mode, "indices": indices });
    let primitives = json!([primitive(5, strip), primitive(6, fan), primitive(1, fan)]);
    let loaded = load(&data.file(json!({ "meshes": [{ "primitives": primitives }] })));
    let (positions, indices, normals, uvs) = triangles(&loaded, 0);
    assert_eq!(
        positions,
        [[0.0, 0.0], [1.0, 0.0], [0.0, 2.0], [1.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0))
    );
    assert_eq!(indices, [[0, 1, 2], [1, 3, 2]]);
    assert!(normals.is_none() && uvs.is_none());
    assert_eq!(triangles(&loaded, 1).1, [[3, 2, 1], [2, 0, 1]]);
    assert_eq!(warnings(&loaded), "warning: m: /meshes/0/primitives/2: points and lines are left out\n");
}

#[test]
fn elements_may_be_interleaved_normalised_and_sparse() {
    let mut data = Data::default();
    // Two vertices of 3 x i16 normalised and 2 bytes of rest; the third is a sparse one.
    let bytes: Vec<u8> = [0_i16, 32767, -32768, 7, -32767, 0, 16384, 7, 0, 0, 0, 7]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": 1, "componentType": 5121 },
        "values": { "bufferView": 2 },
    });
    let more = json!({ "normalized": true, "byteStride": 8, "sparse": sparse });
    let position = data.add((5122, "VEC3", 3), &bytes, more);
    data.bytes(&[2]);
    let values: Vec<u8> = [32767_i16, 32767, 32767].iter().flat_map(|x| x.to_le_bytes()).collect();
    data.add((5122, "VEC3", 1), &values, json!({}));
    let primitives = json!([{ "attributes": { "POSITION": position } }]);
    let loaded = load(&data.file(json!({ "meshes": [{ "primitives": primitives }] })));
    let (positions, indices, ..) = triangles(&loaded, 0);
    // max(c / 32767, -1), by the specification.
    let half = 16384.0 / 32767.0;
    assert_eq!(positions, [DVec3::new(0.0, 1.0, -1.0), DVec3::new(-1.0, 0.0, half), DVec3::ONE]);
    assert_eq!(indices, [[0, 1, 2]]);
}

#[test]
fn primitives_may_share_vertices_with_colours() {
    let mut data = Data::default();
    let position = data.floats("VEC3", &[0.0; 3000]);
    let color = data.add((5121, "VEC4", 1000), &[255; 4000], json!({ "normalized": true }));
    let indices = data.bytes(&[0, 1, 2]);
    let gray = data.add(
        (5121, "VEC4", 1000),
        &[[255; 12].as_slice(), &[7; 3988]].concat(),
        json!({ "normalized": true }),
    );
    let primitive = |color: usize| json!({ "attributes": { "POSITION": position, "COLOR_0": color }, "indices": indices });
    // Each uses three vertices alone, which are white.
    let primitives = [vec![primitive(color); 200], vec![primitive(gray); 200]].concat();
    assert_eq!(warnings(&load(&data.file(json!({ "meshes": [{ "primitives": primitives }] })))), "");
}
