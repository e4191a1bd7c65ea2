//! The directives of pbrt's scene language.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use glanz_math::{DMat4, DVec3};

use crate::diagnostic::nearest;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::lexer::{LexError, Lexer, Token};
use crate::pbrt::lower::{Context, Lowering, finish_film};
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::pbrt::state::{GraphicsState, Level, MAX_NESTING, Saved, StateStack, look_at};
use crate::source::{Place, Reported, Step};

/// Files that include each other, one within the other.
pub(crate) const MAX_INCLUDE_DEPTH: usize = 32;
/// Files included in all.
pub(crate) const MAX_INCLUDES: usize = 65_536;

/// Every directive of the versions 1 to 4.
const DIRECTIVES: &[&str] = &[
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordinateSystem",
    "CoordSysTransform",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "Renderer",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "SearchPath",
    "Shape",
    "SurfaceIntegrator",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "Volume",
    "VolumeIntegrator",
    "WorldBegin",
    "WorldEnd",
];

/// A file being read.
#[derive(Debug)]
struct OpenFile {
    lexer: Lexer,
    path: Option<PathBuf>,
    /// The state to go back to at its end, if it was imported.
    import: Option<(GraphicsState, usize)>,
}

/// Which part of the scene is being read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    Options,
    World,
    /// The world, without `WorldBegin`: a file meant to be included.
    Fragment,
    /// After `WorldEnd`.
    Done,
}

/// Reads directives and hands them on.
#[derive(Debug)]
pub(crate) struct Parser {
    pub(crate) lowering: Lowering,
    state: StateStack,
    files: Vec<OpenFile>,
    block: Block,
    includes: usize,
    media_reported: bool,
}

impl Parser {
    /// Starts with nothing read.
    pub(crate) fn new(lowering: Lowering) -> Self {
        Self {
            lowering,
            state: StateStack::default(),
            files: Vec::new(),
            block: Block::Options,
            includes: 0,
            media_reported: false,
        }
    }

    /// Reads a scene file and all it includes. What is wrong goes to the reporter; after too many errors reading stops.
    pub(crate) fn run(&mut self, name: &str, path: Option<&Path>, bytes: Arc<[u8]>) {
        self.push_file(name, path, bytes, None);
        while !self.lowering.reporter.is_full() {
            match self.step() {
                Ok(true) => {}
                Ok(false) => break,
                Err(Reported) => {
                    if let Some(file) = self.files.last_mut() {
                        file.lexer.skip_to_directive();
                    }
                }
            }
        }
        for level in std::mem::take(&mut self.state.levels) {
            if !self.lowering.reporter.is_full() {
                let message = format!("{} is never ended", level.opened_by);
                self.lowering.reporter.warning(&level.place, "nesting", message);
            }
        }
        self.lowering.end_object();
        self.lowering.check_materials();
        finish_film(&mut self.lowering);
        self.lowering.description.files = self.lowering.reporter.sources.names();
    }

    fn push_file(
        &mut self,
        name: &str,
        path: Option<&Path>,
        bytes: Arc<[u8]>,
        import: Option<(GraphicsState, usize)>,
    ) {
        let id = self.lowering.reporter.sources.open(name, path, &bytes);
        let path = path.map(Path::to_owned);
        self.lowering.reading.push(path.clone());
        self.files.push(OpenFile { lexer: Lexer::new(bytes, id), path, import });
    }

    /// Reads one directive; `false` at the end.
    fn step(&mut self) -> Step<bool> {
        let Some(file) = self.files.last_mut() else { return Ok(false) };
        match file.lexer.next() {
            Ok(Some((Token::Word(word), place))) => {
                self.directive(&word, place)?;
                Ok(true)
            }
            Ok(Some((_, place))) => {
                let message = "a directive is expected, such as Shape or Translate";
                Err(self.lowering.reporter.error(&place, "syntax", message))
            }
            Ok(None) => {
                self.pop_file();
                Ok(true)
            }
            Err(error) => Err(self.syntax(error)),
        }
    }

    fn pop_file(&mut self) {
        let Some(file) = self.files.pop() else { return };
        self.lowering.reading.pop();
        let id = file.lexer.file();
        if !self.files.iter().any(|f| f.lexer.file() == id) {
            self.lowering.reporter.sources.close(id);
        }
        if let Some((state, levels)) = file.import {
            self.state.now = state;
            self.state.levels.truncate(levels);
        }
    }

    fn syntax(&mut self, error: LexError) -> Reported {
        self.lowering.reporter.error_with_help(&error.place, "syntax", error.message, error.help)
    }

    fn lexer(&mut self, place: &Place) -> Step<&mut Lexer> {
        match self.files.last_mut() {
            Some(file) => Ok(&mut file.lexer),
            None => Err(self.lowering.reporter.error(place, "syntax", "the file has ended")),
        }
    }

    /// Does what a directive says.
    fn directive(&mut self, word: &str, place: Place) -> Step<()> {
        if self.block == Block::Done && word != "Include" {
            self.lowering.reporter.warning(&place, "after-world", "what follows WorldEnd is not read");
            self.files.truncate(0);
            return Ok(());
        }
        if self.block == Block::Options && begins_world(word) {
            let message = format!("{word} before WorldBegin: the file is read as part of a world");
            self.lowering.reporter.warning(&place, "no-world", message);
            self.begin_world();
            self.block = Block::Fragment;
        }
        match word {
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform"
            | "CoordinateSystem" | "CoordSysTransform" | "ActiveTransform" | "TransformTimes" => {
                self.transformation(word, place)
            }
            "WorldBegin" | "WorldEnd" | "AttributeBegin" | "AttributeEnd" | "TransformBegin"
            | "TransformEnd" | "ObjectBegin" | "ObjectEnd" => self.block_directive(word, place),
            "Camera" | "Film" | "Sampler" | "Integrator" | "SurfaceIntegrator" | "VolumeIntegrator"
            | "Renderer" | "PixelFilter" | "Accelerator" | "ColorSpace" | "Option" => {
                self.option(word, place)
            }
            "Include" | "Import" => self.include(word, place),
            "Attribute" => self.attribute(place),
            "SearchPath" => {
                let (folder, _) = self.name(word, &place)?;
                self.lowering.finder.add_folder(&folder);
                Ok(())
            }
            "ReverseOrientation" => {
                self.state.now.reverse_orientation = !self.state.now.reverse_orientation;
                Ok(())
            }
            "MakeNamedMedium" | "MediumInterface" | "Volume" => self.medium(word, place),
            "Material" | "MakeNamedMaterial" | "NamedMaterial" | "Texture" | "Shape" | "AreaLightSource"
            | "LightSource" | "ObjectInstance" => self.thing(word, place),
            _ => {
                let message = format!("{:?} is no directive", shortened(word));
                let help = nearest(word, DIRECTIVES.iter().copied()).map(|n| format!("did you mean {n}?"));
                Err(self.lowering.reporter.error_with_help(&place, "syntax", message, help))
            }
        }
    }

    /// So many numbers, in brackets or not.
    fn numbers<const N: usize>(&mut self, place: &Place) -> Step<[f64; N]> {
        let read = |lexer: &mut Lexer| {
            let bracket = lexer.peek() == Some(b'[');
            if bracket {
                lexer.next()?;
            }
            let mut values = [0.0; N];
            for value in &mut values {
                lexer.peek();
                *value = lexer.float()?;
            }
            if bracket {
                match lexer.next()? {
                    Some((Token::Close, _)) => {}
                    other => {
                        let place = other.map_or_else(|| lexer.place(1), |(_, place)| place);
                        let message = format!("a closing bracket is expected after {N} numbers");
                        return Err(LexError { place, message, help: None });
                    }
                }
            }
            Ok(values)
        };
        let result = read(self.lexer(place)?);
        result.map_err(|error| self.syntax(error))
    }

    /// A quoted name.
    fn name(&mut self, directive: &str, place: &Place) -> Step<(String, Place)> {
        let lexer = self.lexer(place)?;
        let bracket = lexer.peek() == Some(b'[');
        let mut next = lexer.next();
        if bracket {
            next = lexer.next();
            if lexer.peek() == Some(b']') {
                lexer.skip_word();
            }
        }
        match next {
            Ok(Some((Token::Text(text), place))) => Ok((text, place)),
            Ok(found) => {
                let place = found.map_or(*place, |(_, place)| place);
                let message = format!("{directive} needs a name in quotes");
                Err(self.lowering.reporter.error(&place, "syntax", message))
            }
            Err(error) => Err(self.syntax(error)),
        }
    }

    /// The parameters up to the next directive.
    fn parameters(&mut self, subject: String, place: Place) -> Step<ParameterList> {
        let result = ParameterList::parse(self.lexer(&place)?, subject, place);
        result.map_err(|error| self.syntax(error))
    }

    fn transformation(&mut self, word: &str, place: Place) -> Step<()> {
        match word {
            "Identity" => self.state.replace(DMat4::IDENTITY),
            "Translate" => {
                let offset = self.numbers(&place)?;
                self.state.concatenate(DMat4::from_translation(DVec3::from_array(offset)));
            }
            "Scale" => {
                let factors = self.numbers(&place)?;
                self.state.concatenate(DMat4::from_scale(DVec3::from_array(factors)));
            }
            "Rotate" => {
                let [degrees, x, y, z] = self.numbers(&place)?;
                let Some(axis) = DVec3::new(x, y, z).try_normalize() else {
                    let message = "Rotate needs an axis that is not zero";
                    return Err(self.lowering.reporter.error(&place, "transformation", message));
                };
                self.state.concatenate(DMat4::from_axis_angle(axis, degrees.to_radians()));
            }
            "LookAt" => {
                let v: [f64; 9] = self.numbers(&place)?;
                let [eye, target, up] = [0, 3, 6].map(|i| DVec3::new(v[i], v[i + 1], v[i + 2]));
                let Some(matrix) = look_at(eye, target, up) else {
                    let message = "LookAt: the eye is the target, or up is parallel to the view";
                    return Err(self.lowering.reporter.error(&place, "transformation", message));
                };
                self.state.concatenate(matrix);
            }
            "Transform" => {
                let matrix = DMat4::from_cols_array(&self.numbers(&place)?);
                self.state.replace(matrix);
            }
            "ConcatTransform" => {
                let matrix = DMat4::from_cols_array(&self.numbers(&place)?);
                self.state.concatenate(matrix);
            }
            "CoordinateSystem" => {
                let (name, _) = self.name(word, &place)?;
                self.state.named_frames.insert(name, self.state.now.ctm);
            }
            "CoordSysTransform" => {
                let (name, name_place) = self.name(word, &place)?;
                let Some(matrix) = self.state.named_frames.get(&name).copied() else {
                    let message = format!("there is no coordinate system {:?}", shortened(&name));
                    let names = self.state.named_frames.keys().map(String::as_str);
                    let help = nearest(&name, names).map(|n| format!("did you mean {n:?}?"));
                    let r = &mut self.lowering.reporter;
                    return Err(r.error_with_help(&name_place, "missing-frame", message, help));
                };
                self.state.replace(matrix);
            }
            "ActiveTransform" => self.active_transform(place)?,
            _ => {
                let _: [f64; 2] = self.numbers(&place)?;
                self.animation(&place);
            }
        }
        Ok(())
    }

    fn active_transform(&mut self, place: Place) -> Step<()> {
        let next = self.lexer(&place)?.next();
        let which = match &next {
            Ok(Some((Token::Word(which), _))) => which.as_str(),
            _ => "",
        };
        self.state.now.start_active = match which {
            "StartTime" | "All" => true,
            "EndTime" => {
                self.animation(&place);
                false
            }
            _ => {
                let message = "ActiveTransform needs StartTime, EndTime or All";
                return Err(self.lowering.reporter.error(&place, "syntax", message));
            }
        };
        Ok(())
    }

    fn animation(&mut self, place: &Place) {
        let message = "motion is not available yet; everything stands where it is at the start";
        self.lowering.reporter.stand_in(place, "stand-in-motion", message);
    }

    fn begin_world(&mut self) {
        self.block = Block::World;
        self.state.now.ctm = DMat4::IDENTITY;
        self.state.now.start_active = true;
        self.state.named_frames.insert("world".to_owned(), DMat4::IDENTITY);
    }

    fn block_directive(&mut self, word: &str, place: Place) -> Step<()> {
        match word {
            "WorldBegin" => {
                if self.block != Block::Options {
                    let message = "WorldBegin, but the world has begun already";
                    return Err(self.lowering.reporter.error(&place, "nesting", message));
                }
                self.begin_world();
            }
            "WorldEnd" => {
                if self.block == Block::Options {
                    let message = "WorldEnd without WorldBegin";
                    return Err(self.lowering.reporter.error(&place, "nesting", message));
                }
                self.block = Block::Done;
            }
            "AttributeBegin" => {
                let saved = Saved::All(self.state.now.clone());
                self.open_level("AttributeBegin", place, saved)?;
            }
            "TransformBegin" => {
                let saved = Saved::Transform(self.state.now.ctm, self.state.now.start_active);
                self.open_level("TransformBegin", place, saved)?;
            }
            "ObjectBegin" => {
                let (name, _) = self.name(word, &place)?;
                let saved = Saved::All(self.state.now.clone());
                self.open_level("ObjectBegin", place, saved)?;
                if let Err(reported) = self.lowering.begin_object(&name, &place) {
                    self.state.levels.pop();
                    return Err(reported);
                }
            }
            "AttributeEnd" => self.close_level("AttributeBegin", word, place)?,
            "TransformEnd" => self.close_level("TransformBegin", word, place)?,
            _ => {
                self.close_level("ObjectBegin", word, place)?;
                self.lowering.end_object();
            }
        }
        Ok(())
    }

    fn open_level(&mut self, opened_by: &'static str, place: Place, saved: Saved) -> Step<()> {
        if self.state.levels.len() >= MAX_NESTING {
            let message = format!("{opened_by} is nested more than {MAX_NESTING} deep");
            return Err(self.lowering.reporter.error(&place, "nesting", message));
        }
        self.state.levels.push(Level { opened_by, place, saved });
        Ok(())
    }

    fn close_level(&mut self, opened_by: &str, word: &str, place: Place) -> Step<()> {
        // What an imported file opened before is not its to close.
        let floor = self.files.iter().filter_map(|f| f.import.as_ref()).map(|(_, levels)| *levels).max();
        let own = self.state.levels.len() > floor.unwrap_or(0);
        match self.state.levels.pop() {
            Some(level) if own && level.opened_by == opened_by => {
                self.state.restore(level.saved);
                Ok(())
            }
            other => {
                let message = match &other {
                    Some(level) if own => format!(
                        "{word}, but {} of line {} is open",
                        level.opened_by, level.place.location.line
                    ),
                    _ => format!("{word} without {opened_by}"),
                };
                self.state.levels.extend(other);
                Err(self.lowering.reporter.error(&place, "nesting", message))
            }
        }
    }

    fn option(&mut self, word: &str, place: Place) -> Step<()> {
        if word == "Option" {
            return self.parameters("Option".to_owned(), place).map(drop);
        }
        let (kind, name_place) = self.name(word, &place)?;
        if word == "ColorSpace" {
            let Some(space) = ColorSpace::of_name(&kind) else {
                let message = format!("color space {:?} is unknown", shortened(&kind));
                let help = Some("color spaces are srgb, rec2020, dci-p3 and aces2065-1".to_owned());
                let r = &mut self.lowering.reporter;
                return Err(r.error_with_help(&name_place, "parameter-range", message, help));
            };
            self.state.now.color_space = space;
            return Ok(());
        }
        let subject = format!("{} {:?}", subject(word), shortened(&kind));
        let list = self.parameters(subject, place)?;
        if self.block != Block::Options && !matches!(word, "Accelerator" | "VolumeIntegrator" | "Renderer") {
            let message = format!("{word} has no effect after WorldBegin");
            self.lowering.reporter.warning(&place, "late-option", message);
            return Ok(());
        }
        match word {
            "Camera" => {
                let ctm = self.state.now.ctm;
                self.lowering.camera(&kind, list, ctm)?;
                self.state.named_frames.insert("camera".to_owned(), ctm.inverse());
                Ok(())
            }
            "Film" => self.lowering.film(&kind, list),
            "Sampler" => self.lowering.sampler(&kind, list),
            "Integrator" | "SurfaceIntegrator" => self.lowering.integrator(&kind, list),
            "PixelFilter" => self.lowering.filter(&kind, list),
            // Of no influence on the picture, or only with media.
            _ => Ok(()),
        }
    }

    fn include(&mut self, word: &str, place: Place) -> Step<()> {
        let (name, name_place) = self.name(word, &place)?;
        let r = &mut self.lowering.reporter;
        if self.files.len() > MAX_INCLUDE_DEPTH {
            let message = format!("files are included more than {MAX_INCLUDE_DEPTH} deep");
            return Err(r.error(&name_place, "include", message));
        }
        self.includes += 1;
        if self.includes > MAX_INCLUDES {
            let message = format!("more than {MAX_INCLUDES} files are included");
            return Err(r.error(&name_place, "include", message));
        }
        let asking = self.files.last().and_then(|f| f.path.as_deref());
        let Some(path) = self.lowering.finder.find(&name, asking) else {
            let message = format!("{word}: file {:?} is not there", shortened(&name));
            let help = Some("names are relative to the folder of the scene file".to_owned());
            return Err(r.error_with_help(&name_place, "missing-file", message, help));
        };
        let real = |p: &Path| std::fs::canonicalize(p).ok();
        let cycle = self.files.iter().filter_map(|f| f.path.as_deref()).any(|open| real(open) == real(&path));
        if cycle {
            let message = format!("{word}: file {:?} includes itself", shortened(&name));
            return Err(r.error(&name_place, "include", message));
        }
        let bytes: Arc<[u8]> = match self.lowering.finder.read(&path) {
            Ok(bytes) => bytes.into(),
            Err(error) => {
                let message = format!("{word}: file {:?} cannot be read: {error}", shortened(&name));
                return Err(r.error(&name_place, "missing-file", message));
            }
        };
        let import = (word == "Import").then(|| (self.state.now.clone(), self.state.levels.len()));
        let shown = path.display().to_string();
        self.push_file(&shown, Some(&path), bytes, import);
        Ok(())
    }

    /// `Attribute "target" parameters`: defaults for what comes.
    fn attribute(&mut self, place: Place) -> Step<()> {
        let (target, name_place) = self.name("Attribute", &place)?;
        let list = self.parameters(format!("Attribute {:?}", shortened(&target)), place)?;
        let Some(attributes) = self.state.now.attributes.of(&target) else {
            let message = format!("Attribute {:?} is unknown", shortened(&target));
            let help = Some("attributes are of shape, light, material, medium and texture".to_owned());
            let r = &mut self.lowering.reporter;
            return Err(r.error_with_help(&name_place, "parameter-range", message, help));
        };
        let mut all = list.into_items();
        all.retain(|p| p.values.len() <= MAX_ATTRIBUTE_VALUES);
        for old in attributes.iter() {
            if !all.iter().any(|p| p.name == old.name) {
                all.push(old.clone());
            }
        }
        if all.len() > MAX_ATTRIBUTES {
            let message = format!("more than {MAX_ATTRIBUTES} attributes");
            return Err(self.lowering.reporter.error(&place, "nesting", message));
        }
        *attributes = Rc::new(all);
        Ok(())
    }

    /// Media are read and left out.
    fn medium(&mut self, word: &str, place: Place) -> Step<()> {
        let (kind, _) = self.name(word, &place)?;
        // The second name of MediumInterface looks like a parameter without type; take both alike.
        if word == "MediumInterface" {
            let lexer = self.lexer(&place)?;
            if lexer.peek() == Some(b'"') {
                let second = lexer.next();
                second.map_err(|error| self.syntax(error))?;
            }
        }
        self.parameters(format!("medium {:?}", shortened(&kind)), place)?;
        if !self.media_reported {
            self.media_reported = true;
            let message = "media are not available yet; empty space stands in";
            self.lowering.reporter.stand_in(&place, "stand-in-medium", message);
        }
        Ok(())
    }

    fn context(&self) -> Context {
        let now = &self.state.now;
        Context {
            ctm: now.ctm,
            reverse_orientation: now.reverse_orientation,
            material: now.material,
            emission: now.emission.clone(),
            color_space: now.color_space,
        }
    }

    /// What makes something or chooses what is made.
    fn thing(&mut self, word: &str, place: Place) -> Step<()> {
        let (name, name_place) = self.name(word, &place)?;
        match word {
            "NamedMaterial" => {
                self.state.now.material = Some(self.lowering.use_material(&name, &name_place));
                return Ok(());
            }
            "ObjectInstance" => {
                let context = self.context();
                return self.lowering.instance(&name, &name_place, &context);
            }
            "Texture" => return self.texture(&name, place),
            _ => {}
        }
        let subject = format!("{} {:?}", subject(word), shortened(&name));
        let mut list = self.parameters(subject, place)?;
        let attributes = &self.state.now.attributes;
        match word {
            "Shape" => list.inherit(&attributes.shape),
            "LightSource" | "AreaLightSource" => list.inherit(&attributes.light),
            _ => list.inherit(&attributes.material),
        }
        let context = self.context();
        match word {
            "Shape" => self.lowering.shape(&name, list, &context),
            "LightSource" => self.lowering.light(&name, list, &context),
            "AreaLightSource" => {
                self.state.now.emission = Some(self.lowering.area_light(&name, list, &context)?);
                Ok(())
            }
            "Material" => {
                self.state.now.material = Some(self.lowering.material(&name, list, context.color_space)?);
                Ok(())
            }
            _ => self.lowering.named_material(&name, list, context.color_space),
        }
    }

    fn texture(&mut self, name: &str, place: Place) -> Step<()> {
        let (value_type, _) = self.name("Texture", &place)?;
        let (kind, _) = self.name("Texture", &place)?;
        let mut list = self.parameters(format!("texture {:?}", shortened(&kind)), place)?;
        list.inherit(&self.state.now.attributes.texture);
        let context = self.context();
        self.lowering.texture(name, &value_type, &kind, list, &context)
    }
}

/// Values of an attribute at most: it is copied to every thing it applies to.
const MAX_ATTRIBUTE_VALUES: usize = 64;
/// Attributes of one target at most.
const MAX_ATTRIBUTES: usize = 256;

/// What a directive makes, as messages call it.
fn subject(directive: &str) -> &'static str {
    match directive {
        "Camera" => "camera",
        "Film" => "film",
        "Sampler" => "sampler",
        "PixelFilter" => "filter",
        "Shape" => "shape",
        "LightSource" => "light",
        "AreaLightSource" => "area light",
        "Material" | "MakeNamedMaterial" => "material",
        "Accelerator" => "accelerator",
        _ => "integrator",
    }
}

/// Whether a directive stands in the world only.
fn begins_world(directive: &str) -> bool {
    matches!(
        directive,
        "AttributeBegin"
            | "TransformBegin"
            | "ObjectBegin"
            | "ObjectInstance"
            | "Shape"
            | "LightSource"
            | "AreaLightSource"
            | "Material"
            | "NamedMaterial"
            | "ReverseOrientation"
            | "Volume"
    )
}
