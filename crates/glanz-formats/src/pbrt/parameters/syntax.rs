//! Syntax of parameters: declarations and values.

use crate::nearest::nearest;
use crate::pbrt::lexer::{LexError, Lexer, ListMemory, Token};
use crate::source::{Span, shortened};

/// The declared type of a parameter; synonyms of the dialects are the same type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ParameterType {
    Integer,
    Float,
    Bool,
    Text,
    Point2,
    Point3,
    Vector2,
    Vector3,
    Normal,
    Rgb,
    Xyz,
    Spectrum,
    Blackbody,
    Texture,
}

const TYPE_NAMES: [(&str, ParameterType); 20] = [
    ("integer", ParameterType::Integer),
    ("float", ParameterType::Float),
    ("bool", ParameterType::Bool),
    ("string", ParameterType::Text),
    ("point", ParameterType::Point3),
    ("point3", ParameterType::Point3),
    ("point2", ParameterType::Point2),
    ("vector", ParameterType::Vector3),
    ("vector3", ParameterType::Vector3),
    ("vector2", ParameterType::Vector2),
    ("normal", ParameterType::Normal),
    ("normal3", ParameterType::Normal),
    ("rgb", ParameterType::Rgb),
    ("color", ParameterType::Rgb),
    ("xyz", ParameterType::Xyz),
    ("spectrum", ParameterType::Spectrum),
    ("blackbody", ParameterType::Blackbody),
    ("texture", ParameterType::Texture),
    ("int", ParameterType::Integer),
    ("boolean", ParameterType::Bool),
];

impl ParameterType {
    fn of_name(name: &str) -> Option<Self> {
        TYPE_NAMES.iter().find(|(n, _)| *n == name).map(|(_, t)| *t)
    }

    pub(super) fn name(self) -> &'static str {
        TYPE_NAMES.iter().find(|(_, t)| *t == self).map_or("", |(n, _)| n)
    }
}

/// The values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Values {
    Integers(Vec<i32>),
    Floats(Vec<f64>),
    Texts(Vec<String>),
    Bools(Vec<bool>),
}

impl Values {
    /// Bytes of the list.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Integers(v) => size_of_val(v.as_slice()),
            Self::Floats(v) => size_of_val(v.as_slice()),
            Self::Texts(v) => v.iter().map(|text| size_of_val(text) + text.len()).sum(),
            Self::Bools(v) => v.len(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Integers(v) => v.len(),
            Self::Floats(v) => v.len(),
            Self::Texts(v) => v.len(),
            Self::Bools(v) => v.len(),
        }
    }
}

/// One parameter.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    pub(crate) kind: ParameterType,
    pub(crate) name: String,
    /// Of the declaration.
    pub(crate) place: Span,
    /// Of the first value, or of the declaration if there is none.
    pub(crate) value_place: Span,
    pub(crate) values: Values,
}

/// For messages.
const SUGGESTED_TYPES: &str = "types are integer, float, bool, string, point2, point3, vector2, vector3, normal, rgb, xyz, spectrum, blackbody, texture";

/// Reads `"type name"` and its values.
pub(super) fn parse_parameter(lexer: &mut Lexer) -> Result<Parameter, LexError> {
    let (declaration, place) = lexer.text()?;
    let mut words = declaration.split_ascii_whitespace();
    let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
        let message = format!("{:?} does not declare a parameter", shortened(&declaration));
        let help = Some("a parameter is written \"type name\", for example \"float radius\"".to_owned());
        return Err(LexError { place, message, help });
    };
    let Some(kind) = ParameterType::of_name(kind) else {
        let message = format!("parameter {:?} has the unknown type {:?}", shortened(name), shortened(kind));
        let help = nearest(kind, TYPE_NAMES.iter().map(|(n, _)| *n))
            .map_or_else(|| SUGGESTED_TYPES.to_owned(), |n| format!("did you mean {n:?}?"));
        return Err(LexError { place, message, help: Some(help) });
    };
    let name = name.to_owned();
    let bracket = lexer.peek() == Some(b'[');
    if bracket {
        lexer.next()?;
    }
    let value_place = match lexer.peek() {
        Some(b']') | None => place,
        Some(_) => lexer.place(1),
    };
    let values = parse_values(lexer, kind, bracket)?;
    let end = lexer.place(0);
    let same_line = end.location.line == value_place.location.line;
    let length = if same_line && value_place != place {
        end.offset.saturating_sub(value_place.offset + usize::from(bracket)).max(1)
    } else {
        value_place.length
    };
    Ok(Parameter { kind, name, place, value_place: Span { length, ..value_place }, values })
}

fn parse_values(lexer: &mut Lexer, kind: ParameterType, bracket: bool) -> Result<Values, LexError> {
    Ok(match kind {
        ParameterType::Integer => Values::Integers(collect(lexer, bracket, Lexer::integer)?),
        ParameterType::Bool => Values::Bools(collect(lexer, bracket, boolean)?),
        ParameterType::Text | ParameterType::Texture => Values::Texts(collect(lexer, bracket, text)?),
        ParameterType::Spectrum if lexer.peek() == Some(b'"') => {
            Values::Texts(collect(lexer, bracket, text)?)
        }
        // Without brackets there is one value.
        _ => Values::Floats(collect(lexer, bracket, Lexer::float)?),
    })
}

/// One value, or after a bracket all values up to the closing one, which is skipped.
fn collect<T>(
    lexer: &mut Lexer,
    bracket: bool,
    read: impl Fn(&mut Lexer) -> Result<T, LexError>,
) -> Result<Vec<T>, LexError> {
    if !bracket {
        return read(lexer).map(|value| vec![value]);
    }
    let mut out = Vec::new();
    let mut memory = ListMemory::default();
    loop {
        match lexer.peek() {
            Some(b']') => {
                lexer.close()?;
                return Ok(out);
            }
            Some(_) => {
                lexer.reserve_list::<T>(&mut memory, out.len() + 1)?;
                out.push(read(lexer)?);
            }
            None => {
                let place = lexer.place(1);
                let message = "the file ends before a bracket is closed".to_owned();
                return Err(LexError { place, message, help: None });
            }
        }
    }
}

fn text(lexer: &mut Lexer) -> Result<String, LexError> {
    if lexer.peek() == Some(b'"') {
        return lexer.text().map(|(text, _)| text);
    }
    let place = lexer.place(1);
    Err(LexError { place, message: "a quoted text is expected".to_owned(), help: None })
}

/// `true` and `false`, quoted (version 3) or not (version 4).
fn boolean(lexer: &mut Lexer) -> Result<bool, LexError> {
    let place = lexer.place(1);
    match lexer.next()? {
        Some((Token::Word(w) | Token::Text(w), _)) if w == "true" => Ok(true),
        Some((Token::Word(w) | Token::Text(w), _)) if w == "false" => Ok(false),
        _ => Err(LexError { place, message: "true or false is expected".to_owned(), help: None }),
    }
}
