//! Typed parameter lists: `"float radius" [2] "rgb L" [1 1 1] ...`.

mod syntax;
#[cfg(test)]
mod tests;

use glanz_job::MemoryReservation;
use glanz_math::{DVec2, DVec3};
use glanz_scene::Severity;

use crate::nearest::nearest;
use crate::pbrt::lexer::{LexError, Lexer};
use crate::source::{ParseResult, ReportedError, Reporter, Span};

pub(crate) use crate::source::shortened;
use syntax::parse_parameter;
pub(crate) use syntax::{Parameter, ParameterType, Values};

/// The parameters of one directive. Reading a parameter removes it; those that remain at the end are unused.
#[derive(Debug)]
pub(crate) struct ParameterList {
    /// The owner in messages: `shape "sphere"`.
    pub(crate) subject: String,
    /// Span of the directive.
    pub(crate) place: Span,
    items: Vec<Parameter>,
    asked: Vec<&'static str>,
    /// Memory of the list, in use until it is dropped.
    memory: Option<MemoryReservation>,
}

/// Largest number of parameters of a directive.
const MAX_PARAMETERS: usize = 1024;

/// Kind of the warnings about unused parameters.
const UNUSED: &str = "unused-parameter";

impl ParameterList {
    /// Reads parameters up to the next directive.
    pub(crate) fn parse(lexer: &mut Lexer, subject: String, place: Span) -> Result<Self, LexError> {
        let mut items = Vec::new();
        while lexer.peek() == Some(b'"') {
            if items.len() == MAX_PARAMETERS {
                let message = format!("{subject} has more than {MAX_PARAMETERS} parameters");
                return Err(LexError { place: lexer.place(1), message, help: None });
            }
            items.push(parse_parameter(lexer)?);
        }
        Ok(Self { subject, place, items, asked: Vec::new(), memory: None })
    }

    /// The list with its memory.
    pub(crate) fn within(self, memory: MemoryReservation) -> Self {
        Self { memory: Some(memory), ..self }
    }

    /// Leaves its memory in use, since its values become part of the description.
    pub(crate) fn keep_memory(&mut self) {
        if let Some(memory) = self.memory.take() {
            memory.keep();
        }
    }

    /// Bytes of the values.
    pub(crate) fn bytes(&self) -> u64 {
        self.items.iter().map(|p| (size_of_val(p) + p.values.bytes()) as u64).sum()
    }

    /// Appends the parameters of `defaults`; its own take precedence.
    pub(crate) fn inherit(&mut self, defaults: &[Parameter]) {
        for d in defaults {
            if !self.items.iter().any(|p| p.name == d.name) {
                self.items.push(d.clone());
            }
        }
    }

    /// The parameters themselves.
    pub(crate) fn into_items(self) -> Vec<Parameter> {
        self.items
    }

    /// The first parameter of this name, which stays in the list.
    pub(crate) fn get(&self, name: &str) -> Option<&Parameter> {
        self.items.iter().find(|p| p.name == name)
    }

    /// Whether a parameter of this name is present.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// Removes and returns the first parameter of this name.
    pub(crate) fn take(&mut self, name: &'static str) -> Option<Parameter> {
        if !self.asked.contains(&name) {
            self.asked.push(name);
        }
        let i = self.items.iter().position(|p| p.name == name)?;
        Some(self.items.remove(i))
    }

    /// Removes parameters that are known but have no effect here.
    pub(crate) fn ignore(&mut self, names: &[&'static str]) {
        for name in names {
            while self.take(name).is_some() {}
        }
    }

    /// Warns of unused parameters.
    pub(crate) fn finish(self, reporter: &mut Reporter) {
        for p in &self.items {
            // The search for similar names takes longer than reading, so it is omitted for messages that are not shown.
            if !reporter.diagnostics.keeps(Severity::Warning, UNUSED) {
                reporter.diagnostics.admit(Severity::Warning, UNUSED);
                continue;
            }
            let message = format!("parameter {:?} is not used by {}", p.name, self.subject);
            let help = nearest(&p.name, self.asked.iter().copied())
                .filter(|n| *n != p.name)
                .map(|n| format!("did you mean {n:?}?"));
            let help = help.or_else(|| {
                self.asked
                    .contains(&p.name.as_str())
                    .then(|| "it is given twice, the first counts".to_owned())
            });
            reporter.warning_with_help(&p.place, UNUSED, message, help);
        }
    }

    fn wrong_type(&self, p: &Parameter, expected: &str, reporter: &mut Reporter) -> ReportedError {
        let message = format!("{}: parameter {:?} is of type {}", self.subject, p.name, p.kind.name());
        let help = Some(format!("write it as \"{expected} {}\"", p.name));
        reporter.error_with_help(&p.place, "parameter-type", message, help)
    }

    fn wrong_count(&self, p: &Parameter, expected: &str, reporter: &mut Reporter) -> ReportedError {
        let (n, s) = (p.values.len(), if p.values.len() == 1 { "" } else { "s" });
        let message = format!("{}: parameter {:?} has {n} value{s}; {expected}", self.subject, p.name);
        reporter.error(&p.value_place, "parameter-count", message)
    }

    /// The numbers of a parameter of one of the types, integers included.
    fn numbers(
        &mut self,
        name: &'static str,
        types: &[ParameterType],
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, Vec<f64>)>> {
        let Some(mut p) = self.take(name) else { return Ok(None) };
        let fits = types.contains(&p.kind)
            || (p.kind == ParameterType::Integer && types.contains(&ParameterType::Float));
        if !fits {
            let expected = types.first().map_or("float", |t| t.name());
            return Err(self.wrong_type(&p, expected, reporter));
        }
        match std::mem::replace(&mut p.values, Values::Bools(Vec::new())) {
            Values::Floats(v) => Ok(Some((p, v))),
            Values::Integers(v) => Ok(Some((p, v.into_iter().map(f64::from).collect()))),
            other => {
                p.values = other;
                Err(self.wrong_type(&p, "float", reporter))
            }
        }
    }

    /// One number.
    pub(crate) fn float(&mut self, name: &'static str, reporter: &mut Reporter) -> ParseResult<Option<f64>> {
        let Some((p, v)) = self.numbers(name, &[ParameterType::Float], reporter)? else { return Ok(None) };
        match v[..] {
            [x] => Ok(Some(x)),
            _ => Err(self.wrong_count_of(p, v, "1 is needed", reporter)),
        }
    }

    /// One number, or a default.
    pub(crate) fn float_or(
        &mut self,
        name: &'static str,
        default: f64,
        reporter: &mut Reporter,
    ) -> ParseResult<f64> {
        Ok(self.float(name, reporter)?.unwrap_or(default))
    }

    /// Any count of numbers, with the parameter for messages.
    pub(crate) fn floats(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, Vec<f64>)>> {
        self.numbers(name, &[ParameterType::Float], reporter)
    }

    /// Exactly `N` numbers.
    pub(crate) fn float_array<const N: usize>(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<[f64; N]>> {
        let Some((p, v)) = self.floats(name, reporter)? else { return Ok(None) };
        match <[f64; N]>::try_from(&v[..]) {
            Ok(values) => Ok(Some(values)),
            Err(_) => Err(self.wrong_count_of(p, v, &format!("{N} are needed"), reporter)),
        }
    }

    fn wrong_count_of(
        &self,
        mut p: Parameter,
        values: Vec<f64>,
        expected: &str,
        reporter: &mut Reporter,
    ) -> ReportedError {
        p.values = Values::Floats(values);
        self.wrong_count(&p, expected, reporter)
    }

    /// Any count of integers, with the parameter for messages.
    pub(crate) fn integers(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, Vec<i32>)>> {
        let Some(mut p) = self.take(name) else { return Ok(None) };
        match std::mem::replace(&mut p.values, Values::Bools(Vec::new())) {
            Values::Integers(v) => Ok(Some((p, v))),
            Values::Floats(v) if p.kind == ParameterType::Float && v.iter().all(|x| is_i32(*x)) => {
                Ok(Some((p, v.into_iter().map(|x| x as i32).collect())))
            }
            _ => Err(self.wrong_type(&p, "integer", reporter)),
        }
    }

    /// Exactly `N` integers, with the parameter for messages.
    pub(crate) fn integer_array<const N: usize>(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, [i32; N])>> {
        let Some((mut p, v)) = self.integers(name, reporter)? else { return Ok(None) };
        match <[i32; N]>::try_from(&v[..]) {
            Ok(values) => Ok(Some((p, values))),
            Err(_) => {
                p.values = Values::Integers(v);
                Err(self.wrong_count(&p, &format!("{N} are needed"), reporter))
            }
        }
    }

    /// One integer.
    pub(crate) fn integer(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<i32>> {
        let Some((mut p, v)) = self.integers(name, reporter)? else { return Ok(None) };
        match v[..] {
            [x] => Ok(Some(x)),
            _ => {
                p.values = Values::Integers(v);
                Err(self.wrong_count(&p, "1 is needed", reporter))
            }
        }
    }

    /// One integer that must be at least `low`.
    pub(crate) fn integer_from(
        &mut self,
        name: &'static str,
        low: i32,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<u32>> {
        let place = self.value_place(name);
        match self.integer(name, reporter)? {
            Some(x) if x < low => {
                let message = format!("{}: {name:?} is {x}; it must be at least {low}", self.subject);
                Err(reporter.error(&place, "parameter-range", message))
            }
            Some(x) => Ok(Some(x.unsigned_abs())),
            None => Ok(None),
        }
    }

    /// One Boolean value.
    pub(crate) fn boolean(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<bool>> {
        let Some(p) = self.take(name) else { return Ok(None) };
        match &p.values {
            Values::Bools(v) => match v[..] {
                [x] => Ok(Some(x)),
                _ => Err(self.wrong_count(&p, "1 is needed", reporter)),
            },
            _ => Err(self.wrong_type(&p, "bool", reporter)),
        }
    }

    /// One text, with the parameter for messages.
    pub(crate) fn text_parameter(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, String)>> {
        let Some(mut p) = self.take(name) else { return Ok(None) };
        match &mut p.values {
            Values::Texts(v) if p.kind == ParameterType::Text => match v.pop() {
                Some(text) if v.is_empty() => Ok(Some((p, text))),
                Some(text) => {
                    v.push(text);
                    Err(self.wrong_count(&p, "1 is needed", reporter))
                }
                None => Err(self.wrong_count(&p, "1 is needed", reporter)),
            },
            _ => Err(self.wrong_type(&p, "string", reporter)),
        }
    }

    /// Any count of texts, with the parameter for messages.
    pub(crate) fn texts(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, Vec<String>)>> {
        let Some(mut p) = self.take(name) else { return Ok(None) };
        match &mut p.values {
            Values::Texts(v) if p.kind == ParameterType::Text => {
                let texts = std::mem::take(v);
                Ok(Some((p, texts)))
            }
            _ => Err(self.wrong_type(&p, "string", reporter)),
        }
    }

    /// One text.
    pub(crate) fn text(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<String>> {
        Ok(self.text_parameter(name, reporter)?.map(|(_, text)| text))
    }

    /// One point or vector.
    pub(crate) fn vec3(&mut self, name: &'static str, reporter: &mut Reporter) -> ParseResult<Option<DVec3>> {
        Ok(match self.vec3s(name, reporter)? {
            None => None,
            Some((p, v)) => match v[..] {
                [x] => Some(x),
                _ => {
                    let flat = v.iter().flat_map(|v| v.to_array()).collect();
                    return Err(self.wrong_count_of(p, flat, "3 are needed", reporter));
                }
            },
        })
    }

    /// Points, vectors or normals.
    pub(crate) fn vec3s(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, Vec<DVec3>)>> {
        let types =
            [ParameterType::Point3, ParameterType::Vector3, ParameterType::Normal, ParameterType::Float];
        let Some((p, v)) = self.numbers(name, &types, reporter)? else { return Ok(None) };
        if !v.len().is_multiple_of(3) {
            return Err(self.wrong_count_of(p, v, "a multiple of 3 is needed", reporter));
        }
        let points = v.chunks_exact(3).map(DVec3::from_slice).collect();
        Ok(Some((p, points)))
    }

    /// Texture coordinates, which older files declare as floats.
    pub(crate) fn vec2s(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, Vec<DVec2>)>> {
        let types = [ParameterType::Point2, ParameterType::Vector2, ParameterType::Float];
        let Some((p, v)) = self.numbers(name, &types, reporter)? else { return Ok(None) };
        if !v.len().is_multiple_of(2) {
            return Err(self.wrong_count_of(p, v, "a multiple of 2 is needed", reporter));
        }
        let points = v.chunks_exact(2).map(DVec2::from_slice).collect();
        Ok(Some((p, points)))
    }

    /// Groups of `N` numbers, written as floats or, if they are pairs, as points.
    pub(crate) fn groups<const N: usize>(
        &mut self,
        name: &'static str,
        reporter: &mut Reporter,
    ) -> ParseResult<Option<(Parameter, Vec<[f64; N]>)>> {
        let types: &[ParameterType] =
            if N == 2 { &[ParameterType::Float, ParameterType::Point2] } else { &[ParameterType::Float] };
        let Some((p, v)) = self.numbers(name, types, reporter)? else { return Ok(None) };
        let (groups, rest) = v.as_chunks::<N>();
        if !rest.is_empty() {
            let expected = format!("a multiple of {N} is needed");
            return Err(self.wrong_count_of(p, v, &expected, reporter));
        }
        let groups = groups.to_vec();
        Ok(Some((p, groups)))
    }

    /// Span of a parameter's value, or of the directive if there is no such parameter.
    pub(crate) fn value_place(&self, name: &str) -> Span {
        self.get(name).map_or(self.place, |p| p.value_place)
    }
}

fn is_i32(x: f64) -> bool {
    x.fract() == 0.0 && x >= f64::from(i32::MIN) && x <= f64::from(i32::MAX)
}
