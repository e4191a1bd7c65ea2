//! Surfaces of the model against those of the scene.

use glanz_math::{DMat3, DVec2, DVec3};

use super::*;

/// Parameters of a patch, decoded from its words, over the region if there is one.
fn parameters(words: &[u32], revolution: bool, x: f64, y: f64) -> DVec2 {
    let w: Vec<f64> = words.iter().map(|&word| f32::from_bits(word).into()).collect();
    if !revolution {
        let corner = |k: usize| DVec2::new(w[4 + 2 * k], w[5 + 2 * k]);
        return corner(0).lerp(corner(1), x).lerp(corner(2).lerp(corner(3), x), y);
    }
    let share = |x: f64, a: f64, k: f64| {
        let middle = |c: f64| ((1.0 - x) * (1.0 - x) + x * x) * c + 2.0 * x * (1.0 - x);
        if a > 0.0 {
            0.5 * (1.0 + ((2.0 * x - 1.0) * a.sin()).atan2(middle(a.cos())) / a)
        } else if a < 0.0 {
            0.5 * (1.0 - ((2.0 * x - 1.0) * (-a).sinh() / middle(a.cosh())).atanh() / a)
        } else {
            x + k * x * (x - 1.0)
        }
    };
    DVec2::new(w[4] + (w[5] - w[4]) * share(x, w[8], 0.0), w[6] + (w[7] - w[6]) * share(y, w[9], w[10]))
}

fn bernstein(degree: usize, t: f64) -> Vec<f64> {
    let mut row = vec![1.0];
    for _ in 0..degree {
        let mut next = vec![0.0; row.len() + 1];
        for (i, b) in row.iter().enumerate() {
            next[i] += b * (1.0 - t);
            next[i + 1] += b * t;
        }
        row = next;
    }
    row
}

/// The point of a patch relative to the surface's origin.
fn point(words: &[u32], points: &[f64], x: f64, y: f64) -> DVec3 {
    let (p, q) = ((words[0] & 0xff) as usize, (words[0] >> 8 & 0xff) as usize);
    let (a, b) = (bernstein(p, x), bernstein(q, y));
    let mut sum = [0.0; 4];
    for (i, j) in (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j))) {
        let at = 4 * (words[1] as usize + i * (q + 1) + j);
        let weight = points[at + 3];
        assert!(words[0] >> 16 == 1 || weight == 1.0);
        sum.iter_mut().zip(&points[at..at + 4]).for_each(|(s, c)| *s += a[i] * b[j] * c);
    }
    DVec3::new(sum[0], sum[1], sum[2]) / sum[3]
}

fn to_world(object: &Value) -> (DMat3, DVec3) {
    let m = numbers(&object["toWorld"]);
    let columns: Vec<DVec3> = m.chunks(3).map(DVec3::from_slice).collect();
    (DMat3::from_cols(columns[0], columns[1], columns[2]), columns[3])
}

/// Every patch of the scene against the placed surface, and how many there are.
fn assert_patches(text: &str, count: usize) -> File {
    let (_, file, scene) = model(text);
    let (patches, points) = (file.words("patches"), file.floats("points"));
    let placed = scene.placed_surfaces();
    assert_eq!(file.list("objects").len(), placed.len());
    let mut found = 0;
    for (object, placed) in file.list("objects").iter().zip(&placed) {
        let surface = &file.list("surfaces")[number(&object["surface"])];
        assert_eq!(surface["kind"], "patches");
        let (matrix, origin) = to_world(object);
        let scale = placed.bounds().diagonal().length();
        let revolution = surface["mapping"] == "revolution";
        let region = surface["region"].as_u64().map(|r| &file.list("regions")[r as usize]);
        let corner = |name: &str| region.map(|r| numbers(&r[name]));
        let (min, max) = (corner("min").unwrap_or(vec![0.0; 2]), corner("max").unwrap_or(vec![1.0; 2]));
        let (min, max) = (DVec2::from_slice(&min), DVec2::from_slice(&max));
        let first = number(&surface["first"]);
        for words in patches.chunks(16).skip(first).take(number(&surface["count"])) {
            found += 1;
            for (i, j) in (1..8).flat_map(|i| (1..8).map(move |j| (i, j))) {
                let (x, y) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                let uv = min + parameters(words, revolution, x, y) * (max - min);
                let here = matrix * point(words, &points, x, y) + origin;
                // Faces of a freeform surface have parameters of their own, those of the patch.
                let freeform = matches!(placed.surface(), glanz_geometry::Surface::Freeform(_));
                let at = if freeform { DVec2::new(x, y) } else { uv };
                let Some(there) = placed.at(words[2], at, false) else { continue };
                // Single precision, of numbers relative to the origin.
                let apart = here.distance(there.at.point.position);
                assert!(apart < 1e-6 * scale, "{}: {apart}", object["kind"]);
                assert!(uv.distance(there.at.point.uv) < 1e-5 * (1.0 + uv.length()), "{}", object["kind"]);
            }
        }
    }
    assert_eq!(found, count);
    file
}

#[test]
fn patches_are_the_surfaces_where_they_stand() {
    let text = r#"
        WorldBegin
        Translate 100 -3 5  Rotate 30 1 2 3  Scale 1 2 -0.5
        Shape "sphere" "float radius" 2 "float zmin" -1
        Shape "cylinder" "float phimax" 200
        Shape "paraboloid" "float zmin" 0.2
        Shape "hyperboloid" "point3 p1" [1 0 0] "point3 p2" [0 2 1]
        Shape "twosheetedhyperboloid" "float c" 0.5
        Shape "disk" "float innerradius" 0.3
        Shape "torus"
        Shape "plane" "float x" [-1 3] "float y" [0 2]
        Shape "bilinearmesh" "point3 P" [0 0 0  1 0 0  0 1 0  1 1 0.5]
        Shape "box" "point3 min" [0 0 0] "point3 max" [1 2 3]
        Shape "nurbs" "integer nu" 4 "integer nv" 3 "integer uorder" 3 "integer vorder" 2
            "float uknots" [0 0 0 2 5 5 5] "float vknots" [-1 -1 0 1 1]
            "point3 P" [0 0 0 1 0 1 2 0 1 3 0 0  0 1 1 1 1 2 2 1 2 3 1 1  0 2 0 1 2 0 2 2 1 3 2 1]
            "float weights" [1 2 1 1  1 1 1 1  1 1 1 0.5]
        Shape "beziertriangle" "integer degree" 2
            "point3 P" [0 0 0  1 0 1  0 1 1  2 0 0  1 1 2  0 2 0]"#;
    // Sphere zone of 120 degrees, cylinder of two arcs, two sheets, 4 x 4 of the torus, 6 sides of the box; 2 x 2 pieces of the spline, 3 of the triangle.
    assert_patches(text, 4 + 2 + 4 + 4 + 2 * 4 + 4 + 16 + 1 + 1 + 6 + 4 + 3);
}

#[test]
fn trimmed_patches_have_the_parameters_of_their_region() {
    let hole = r#""float trimellipse" [.5 .5 .2 .3]"#;
    let kinds = ["sphere", "paraboloid", "twosheetedhyperboloid", "torus", "bilinearmesh"];
    let shape = |kind: &&str| {
        let corners =
            if *kind == "bilinearmesh" { r#""point3 P" [0 0 0  1 0 0  0 1 0  1 1 0.5]"# } else { "" };
        format!("Shape \"{kind}\" {corners} {hole}\n")
    };
    let text = format!("WorldBegin\n{}", kinds.iter().map(shape).collect::<String>());
    let file = assert_patches(&text, 8 + 4 + 8 + 16 + 1);
    assert_eq!(file.list("regions").len(), 5);
    assert!(file.list("notes").is_empty());
}

#[test]
fn copies_share_their_surface() {
    let text = r#"
        WorldBegin
        ObjectBegin "ball"  Shape "sphere"  Shape "box"  ObjectEnd
        ObjectInstance "ball"  Translate 3 0 0  ObjectInstance "ball""#;
    let (_, file, _) = model(text);
    assert_eq!(file.list("surfaces").len(), 2);
    let of_object: Vec<usize> = file.list("objects").iter().map(|o| number(&o["surface"])).collect();
    assert_eq!(of_object, [0, 1, 0, 1]);
    assert!(to_world(&file.list("objects")[2]).1.distance(DVec3::X * 3.0) < 1e-12);
}

#[test]
fn a_bicubic_patch_costs_320_bytes() {
    // Sixteen points of four numbers, and a row of sixteen numbers.
    let net: String = (0..16).map(|i| format!("{} {} {} ", i % 4, i / 4, (i * i) % 3)).collect();
    let patch = format!("Shape \"bezierpatch\" \"point3 P\" [{net}]\n");
    let size = |count: usize| {
        let (_, file, _) = model(&format!("WorldBegin\n{}", patch.repeat(count)));
        file.blocks.len()
    };
    assert_eq!(size(11) - size(1), 10 * 320);
}

#[test]
fn triangles_are_those_of_the_scene() {
    let text = r#"
        WorldBegin
        Translate 1 2 3
        Shape "polyhedron" "normal N" [ -1 0 0  0 -1 0  1 1 0  0 0 -1  0 0 1 ] "float d" [ 0 0 1 0 2 ]
        Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  1 1 0  0 1 1] "integer indices" [0 1 2  0 2 3]
        Shape "trianglemesh" "point3 P" [5 0 0  6 0 0  6 1 0] "normal N" [0 0 1  0 1 1  1 0 1]
        Shape "trianglemesh" "point3 P" [7 0 0  8 0 0  8 1 0]"#;
    let (_, file, _) = model(text);
    let (positions, normals) = (file.floats("positions"), file.floats("normals"));
    let indices = file.words("indices");
    // Triangles, vertices and area; flat facets have vertices of their own. The two meshes without normals are one surface of the scene.
    let expected = [
        ("polyhedron", 8, 18, 2.0 * 0.5 + 2.0 * (2.0 + 2.0_f64.sqrt())),
        ("trianglemesh", 2, 6, 0.5 + 0.5 * 3.0_f64.sqrt()),
        ("trianglemesh", 1, 3, 0.5),
        ("trianglemesh", 1, 3, 0.5),
    ];
    let objects = file.list("objects");
    assert_eq!(objects.len(), expected.len());
    for (object, (kind, triangles, vertices, area)) in objects.iter().zip(expected) {
        let surface = &file.list("surfaces")[number(&object["surface"])];
        assert_eq!((object["kind"].as_str(), number(&surface["vertices"])), (Some(kind), vertices));
        let (matrix, origin) = to_world(object);
        let vertex = |list: &[f64], k: u32| {
            let k = 3 * (number(&surface["firstVertex"]) + k as usize);
            DVec3::from_slice(&list[k..k + 3])
        };
        let first = number(&surface["firstIndex"]);
        let own = &indices[first..first + number(&surface["indices"])];
        assert_eq!(own.len(), 3 * triangles);
        let mut sum = 0.0;
        for corners in own.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| matrix * vertex(&positions, corners[k]) + origin);
            let twice = (b - a).cross(c - a);
            sum += 0.5 * twice.length();
            assert!(corners.iter().all(|&k| vertex(&normals, k).dot(twice) > 0.5 * twice.length()), "{kind}");
        }
        assert!((sum - area).abs() < 1e-5 * area, "{kind}: {sum} {area}");
    }
}

#[test]
fn polynomials_vanish_where_rays_meet_the_surface() {
    let text = r#"
        LookAt 0 -30 0  0 0 0  0 0 1
        WorldBegin
        Translate 0 3 1  Scale 2 2 2
        Shape "algebraic" "integer exponents" [ 4 0 0  0 4 0  0 0 4  0 0 0 ]
            "float coefficients" [ 1 1 1 -1 ] "point3 clip" [ -1.1 -1.2 -1.1  1.1 1.1 1.1 ]"#;
    let (_, file, scene) = model(text);
    let surface = &file.list("surfaces")[0];
    let (matrix, origin) = to_world(&file.list("objects")[0]);
    for (x, z) in [(0.0, 1.0), (0.5, 2.0), (-1.2, 0.3)] {
        let ray = glanz_math::Ray::new(DVec3::new(x, -30.0, z), DVec3::Y);
        let at = scene.intersect(&ray, f64::INFINITY).unwrap().point.position;
        let own = matrix.inverse() * (at - origin);
        assert!(own.cmple(DVec3::from_slice(&numbers(&surface["max"]))).all());
        assert!(own.cmpge(DVec3::from_slice(&numbers(&surface["min"]))).all());
        let terms = surface["terms"].as_array().unwrap();
        let sum: f64 = terms
            .iter()
            .map(numbers)
            .map(|t| t[3] * own.x.powf(t[0]) * own.y.powf(t[1]) * own.z.powf(t[2]))
            .sum();
        assert!(sum.abs() < 1e-12, "{sum}");
    }
}

#[test]
fn substitutes_in_the_model_are_noted() {
    let text = r#"
        WorldBegin
        Shape "sphere"
        Shape "polyhedron" "normal N" [ -1 0 0  0 -1 0  1 1 0  0 0 -1  0 0 1 ] "float d" [ 1 1 1 1 1 ]
            "float trimellipse" [.5 .5 .2 .3]
        Shape "plane" "float x" [-2 2]"#;
    let (_, file, _) = model(text);
    let notes: Vec<&str> = file.list("notes").iter().map(|note| note.as_str().unwrap()).collect();
    assert_eq!(
        notes,
        [
            "a trimmed polyhedron is drawn without its trimming",
            "an unbounded plane is drawn as a large rectangle"
        ]
    );
    // Sphere and prism are 2 to 4 m across; the strip reaches a thousand times as far, but not beyond its sides.
    let surface = file.list("surfaces").iter().find(|s| s["mapping"] == "patch").unwrap();
    let points = file.floats("points");
    let first = file.words("patches")[16 * number(&surface["first"]) + 1] as usize;
    let corner = &points[4 * first..4 * first + 2];
    assert!(corner[0] == -2.0 && corner[1] < -2000.0 && corner[1] > -1e5, "{corner:?}");
    // Coordinates near the scene are small.
    assert_eq!(surface["count"], 3);
    let near = file.words("patches")[16 * (number(&surface["first"]) + 1) + 1] as usize;
    assert!((-100.0..-10.0).contains(&points[4 * near + 1]), "{}", points[4 * near + 1]);
}

#[test]
fn faces_that_are_small_parts_of_their_surface_have_patches_of_their_own() {
    // A hundredth of a millimetre out of a square of ten metres, and out of an unbounded plane; of the spline, in pieces of 2 m by 10 m, most is
    // left out.
    let net: String = (0..6 * 2).map(|k| format!("{} {} {} ", 2 * (k % 6), 10 * (k / 6), k % 2)).collect();
    let text = format!(
        r#"
        WorldBegin
        Shape "bilinearmesh" "point3 P" [0 0 0  10 0 0  0 10 0  10 10 0]
            "float trimellipse" [.25 .75 1e-6 1e-6] "string trimside" "inside"
        Shape "plane" "float trimellipse" [40 50 1e-5 1e-5] "string trimside" "inside"
        Shape "nurbs" "integer nu" 6 "integer nv" 2 "integer uorder" 2 "integer vorder" 2
            "float uknots" [0 0 1 2 3 4 5 5] "float vknots" [0 0 1 1] "point3 P" [{net}]
            "float trimellipse" [2.5 .5 .1 .1] "string trimside" "inside""#
    );
    let (_, file, scene) = model(&text);
    assert!(file.list("notes").is_empty());
    let (patches, points) = (file.words("patches"), file.floats("points"));
    assert_eq!(patches.len(), 3 * 16);
    for object in file.list("objects") {
        let surface = &file.list("surfaces")[number(&object["surface"])];
        let words = &patches[16 * number(&surface["first"])..][..16];
        // The circle with a tenth of its width on each side is the region, and all of the patch.
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let corner = parameters(words, false, x, y);
            assert!(corner.distance(DVec2::new(x, y)) < 1e-5, "{object} {corner}");
        }
        let across = |x, y| point(words, &points, x, y).distance(point(words, &points, 0.0, 0.0));
        let (face, width, height) =
            if object["kind"] == "nurbs" { (2, 0.48_f64.hypot(0.24), 2.4) } else { (0, 2.4e-5, 2.4e-5) };
        assert_eq!(words[2], face);
        assert!((across(1.0, 0.0) - width).abs() < 1e-4 * width, "{object}");
        assert!((across(0.0, 1.0) - height).abs() < 1e-4 * height, "{object}");
        // The middle of the patch is that of the circle, and on the surface.
        let (matrix, origin) = to_world(object);
        let middle = matrix * point(words, &points, 0.5, 0.5) + origin;
        let ray = glanz_math::Ray::new(middle + DVec3::Z, -DVec3::Z);
        let met = scene.intersect(&ray, f64::INFINITY).unwrap().point;
        assert!(met.position.distance(middle) < 1e-6, "{object}");
    }
}

#[test]
fn a_curve_that_faces_every_ray_is_drawn_as_a_tube() {
    let text = r#"
        WorldBegin
        Shape "curve" "point3 P" [ 0 0 0  1 0 0  2 0 0  3 0 0 ] "float width0" 0.5 "float width1" 0.25"#;
    let (_, file, _) = model(text);
    let positions = file.floats("positions");
    let origin = numbers(&file.list("surfaces")[0]["origin"]);
    assert_eq!(positions.len(), 3 * 9 * 6);
    for point in positions.chunks_exact(3) {
        let [x, y, z] = [0, 1, 2].map(|k| point[k] + origin[k]);
        // Half the width, which falls by 1/12 per metre.
        assert!((y.hypot(z) - (0.25 - x / 24.0)).abs() < 1e-6, "{x} {y} {z}");
    }
    assert_eq!(file.words("indices").len(), 3 * 2 * 6 * 8);
    assert_eq!(file.head["notes"].as_array().unwrap().len(), 1);
}

#[test]
fn a_tube_along_x_has_its_width_whatever_the_length() {
    // 49 times 1/49 is not 1: the direction has a part across itself.
    let text = r#"
        WorldBegin
        Shape "curve" "point3 P" [ 0 0 0  49 0 0  98 0 0  147 0 0  196 0 0  245 0 0  294 0 0 ] "float width" 0.5"#;
    let (_, file, _) = model(text);
    let (positions, normals) = (file.floats("positions"), file.floats("normals"));
    let origin = numbers(&file.list("surfaces")[0]["origin"]);
    let at = |list: &[f64], index: usize| DVec3::from_slice(&list[3 * index..]);
    let point = |index: usize| at(&positions, index) + DVec3::from_slice(&origin);
    assert_eq!(positions.len(), 3 * 2 * 9 * 6);
    for ring in 0..2 * 9 {
        let middle = (6 * ring..6 * ring + 6).map(point).sum::<DVec3>() / 6.0;
        assert!(middle.truncate().with_x(middle.z).length() < 1e-6, "{middle}");
        for corner in 6 * ring..6 * ring + 6 {
            let outwards = point(corner) - middle;
            assert!((outwards.length() - 0.25).abs() < 1e-5 && outwards.x.abs() < 1e-4, "{outwards}");
            assert!(at(&normals, corner).distance(outwards / 0.25) < 1e-3, "{outwards}");
        }
    }
    // Triangles face outwards.
    for corners in file.words("indices").chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| point(corners[k] as usize));
        let middle = (a + b + c) / 3.0;
        assert!((b - a).cross(c - a).dot(middle.with_x(0.0)) > 0.0, "{corners:?}");
    }
}
