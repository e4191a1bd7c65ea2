//! The directives of pbrt's scene language.

mod blocks;
mod objects;
mod transformations;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glanz_job::{BudgetError, MemoryReservation};
use glanz_scene::description::FileId;

use crate::nearest::nearest;
use crate::pbrt::lexer::{LexError, Lexer, Token};
use crate::pbrt::lower::{Lowering, finish_film};
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::pbrt::state::{GraphicsState, StateStack};
use crate::source::{MISSING_FILE, ParseResult, ReportedError, Span};

/// All directives of versions 1 to 4.
pub(super) const DIRECTIVES: &[&str] = &[
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
    "Observer",
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
    /// The path with links resolved, by which a file that includes itself is recognised.
    real: Option<PathBuf>,
    /// For its bytes, and as many while they are read.
    _memory: MemoryReservation,
    /// The state to restore at its end, if it was imported.
    import: Option<(GraphicsState, usize)>,
}

/// The part of the scene that is being read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OpenBlock {
    Options,
    World,
    /// The world, without `WorldBegin`: a file intended for inclusion.
    Fragment,
    /// After `WorldEnd`.
    Done,
}

/// Parser of directives, which passes them to the lowering.
#[derive(Debug)]
pub(crate) struct Parser {
    pub(crate) lowering: Lowering,
    state: StateStack,
    files: Vec<OpenFile>,
    block: OpenBlock,
    /// Whether there was a directive, even one with an error.
    pub(crate) is_understood: bool,
}

impl Parser {
    /// The initial state.
    pub(crate) fn new(lowering: Lowering) -> Self {
        Self {
            lowering,
            state: StateStack::default(),
            files: Vec::new(),
            block: OpenBlock::Options,
            is_understood: false,
        }
    }

    /// Reads a scene file and all included files. Errors are reported to the reporter; reading ends after too many of them.
    pub(crate) fn run(&mut self, name: &str, path: Option<&Path>, bytes: Arc<[u8]>) {
        // What fails is in the budget.
        let _ = self.push_file(name, path, bytes, None);
        while !self.lowering.reporter.is_full() {
            match self.step() {
                Ok(true) => {}
                Ok(false) => break,
                Err(ReportedError) => {
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
        self.lowering.check_media();
        finish_film(&mut self.lowering);
        self.lowering.description.files = self.lowering.reporter.sources.names();
    }

    fn push_file(
        &mut self,
        name: &str,
        path: Option<&Path>,
        bytes: Arc<[u8]>,
        import: Option<(GraphicsState, usize)>,
    ) -> Result<(), BudgetError> {
        let memory = self.lowering.finder.budget.reserve(2 * bytes.len() as u64)?;
        let id = self.lowering.reporter.sources.open(name, path, &bytes);
        let real = path.and_then(|path| std::fs::canonicalize(path).ok());
        let path = path.map(Path::to_owned);
        self.lowering.reading.push(path.clone());
        let lexer = Lexer::new(bytes, id, &self.lowering.finder.budget);
        self.files.push(OpenFile { lexer, path, real, _memory: memory, import });
        Ok(())
    }

    /// Reads one directive; `false` at the end.
    fn step(&mut self) -> ParseResult<bool> {
        let Some(file) = self.files.last_mut() else { return Ok(false) };
        if self.lowering.finder.budget.check().is_err() {
            let place = file.lexer.place(1);
            self.lowering.reporter.check(&place)?;
        }
        match file.lexer.next() {
            Ok(Some((Token::Word(word), place))) => {
                self.is_understood |= DIRECTIVES.contains(&word.as_str());
                self.directive(&word, place)?;
                Ok(true)
            }
            Ok(Some((_, place))) => {
                let message = "a directive is expected, such as Shape or Translate";
                Err(self.lowering.reporter.error(&place, "syntax", message))
            }
            Ok(None) => {
                let spent = file.lexer.spend();
                self.pop_file();
                spent.map(|()| true).map_err(|error| self.syntax(error))
            }
            Err(error) => Err(self.syntax(error)),
        }
    }

    fn pop_file(&mut self) {
        let Some(file) = self.files.pop() else { return };
        self.lowering.reading.pop();
        let id = file.lexer.file();
        // An inverse design writes the scene file anew, as it was when it was read.
        let is_kept = id == FileId(0) && !self.lowering.description.design.variables.is_empty();
        if !is_kept && !self.files.iter().any(|f| f.lexer.file() == id) {
            self.lowering.reporter.sources.close(id);
        }
        if let Some((state, levels)) = file.import {
            self.state.now = state;
            self.state.levels.truncate(levels);
        }
    }

    fn syntax(&mut self, error: LexError) -> ReportedError {
        self.lowering.reporter.error_with_help(&error.place, "syntax", error.message, error.help)
    }

    fn lexer(&mut self, place: &Span) -> ParseResult<&mut Lexer> {
        match self.files.last_mut() {
            Some(file) => Ok(&mut file.lexer),
            None => Err(self.lowering.reporter.error(place, "syntax", "the file has ended")),
        }
    }

    /// Executes a directive.
    fn directive(&mut self, word: &str, place: Span) -> ParseResult<()> {
        if self.block == OpenBlock::Done {
            self.lowering.reporter.warning(&place, "after-world", "text after WorldEnd is not read");
            self.files.truncate(0);
            return Ok(());
        }
        if self.block == OpenBlock::Options && begins_world(word) {
            let message = format!("{word} before WorldBegin: the file is read as part of a world");
            self.lowering.reporter.warning(&place, "no-world", message);
            self.begin_world();
            self.block = OpenBlock::Fragment;
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
                let (folder, name_place) = self.name(word, &place)?;
                self.lowering.finder.add_folder(&folder).map_err(|fault| {
                    let message = format!("SearchPath: folder {:?} {}", shortened(&folder), fault.what());
                    self.lowering.reporter.error(&name_place, MISSING_FILE, message)
                })
            }
            "ReverseOrientation" => {
                self.state.now.reverse_orientation = !self.state.now.reverse_orientation;
                Ok(())
            }
            "MediumInterface" => self.medium_interface(place),
            "MakeNamedMedium" => self.named_medium(place),
            "Volume" => self.volume(place),
            "Material" | "MakeNamedMaterial" | "NamedMaterial" | "Texture" | "Shape" | "AreaLightSource"
            | "LightSource" | "ObjectInstance" | "Observer" => self.thing(word, place),
            _ => {
                let message = format!("{:?} is no directive", shortened(word));
                let help = nearest(word, DIRECTIVES.iter().copied()).map(|n| format!("did you mean {n}?"));
                Err(self.lowering.reporter.error_with_help(&place, "syntax", message, help))
            }
        }
    }

    /// A fixed number of numbers, with or without brackets.
    fn numbers<const N: usize>(&mut self, place: &Span) -> ParseResult<[f64; N]> {
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
    fn name(&mut self, directive: &str, place: &Span) -> ParseResult<(String, Span)> {
        let lexer = self.lexer(place)?;
        let bracket = lexer.peek() == Some(b'[');
        let mut next = lexer.next();
        if bracket {
            next = lexer.next();
            if lexer.peek() == Some(b']') {
                next = lexer.close().and(next);
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
    fn parameters(&mut self, subject: String, place: Span) -> ParseResult<ParameterList> {
        let result = ParameterList::parse(self.lexer(&place)?, subject, place);
        let list = result.map_err(|error| self.syntax(error))?;
        let reporter = &mut self.lowering.reporter;
        match reporter.budget.reserve(list.bytes()) {
            Ok(memory) => Ok(list.within(memory)),
            Err(end) => Err(reporter.end(&place, end)),
        }
    }
}

/// Whether a directive is allowed in the world block only.
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
            | "Observer"
            | "ReverseOrientation"
            | "Volume"
    )
}
