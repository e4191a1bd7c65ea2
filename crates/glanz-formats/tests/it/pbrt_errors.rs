//! Bad scenes, each with the place and the message it must get.

use glanz_formats::{Options, load_str};

/// The first error's `line:column: message`.
fn error(text: &str) -> String {
    let errors = load_str("bad.pbrt", text, &Options::default()).expect_err(text);
    let first = errors.iter().find(|d| d.severity == glanz_formats::Severity::Error).unwrap();
    let location = first.location.unwrap();
    format!("{}:{}: {}", location.line, location.column, first.message)
}

#[test]
fn every_error_has_a_position() {
    let table = [
        // Words
        ("Sphere", "1:1: \"Sphere\" is no directive"),
        ("WorldBegin\n  shape \"sphere\"", "2:3: \"shape\" is no directive"),
        ("WorldBegin \"sphere\"", "1:12: a directive is expected, such as Shape or Translate"),
        ("WorldBegin 3", "1:12: \"3\" is no directive"),
        ("WorldBegin [", "1:12: a directive is expected, such as Shape or Translate"),
        ("WorldBegin Shape sphere", "1:18: Shape needs a name in quotes"),
        ("WorldBegin Shape", "1:12: Shape needs a name in quotes"),
        ("WorldBegin Shape \"sphere", "1:18: text without a closing quote"),
        ("WorldBegin Texture \"a\" \"color\"", "1:12: Texture needs a name in quotes"),
        // Numbers
        ("Translate 1 2", "1:14: a number is missing at the end of the file"),
        ("Translate 1 2 x", "1:15: \"x\" is not a number"),
        ("Translate 1 2 Shape", "1:15: \"Shape\" is not a number"),
        ("Translate 1 nan 0", "1:13: \"nan\" is not a number"),
        ("Scale 1e999 1 1", "1:7: \"1e999\" is too large for a number"),
        ("Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0]", "1:41: a number is expected before the bracket closes"),
        (
            "Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 2]",
            "1:44: a closing bracket is expected after 16 numbers",
        ),
        ("Rotate 90 0 0 0", "1:1: Rotate needs an axis that is not zero"),
        ("LookAt 0 0 0 0 0 0 0 1 0", "1:1: LookAt: the eye is the target, or up is parallel to the view"),
        ("LookAt 0 0 0 0 1 0 0 1 0", "1:1: LookAt: the eye is the target, or up is parallel to the view"),
        (
            "Scale 1 1 0 Camera \"perspective\"",
            "1:13: the transformation before the camera cannot be inverted",
        ),
        ("ActiveTransform Now", "1:1: ActiveTransform needs StartTime, EndTime or All"),
        // Blocks
        ("WorldBegin WorldBegin", "1:12: WorldBegin, but the world has begun already"),
        ("WorldEnd", "1:1: WorldEnd without WorldBegin"),
        ("WorldBegin AttributeEnd", "1:12: AttributeEnd without AttributeBegin"),
        (
            "WorldBegin\nTransformBegin\nAttributeEnd",
            "3:1: AttributeEnd, but TransformBegin of line 2 is open",
        ),
        ("WorldBegin ObjectBegin \"a\" ObjectBegin \"b\"", "1:28: ObjectBegin within another object"),
        ("WorldBegin ObjectBegin \"a\" ObjectInstance \"a\" ObjectEnd", "1:43: there is no object \"a\""),
        ("WorldBegin ObjectInstance \"a\"", "1:27: there is no object \"a\""),
        ("CoordSysTransform \"camera\"", "1:19: there is no coordinate system \"camera\""),
        ("WorldBegin NamedMaterial \"red\"", "1:26: there is no material \"red\""),
        // Brightness
        (
            "WorldBegin LightSource \"point\" \"float lumens\" 9 \"float power\" 3",
            "1:47: light \"point\": \"power\" and \"lumens\" both set the brightness",
        ),
        (
            "WorldBegin AreaLightSource \"diffuse\" \"float nits\" 9 \"float candela\" 3",
            "1:51: area light \"diffuse\": \"candela\" and \"nits\" both set the brightness",
        ),
        (
            "WorldBegin AreaLightSource \"diffuse\" \"float lumens\" -9",
            "1:53: area light \"diffuse\": \"lumens\" is -9; it must not be negative",
        ),
        // Receivers
        (
            "WorldBegin\nShape \"disk\" \"string receiver\" \"desk\" \"integer cells\" 8",
            "2:55: shape \"disk\": parameter \"cells\" has 1 value; 2 are needed",
        ),
        (
            "WorldBegin\nShape \"disk\" \"string receiver\" \"desk\" \"integer cells\" [0 8]",
            "2:56: shape \"disk\": \"cells\" are 0 x 8, each must be from 1 to 4096",
        ),
        (
            "WorldBegin\nShape \"disk\" \"string receiver\" \"desk\" \"integer cells\" [8 4097]",
            "2:56: shape \"disk\": \"cells\" are 8 x 4097, each must be from 1 to 4096",
        ),
        (
            "WorldBegin\nShape \"disk\" \"string receiver\" \"desk\" \"string receiverside\" \"top\"",
            "2:61: shape \"disk\": receiverside \"top\" is unknown",
        ),
        (
            "WorldBegin\nObjectBegin \"a\"\nShape \"disk\" \"string receiver\" \"desk\"\nObjectEnd",
            "3:32: shape \"disk\": receiver \"desk\" is in an object, every copy of which would be the same receiver",
        ),
        (
            "WorldBegin\nShape \"disk\" \"string receiver\" \"desk\" \"string zone\" \"desk\"",
            "2:53: shape \"disk\": zone \"desk\" is unknown",
        ),
        ("WorldBegin\nObserver \"eye\" \"point3 P\" [0 0 1]", "2:1: observer \"eye\" is unknown"),
        ("WorldBegin\nObserver \"cylinder\"", "2:1: observer \"cylinder\" has no \"point3 P\""),
        (
            "WorldBegin\nObserver \"glare\" \"point3 P\" [0 0 1]",
            "2:1: observer \"glare\" has no \"vector3 view\"",
        ),
        (
            "WorldBegin\nObserver \"glare\" \"point3 P\" [0 0 1] \"vector3 view\" [0 0 2]",
            "2:53: observer \"glare\": view [0, 0, 2] in the world is vertical",
        ),
        ("Attribute \"sahpe\" \"float radius\" 1", "1:11: Attribute \"sahpe\" is unknown"),
        ("ColorSpace \"prophoto\"", "1:12: color space \"prophoto\" is unknown"),
        ("Include \"a.pbrt\"", "1:9: Include: file \"a.pbrt\" is not there"),
        // Options
        (
            "Camera \"perspective\" \"float fov\" 180",
            "1:1: camera: the field of view is 180 degrees; it must be between 0 and 180",
        ),
        (
            "Camera \"perspective\" \"float screenwindow\" [0 1 2]",
            "1:44: camera \"perspective\": parameter \"screenwindow\" has 3 values; 4 are needed",
        ),
        (
            "Film \"image\" \"integer xresolution\" 0",
            "1:36: film \"image\": \"xresolution\" is 0; it must be at least 1",
        ),
        ("Film \"image\" \"integer xresolution\" 2.5", "1:36: \"2.5\" is not an integer"),
        (
            "Film \"image\" \"float cropwindow\" [0 0 0 1]",
            "1:34: film: the part of the picture to render is empty",
        ),
        (
            "Sampler \"halton\" \"integer pixelsamples\" -1",
            "1:41: sampler \"halton\": \"pixelsamples\" is -1; it must be at least 1",
        ),
        (
            "Sampler \"stratified\" \"integer xsamples\" 65536 \"integer ysamples\" 65536",
            "1:41: sampler: xsamples times ysamples is too large",
        ),
        ("PixelFilter \"box\" \"float xwidth\" 0", "1:34: filter: \"xwidth\" is 0; it must be positive"),
        (
            "PixelFilter \"gaussian\" \"float alpha\" -1",
            "1:1: filter \"gaussian\": the standard deviation must be positive",
        ),
        // Shapes
        (
            "WorldBegin Shape \"sphere\" \"string radius\" \"1\"",
            "1:27: shape \"sphere\": parameter \"radius\" is of type string",
        ),
        (
            "WorldBegin Shape \"sphere\" \"float radius\" [1 2]",
            "1:43: shape \"sphere\": parameter \"radius\" has 2 values; 1 is needed",
        ),
        (
            "WorldBegin Shape \"sphere\" \"float radius\" []",
            "1:27: shape \"sphere\": parameter \"radius\" has 0 values; 1 is needed",
        ),
        ("WorldBegin Shape \"trianglemesh\"", "1:12: shape \"trianglemesh\" has no points \"P\""),
        (
            "WorldBegin Shape \"trianglemesh\" \"point P\" [0 0 0 1]",
            "1:44: shape \"trianglemesh\": parameter \"P\" has 4 values; a multiple of 3 is needed",
        ),
        (
            "WorldBegin Shape \"trianglemesh\" \"point P\" [0 0 0]",
            "1:33: shape \"trianglemesh\" has 1 points and no \"indices\"",
        ),
        (
            "WorldBegin Shape \"trianglemesh\" \"point P\" [0 0 0] \"integer indices\" [0 0]",
            "1:70: shape \"trianglemesh\": parameter \"indices\" has 2 values; a multiple of 3 is needed",
        ),
        (
            "WorldBegin Shape \"trianglemesh\" \"point P\" [0 0 0] \"integer indices\" [0 0 1]",
            "1:70: shape \"trianglemesh\": face 0 refers to point 1; there are 1",
        ),
        (
            "WorldBegin Shape \"bilinearmesh\" \"point P\" [0 0 0] \"integer indices\" [0 0 0 -1]",
            "1:70: shape \"bilinearmesh\": face 0 refers to point -1; there are 1",
        ),
        ("WorldBegin Shape \"plymesh\"", "1:12: shape \"plymesh\" has no \"string filename\""),
        (
            "WorldBegin Shape \"plymesh\" \"string filename\" \"a.ply\"",
            "1:46: shape \"plymesh\": file \"a.ply\" is not there",
        ),
        (
            "WorldBegin Shape \"algebraic\"",
            "1:12: shape \"algebraic\" needs \"integer exponents\" and \"float coefficients\"",
        ),
        (
            "WorldBegin Shape \"algebraic\" \"integer exponents\" [5 0 0] \"float coefficients\" 1",
            "1:51: shape \"algebraic\": the term with exponents 5 0 0 is not of degree 0 to 4",
        ),
        (
            "WorldBegin Shape \"algebraic\" \"integer exponents\" [1 0] \"float coefficients\" 1",
            "1:51: shape \"algebraic\": 1 coefficients need 3 exponents; there are 2",
        ),
        (
            "WorldBegin Shape \"polyhedron\" \"normal N\" [1 0 0] \"float d\" [1 2]",
            "1:43: shape \"polyhedron\": there are 1 normals \"N\" and 2 offsets \"d\"",
        ),
        (
            "WorldBegin Shape \"box\" \"vector size\" [1 1 1] \"point min\" [0 0 0]",
            "1:39: shape \"box\": give either \"size\" or \"min\" and \"max\"",
        ),
        // Spectra and textures
        (
            "WorldBegin Material \"matte\" \"rgb Kd\" [1 1]",
            "1:39: material \"matte\": parameter \"Kd\" has 2 values; 3 are needed",
        ),
        (
            "WorldBegin Material \"matte\" \"rgb Kd\" [1 -1 1]",
            "1:39: material \"matte\": parameter \"Kd\" has a negative component",
        ),
        (
            "WorldBegin Material \"matte\" \"string Kd\" \"red\"",
            "1:41: material \"matte\": parameter \"Kd\" is not a spectrum",
        ),
        (
            "WorldBegin Material \"matte\" \"texture Kd\" \"wood\"",
            "1:42: material \"matte\": parameter \"Kd\": there is no texture \"wood\"",
        ),
        (
            "WorldBegin Material \"matte\" \"spectrum Kd\" [400 1 500]",
            "1:44: material \"matte\": parameter \"Kd\" has 3 values; pairs of wavelength and value are needed",
        ),
        (
            "WorldBegin Material \"matte\" \"spectrum Kd\" [400 1 400 2]",
            "1:44: material \"matte\": parameter \"Kd\" is not a spectrum: sample 1 of a spectrum is at 400 nm, the one before at 400 nm; wavelengths must ascend",
        ),
        (
            "WorldBegin Material \"matte\" \"spectrum Kd\" \"red.spd\"",
            "1:43: material \"matte\": parameter \"Kd\": spectrum file \"red.spd\" is not there",
        ),
        (
            "WorldBegin LightSource \"point\" \"blackbody I\" [0]",
            "1:47: light \"point\": parameter \"I\" is not a spectrum: the temperature of a black body is 0 K; it must be positive and finite",
        ),
        (
            "WorldBegin LightSource \"point\" \"rgb I\" [0 0 0] \"float power\" 5",
            "1:62: light \"point\": a black light cannot have \"power\"",
        ),
        ("Texture \"t\" \"colour\" \"constant\"", "1:1: texture \"t\" has the type \"colour\""),
        (
            "Texture \"t\" \"color\" \"checkerboard\" \"integer dimension\" 4",
            "1:56: texture \"checkerboard\": \"dimension\" is 4; it must be 2 or 3",
        ),
        (
            "Texture \"t\" \"color\" \"checkerboard\" \"string mapping\" \"cubic\"",
            "1:53: texture \"checkerboard\": mapping \"cubic\" is unknown",
        ),
        ("Texture \"t\" \"color\" \"imagemap\"", "1:1: texture \"imagemap\" has no \"string filename\""),
        (
            "Scale 0 1 1 Texture \"t\" \"color\" \"checkerboard\" \"integer dimension\" 3",
            "1:13: texture \"checkerboard\": the transformation cannot be inverted",
        ),
        ("MakeNamedMaterial \"a\"", "1:1: material \"a\" has no \"string type\""),
        ("WorldBegin Material \"mix\"", "1:12: material \"mix\" does not name two materials"),
    ];
    let wrong: Vec<_> = table
        .iter()
        .map(|(text, expected)| (*text, error(text), *expected))
        .filter(|(_, found, expected)| found != expected)
        .collect();
    assert!(wrong.is_empty(), "text, found, expected: {wrong:#?}");
}

#[test]
fn an_error_shows_the_line_and_advises() {
    let text =
        "WorldBegin\nMakeNamedMaterial \"gold\" \"string type\" \"mirror\"\n\tNamedMaterial \"golf\"\n";
    let errors = load_str("room.pbrt", text, &Options::default()).unwrap_err();
    assert_eq!(
        errors.to_string(),
        "error: room.pbrt:3:16: there is no material \"golf\"\n  \
           3 |  NamedMaterial \"golf\"\n    \
             |                ^^^^^^\n  \
           help: did you mean \"gold\"?\n"
    );
}

#[test]
fn reading_goes_on_after_an_error_and_stops_at_twenty() {
    let text =
        "WorldBegin\nTranslate 1 x 2\nShape \"sphere\" \"float radius\" [y]\nRotate\nShape \"sphere\"\n";
    let errors = load_str("a.pbrt", text, &Options::default()).unwrap_err();
    let lines: Vec<u32> = errors.iter().map(|d| d.location.unwrap().line).collect();
    assert_eq!(lines, [2, 3, 5]);
    let nonsense = "Nonsense\n".repeat(1000);
    let errors = load_str("a.pbrt", &format!("WorldBegin\n{nonsense}"), &Options::default()).unwrap_err();
    assert_eq!(errors.iter().count(), 20);
    let errors = load_str("a.txt", &nonsense, &Options::default()).unwrap_err();
    assert_eq!(errors.iter().count(), 1, "it is no scene");
}

#[test]
fn a_thousand_equal_warnings_are_shown_a_hundred_times_and_counted() {
    let text = format!("WorldBegin\n{}", "Shape \"heightfield\"\n".repeat(1000));
    let loaded = load_str("a.pbrt", &text, &Options::default()).unwrap();
    assert_eq!(loaded.diagnostics.iter().count(), 100);
    assert_eq!(loaded.diagnostics.count(glanz_formats::Severity::Warning), 1000);
}

#[test]
fn parameters_are_limited_and_unused_ones_counted() {
    let shape = |n: usize| format!("WorldBegin Shape \"sphere\"{}", "\n\"float alpah\" 1".repeat(n));
    assert_eq!(error(&shape(1025)), "1026:1: shape \"sphere\" has more than 1024 parameters");
    let loaded = load_str("a.pbrt", &shape(1024), &Options::default()).unwrap();
    assert_eq!(loaded.diagnostics.iter().count(), 100);
    assert!(
        loaded
            .diagnostics
            .to_string()
            .ends_with("warning: 924 more of the kind \"unused-parameter\" are not shown\n")
    );
}

#[test]
fn blocks_nest_up_to_a_limit() {
    let text = format!("WorldBegin {}", "AttributeBegin\n".repeat(300));
    assert!(error(&text).ends_with("AttributeBegin is nested more than 256 deep"));
}
