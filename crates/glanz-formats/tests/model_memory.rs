//! Memory of reading files that use their contents again and again, counted in bytes by the allocator of this program.

use glanz_formats::{Options, load_str};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes at the peak: per byte of the file, and in any case.
const LIMIT: [usize; 2] = [600, 1 << 21];

/// A name, and a text that repeats `part` between its first and last part.
fn cases() -> Vec<(&'static str, String)> {
    let repeated =
        |first: &str, part: &str, last: &str| format!("{first}{}{last}", part.repeat(100_000 / part.len()));
    let gltf = |members: String| format!("{{\"asset\":{{\"version\":\"2.0\"}},{members}}}");
    let data = "A".repeat(4_000);
    let mesh = format!(
        "\"buffers\":[{{\"byteLength\":3000,\"uri\":\"data:;base64,{data}\"}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":3000}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":250,\"type\":\"VEC3\"}},\
         {{\"bufferView\":0,\"componentType\":5121,\"count\":3000,\"type\":\"SCALAR\"}},\
         {{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}}]"
    );
    let primitive = "{\"attributes\":{\"POSITION\":0,\"NORMAL\":0},\"indices\":1},";
    vec![
        ("lists", gltf(repeated("\"nodes\":[", "{},", "{}]"))),
        ("depth", gltf(repeated("\"x\":", "[", ""))),
        (
            "primitives",
            gltf(format!(
                "{mesh},{}",
                repeated("\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[", primitive, "{}]}]")
            )),
        ),
        (
            "nodes",
            gltf(format!(
                "{mesh},{},\"meshes\":[{{\"primitives\":[{}{{}}]}}]",
                repeated("\"nodes\":[", "{\"mesh\":0},", "{}]"),
                primitive
            )),
        ),
        ("pictures", gltf(format!("{mesh},{}", pictures()))),
        ("instances", gltf(instances(1))),
        ("names", gltf(instances(50_000))),
        ("vertices", repeated("v 0 0 0\n", "v 1 2 3\n", "f 1 2 3\n")),
        ("faces", repeated("v 0 0 0\n", "f 1 1 1\n", "")),
        ("corners", repeated("v 0 0 0\nf", " 1", "\n")),
        ("materials", repeated("v 0 0 0\n", "usemtl a\nf 1 1 1\no b\n", "")),
        ("long material", repeated(&format!("v 0 0 0\nusemtl {}\n", "n".repeat(50_000)), "o\nf 1 1 1\n", "")),
        ("trims", repeated(&curve(10_000), " 0 1 1", "\nend\n")),
        (
            "facets",
            repeated(
                "solid\n",
                "facet normal 0 0 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n",
                "endsolid",
            ),
        ),
    ]
}

/// Many materials that show a picture with a long name.
fn pictures() -> String {
    let name = "n".repeat(300_000);
    let list = |part: &dyn Fn(usize) -> String| (0..3000).map(part).collect::<Vec<_>>().join(",");
    let materials = list(&|_| "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}".to_owned());
    let primitives = list(&|i| format!("{{\"attributes\":{{\"POSITION\":2}},\"material\":{i}}}"));
    format!(
        "\"nodes\":[{{\"mesh\":0}}],\"textures\":[{{\"source\":0}}],\"images\":[{{\"uri\":\"data:;base64,UDIKMSAxCjI1NQo3Cg==\",\"name\":\"{name}\"}}],\
         \"materials\":[{materials}],\"meshes\":[{{\"primitives\":[{primitives}]}}]"
    )
}

/// A trimming curve of so many points, and the beginning of a list of its uses.
fn curve(points: usize) -> String {
    format!(
        "v 0 0 0\nvp 0 0\ncstype bspline\ndeg 1 1\ncurv2{}\nparm u{} 1 1\nend\nsurf 0 1 0 1 1 1 1 1\nparm u 0 0 1 1\nparm v 0 0 1 1\ntrim",
        " 1".repeat(points),
        " 0".repeat(points)
    )
}

/// Many copies of a node with a name of this length, which share their places.
fn instances(name: usize) -> String {
    let (name, data) = ("n".repeat(name), "A".repeat(100_000));
    let node = format!(
        "{{\"name\":\"{name}\",\"mesh\":0,\"extensions\":{{\"EXT_mesh_gpu_instancing\":{{\"attributes\":{{\"TRANSLATION\":1}}}}}}}},"
    );
    format!(
        "\"buffers\":[{{\"byteLength\":75000,\"uri\":\"data:;base64,{data}\"}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":75000}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}},\
         {{\"componentType\":5126,\"count\":6250,\"type\":\"VEC3\"}}],\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}],\
         \"nodes\":[{}{{}}]",
        node.repeat(if name.len() > 100 { 1 } else { 20 })
    )
}

#[test]
fn memory_is_in_proportion_to_the_size_of_files() {
    for (name, text) in cases() {
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        drop(load_str("m", &text, &Options::default()));
        let peak = ALLOCATOR.peak_usage() - before;
        let [factor, constant] = LIMIT;
        assert!(peak <= factor * text.len() + constant, "{name}: {peak} bytes for {} bytes", text.len());
    }
}
