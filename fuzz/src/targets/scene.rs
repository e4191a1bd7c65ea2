//! Scenes: their language, and what is made of them.

use glanz::formats::pbrt::rewrite;
use glanz::formats::{Loaded, Options, load_str};
use glanz::scene::Description;
use glanz::scene::description::{GeometryDescription, GroupDescription, TrimDescription};
use glanz::{Error, JobOptions, LoadedScene, Picture, RenderOptions};

use super::{ReadOutcome, Target, loaded, with_file, with_folder};
use crate::limits;
use crate::mutation::Syntax;

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "pbrt",
        syntax: WORDS,
        seeds: || texts(SCENES),
        run: read,
        memory_factor: 1000,
        divisor: 1,
    },
    Target {
        name: "rewrite",
        syntax: Syntax::Text(&[
            "\"string free\" \"P\"",
            "\"float freerange\" [ -1 1 ]",
            "\"integer freegroups\" [ 0 1 ]",
            "Include",
            "#",
            "ä",
            "[",
            "]",
        ]),
        seeds: || texts(&[DESIGN, include_str!("../../../scenes/design/even_rectangle.pbrt")]),
        run: rewritten,
        memory_factor: 1000,
        divisor: 1,
    },
    Target {
        name: "spectrum",
        syntax: Syntax::Text(NUMBERS),
        seeds: || texts(&["# a spectrum\n400 0.1\n500 .5\n600 1 # the largest\n700 0\n"]),
        run: |bytes| {
            of_file(
                bytes,
                "WorldBegin Material \"diffuse\" \"spectrum reflectance\" \"file\" Shape \"sphere\"",
            )
        },
        memory_factor: 1000,
        divisor: 1,
    },
    Target {
        name: "lens",
        syntax: Syntax::Text(NUMBERS),
        seeds: || {
            texts(&[
                "# a lens\n35.98738 1.21638 1.54 23.716\n11.69718 9.9957 1 17.996\n0 1 0 10\n13.08714 5.12622 1.77 12.364\n-22.63294 1.76924 1.617 9.812\n",
            ])
        },
        run: |bytes| of_file(bytes, "Camera \"realistic\" \"string lensfile\" \"file\" WorldBegin"),
        memory_factor: 1000,
        divisor: 1,
    },
    Target {
        name: "resolve",
        syntax: WORDS,
        seeds: whole_scenes,
        run: resolved,
        memory_factor: 20_000,
        divisor: 10,
    },
    Target {
        name: "render",
        syntax: WORDS,
        seeds: whole_scenes,
        run: rendered,
        memory_factor: 20_000,
        divisor: 100,
    },
    Target {
        name: "resume",
        syntax: WORDS,
        seeds: whole_scenes,
        run: resumed,
        memory_factor: 20_000,
        divisor: 200,
    },
];

const NUMBERS: &[&str] = &["#", "\n", "380 1\n", "0 0 0 1\n", "[", "\"", "1,2", "\0"];

const WORDS: Syntax = Syntax::Text(&[
    "AttributeBegin",
    "AttributeEnd",
    "WorldBegin",
    "WorldEnd",
    "ObjectBegin \"o\"",
    "ObjectEnd",
    "ObjectInstance \"o\"",
    "Include \"x\"",
    "\"",
    "[",
    "]",
    "#",
    "\\",
    "\n",
    "\0",
    "[ ]",
    "\"float radius\"",
    "\"texture Kd\" \"c\"",
    "Transform [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0]",
    "Identity",
    "\"integer indices\" [4294967295]",
    "Shape \"sphere\"",
    "Shape \"loopsubdiv\" \"integer levels\" 3",
    "Material \"glass\"",
    "LightSource \"infinite\"",
    "true",
]);

/// Scenes in which most words of the language occur.
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

/// A scene with free numbers.
const DESIGN: &str = r#"# a bent mirror ä
WorldBegin AreaLightSource "diffuse" "float lumens" 1000
Shape "sphere" "float radius" .5 "string free" "radius" "float freerange" [ -.1 .2 ]
Shape "bezierpatch" "integer udegree" 1 "integer vdegree" 2 "string free" "P" "integer freegroups" [ 0 -1 0 7 7 -1 ]
    "point3 P" [ 0 0 0 1 0 0 2 0 0
    0 1 0 1 1 0 2 1 0 ] # the end
"#;

/// A scene for renders: media, textures, spectra, solids, trims, instances, curves and lights of all sizes.
const RENDERED: &[&str] = &[
    r#"MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [.07 .075 .08] "rgb sigma_a" [.01 .01 .01] "float g" .4
    LookAt 0 -5 1.5  0 0 1  0 0 1 MediumInterface "fog" Camera "perspective" "float fov" 50 Integrator "volpath" "integer maxdepth" 8
    Film "rgb" "integer xresolution" 6 "integer yresolution" 4 WorldBegin
    Texture "c" "spectrum" "checkerboard" "rgb tex1" [.8 .1 .1] "rgb tex2" [.1 .1 .8] "float uscale" 4 Material "diffuse" "texture reflectance" "c"
    Shape "bilinearmesh" "point3 P" [-3 -6 0 3 -6 0 -3 2 0 3 2 0]
    LightSource "spot" "point3 from" [-2.9 -.3 3.8] "point3 to" [1.1 .2 .9] "rgb I" [420 400 360] "float coneangle" 20
    AttributeBegin AreaLightSource "diffuse" "rgb L" [5 5.5 6.5] Translate 0 -1 3.9 Rotate 180 1 0 0 Shape "disk" "float radius" .8 AttributeEnd
    MakeNamedMedium "smoke" "string type" "uniformgrid" "rgb sigma_s" [9 9 9] "rgb sigma_a" [.3 .4 .5] "integer nx" 2 "integer ny" 2
    "integer nz" 1 "float density" [0 1 .5 2]
    AttributeBegin Translate -1 -.9 .5 Material "interface" MediumInterface "smoke" "fog" Shape "sphere" "float radius" .5 AttributeEnd
    AttributeBegin Translate 1 0 .5 Material "dielectric" "float eta" 1.5 Shape "sphere" "float radius" .5 AttributeEnd"#,
    r#"LookAt 0 0 -4  0 0 0  0 1 0 Camera "perspective" "float fov" 45 Film "rgb" "integer xresolution" 6 "integer yresolution" 4 WorldBegin
    LightSource "infinite" "rgb L" [.4 .5 .6] LightSource "distant" "point3 from" [1 2 -3] "rgb L" [2 2 2]
    ObjectBegin "o" Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "float roughness" .2
    Shape "nurbs" "integer nu" 2 "integer nv" 3 "integer uorder" 2 "integer vorder" 3 "float uknots" [0 0 1 1] "float vknots" [0 0 0 1 1 1]
    "point3 P" [-1 -1 0 1 -1 0 -1 0 .5 1 0 .5 -1 1 0 1 1 0] "float trimellipse" [.5 .5 .2 .3] "string trimside" "outside" ObjectEnd
    ObjectInstance "o" Translate 1 0 1 Rotate 30 0 1 0 Scale 1 .5 1 ObjectInstance "o"
    Material "coateddiffuse" "float roughness" .1 Shape "torus" "float majorradius" 1 "float minorradius" .2
    Shape "trianglemesh" "integer indices" [0 1 2 2 1 3] "point3 P" [-2 -1 1 2 -1 1 -2 1 2 2 1 2] "point2 uv" [0 0 1 0 0 1 1 1]
    Shape "curve" "point3 P" [-1 0 -.5 0 1 -.5 0 -1 -.5 1 0 -.5] "float width" .05
    Shape "algebraic" "integer exponents" [2 0 0 0 2 0 0 0 2 0 0 0] "float coefficients" [1 2 3 -.3]
    Material "diffuse" Translate 0 1 0 Shape "loopsubdiv" "integer levels" 2 "integer indices" [0 1 2 0 2 3 0 3 1 1 3 2]
    "point3 P" [0 0 0 1 0 0 0 1 0 0 0 1]"#,
    include_str!("../../../scenes/prism.pbrt"),
    include_str!("../../../scenes/lens.pbrt"),
    include_str!("../../../scenes/caustic.pbrt"),
    include_str!("../../../scenes/demo.pbrt"),
];

fn texts(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| text.as_bytes().to_vec()).collect()
}

fn whole_scenes() -> Vec<Vec<u8>> {
    texts(RENDERED)
}

/// Options under which a scene finds no files but those of its case.
fn options(strict: bool) -> Options {
    let folder = with_folder(std::path::Path::to_owned);
    Options {
        strict,
        folder: Some(folder),
        confined: true,
        limits: limits::of_reading(),
        ..Options::default()
    }
}

fn read(bytes: &[u8]) -> ReadOutcome {
    let text = String::from_utf8_lossy(bytes);
    let with = |strict| loaded(load_str("mutant", &text, &options(strict)), text.len());
    // Some also with every repair an error.
    if bytes.len().is_multiple_of(5) {
        with(true);
    }
    with(false)
}

/// A scene of this text, which refers to a file of these bytes.
fn of_file(bytes: &[u8], scene: &str) -> ReadOutcome {
    with_file("file", bytes, |_| {
        let result = load_str("scene", scene, &options(true));
        loaded(result, scene.len() + bytes.len())
    })
}

/// A file with its numbers where they were is the file; with others it is read, and has as many of them.
fn rewritten(bytes: &[u8]) -> ReadOutcome {
    let text = String::from_utf8_lossy(bytes);
    let result = load_str("mutant", &text, &options(false));
    if let Ok(Loaded { description, sources, .. }) = &result {
        let variables = &description.design.variables;
        let same = rewrite(sources, variables, &vec![0.0; variables.len()]);
        // Numbers of included files are refused.
        if let Ok(same) = same {
            assert!(
                variables.is_empty() || same == text.as_bytes(),
                "nothing is displaced, and the file differs"
            );
        }
        if let Ok(other) = rewrite(sources, variables, &vec![1e-3; variables.len()]) {
            let other = String::from_utf8_lossy(&other).into_owned();
            if let Ok(again) = load_str("rewritten", &other, &options(false)) {
                assert_eq!(again.description.design.variables.len(), variables.len());
            }
        }
    }
    loaded(result, text.len())
}

fn opened(bytes: &[u8]) -> Result<LoadedScene, Error> {
    glanz::open_str("mutant", &String::from_utf8_lossy(bytes), &options(false))
}

fn resolved(bytes: &[u8]) -> ReadOutcome {
    opened(bytes).and_then(LoadedScene::resolve).into()
}

/// Numbers of pixels and samples of a picture.
#[derive(Clone, Copy)]
struct PictureSize {
    /// Width, pixels.
    width: u32,
    /// Height, pixels.
    height: u32,
    /// Samples of each pixel.
    samples: u32,
}

fn picture(
    scene: LoadedScene,
    PictureSize { width, height, samples }: PictureSize,
    range: Option<std::ops::Range<u32>>,
    job: JobOptions<'_>,
) -> Result<Picture, Error> {
    let options = RenderOptions {
        integrator: Some("path".to_owned()),
        size: Some([width, height]),
        samples: Some(samples),
        sample_range: range,
        ..RenderOptions::default()
    };
    scene.render().options(options).job(job.threads(1)).run()
}

/// All samples are counted, and no pixel is infinite or not a number.
fn rendered(bytes: &[u8]) -> ReadOutcome {
    let size = PictureSize { width: 6, height: 4, samples: 4 };
    let result = opened(bytes).and_then(|scene| picture(scene, size, None, JobOptions::default()));
    if let Ok(picture) = &result {
        let film = picture.film();
        let pixels: u64 = film.format().crop.size.iter().map(|side| u64::from(*side)).product();
        assert_eq!(picture.statistics().samples, pixels * u64::from(size.samples), "samples are lost");
        assert!(film.rejects().dropped <= picture.statistics().samples, "{:?}", film.rejects());
        if let Ok(planes) = picture.pixels() {
            let values = planes.channels().iter().flat_map(|channel| &channel.values);
            assert!(values.clone().all(|value| value.is_finite()), "a pixel is not finite");
            assert_eq!(values.count() as u64, pixels * planes.channels().len() as u64);
        }
    }
    result.into()
}

/// A sample, a checkpoint and a sample have the bits of two samples.
fn resumed(bytes: &[u8]) -> ReadOutcome {
    let size = PictureSize { width: 2, height: 2, samples: 2 };
    let result = opened(bytes).and_then(|scene| {
        let whole = picture(scene.clone(), size, None, JobOptions::default())?;
        with_folder(|folder| {
            let path = folder.join("film.checkpoint");
            let _ = std::fs::remove_file(&path);
            let job = || JobOptions::default().checkpoint(path.clone()).resume(true);
            picture(scene.clone(), size, Some(0..1), job())?;
            let resumed = picture(scene, size, None, job())?;
            assert!(resumed.film() == whole.film(), "the resumed film differs");
            Ok(())
        })
    });
    result.into()
}

/// Everything a description holds, counted.
pub(super) fn size(d: &Description) -> usize {
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
