//! Instances and their attributes.

use glanz_brep::model::EntityId;

use super::ExchangeFile;
use super::keyword::Keyword;
use super::tape::{EntityInstance, TapeItems, TapeToken};
use super::text::decode;
use crate::cad::Refusal;

/// Characters of a text that are kept.
const MAX_TEXT: usize = 200;

/// Bytes of a text that are read: with its directive, no character has more than 16.
const MAX_TEXT_BYTES: usize = 16 * MAX_TEXT;

/// The first bytes of a text, to the end of a character of UTF-8.
fn first_bytes(text: &[u8]) -> &[u8] {
    let is_end = |at: &usize| text.get(*at).is_none_or(|b| b & 0xc0 != 0x80);
    let end = (MAX_TEXT_BYTES - 3..=MAX_TEXT_BYTES).rev().find(is_end).unwrap_or(MAX_TEXT_BYTES);
    text.get(..end).unwrap_or(text)
}

/// An instance of a file.
#[derive(Clone, Copy, Debug)]
pub(in crate::step) struct Entity<'a> {
    pub(super) file: &'a ExchangeFile<'a>,
    pub(super) instance: EntityInstance,
}

impl<'a> Entity<'a> {
    /// Its number.
    pub(in crate::step) fn id(&self) -> EntityId {
        EntityId(self.instance.number)
    }

    /// Its type; [`Keyword::Complex`] if it has several.
    pub(in crate::step) fn keyword(&self) -> Keyword {
        self.instance.keyword
    }

    /// Its types: one, or those of a complex instance.
    pub(in crate::step) fn kinds(&self) -> impl Iterator<Item = Keyword> {
        let (file, instance) = (self.file, self.instance);
        let is_complex = instance.keyword == Keyword::Complex;
        let parts = is_complex.then(|| file.items(instance.first)).into_iter().flatten();
        let parts = parts.filter_map(move |at| match file.token(at) {
            TapeToken::Typed { keyword, .. } => Some(keyword),
            _ => None,
        });
        (!is_complex).then_some(instance.keyword).into_iter().chain(parts)
    }

    /// Whether it is of a type.
    pub(in crate::step) fn is(&self, keyword: Keyword) -> bool {
        self.kinds().any(|kind| kind == keyword)
    }

    /// The name of its type in the file.
    pub(in crate::step) fn type_name(&self) -> String {
        let bytes = self.file.bytes.get(self.instance.offset as usize..).unwrap_or_default();
        let start = bytes.iter().position(|&b| b == b'=').map_or(0, |i| i + 1);
        let is_letter = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
        let name = bytes.iter().skip(start).skip_while(|b| !is_letter(b)).take_while(|b| is_letter(b));
        let name: String = name.take(80).map(|b| char::from(*b)).collect();
        if self.keyword() == Keyword::Complex { format!("({name} ...)") } else { name }
    }

    /// A refusal of this entity.
    pub(in crate::step) fn refuse(&self, reason: impl Into<String>) -> Refusal {
        Refusal::new(self.id(), reason)
    }

    /// A refusal of this entity for its type, where another was `expected`.
    pub(in crate::step) fn refuse_type(&self, expected: &str) -> Refusal {
        self.refuse(format!("{} is no {expected} that can be read", self.type_name()))
    }

    /// Its attributes. Those of a complex instance are in several lists, by type: `parts` are the types whose attributes follow one
    /// another in a simple instance.
    pub(in crate::step) fn attributes(&self, parts: &[Keyword]) -> EntityAttributes<'a> {
        let (file, first) = (self.file, self.instance.first);
        let mut attributes = EntityAttributes { file, entity: self.id(), positions: [0; 16], count: 0 };
        if self.keyword() == Keyword::Complex {
            for part in parts {
                let of_part = |at: &u32| matches!(file.token(*at), TapeToken::Typed { keyword, .. } if keyword == *part);
                match file.items(first).find(of_part) {
                    Some(at) => attributes.extend(file.items(at)),
                    // A forgotten name; behind the tape there are missing parameters.
                    None if *part == Keyword::RepresentationItem => attributes.push(u32::MAX),
                    None => {}
                }
            }
        } else {
            attributes.extend(file.items(first));
        }
        attributes
    }

    /// Its attributes, where a complex instance cannot occur or is of no use.
    pub(in crate::step) fn simple(&self) -> EntityAttributes<'a> {
        self.attributes(&[self.keyword()])
    }
}

/// The attributes of an entity, by their positions in its definition.
#[derive(Clone, Copy, Debug)]
pub(in crate::step) struct EntityAttributes<'a> {
    file: &'a ExchangeFile<'a>,
    entity: EntityId,
    /// On the tape.
    positions: [u32; 16],
    count: usize,
}

impl<'a> EntityAttributes<'a> {
    fn extend(&mut self, items: TapeItems<'_>) {
        items.take(self.positions.len()).for_each(|at| self.push(at));
    }

    fn push(&mut self, at: u32) {
        if let Some(position) = self.positions.get_mut(self.count) {
            *position = at;
            self.count += 1;
        }
    }

    fn position(&self, i: usize) -> Result<u32, Refusal> {
        let position = self.positions.get(i).filter(|_| i < self.count).copied();
        position.ok_or_else(|| self.refuse(format!("attribute {} is missing", i + 1)))
    }

    /// The number of the entity.
    pub(in crate::step) fn id(&self) -> EntityId {
        self.entity
    }

    /// A refusal of the entity.
    pub(in crate::step) fn refuse(&self, reason: impl Into<String>) -> Refusal {
        Refusal::new(self.entity, reason)
    }

    fn mismatch(&self, i: usize, expected: &str) -> Refusal {
        self.refuse(format!("attribute {} must be {expected}", i + 1))
    }

    /// Number of attributes, at most 16.
    pub(in crate::step) fn len(&self) -> usize {
        self.count
    }

    /// Whether an attribute is `$`, `*` or not there at all.
    pub(in crate::step) fn is_missing(&self, i: usize) -> bool {
        let token = self.position(i).map(|at| self.file.token(at));
        matches!(token, Err(_) | Ok(TapeToken::Missing | TapeToken::Derived))
    }

    /// The entity to which an attribute refers.
    pub(in crate::step) fn reference(&self, i: usize) -> Result<Entity<'a>, Refusal> {
        self.referred(self.position(i)?).map_err(|refusal| match refusal {
            None => self.mismatch(i, "a reference"),
            Some(number) => self.refuse(format!("#{number} does not exist")),
        })
    }

    /// The entity at a position of the tape; an error has the number that does not exist.
    fn referred(&self, at: u32) -> Result<Entity<'a>, Option<u64>> {
        match self.file.token(at) {
            TapeToken::Reference(number) => self.file.find(number).ok_or(Some(number)),
            _ => Err(None),
        }
    }

    /// The entity to which an attribute refers, if it is given.
    pub(in crate::step) fn optional_reference(&self, i: usize) -> Result<Option<Entity<'a>>, Refusal> {
        if self.is_missing(i) { Ok(None) } else { self.reference(i).map(Some) }
    }

    /// The entities in a list.
    pub(in crate::step) fn references(
        &self,
        i: usize,
    ) -> Result<impl Iterator<Item = Result<Entity<'a>, Refusal>> + use<'a>, Refusal> {
        let this = *self;
        Ok(self.list(i)?.map(move |at| this.reference_at(at)))
    }

    /// The entity to which an item of a list refers.
    pub(in crate::step) fn reference_at(&self, at: u32) -> Result<Entity<'a>, Refusal> {
        self.referred(at).map_err(|number| match number {
            None => self.refuse("an item of a list must be a reference"),
            Some(number) => self.refuse(format!("#{number} does not exist")),
        })
    }

    /// The positions of the items of a list.
    pub(in crate::step) fn list(&self, i: usize) -> Result<TapeItems<'a>, Refusal> {
        let at = self.position(i)?;
        match self.file.token(at) {
            TapeToken::List { .. } => Ok(self.file.items(at)),
            _ => Err(self.mismatch(i, "a list")),
        }
    }

    /// The positions of the items of a list in a list.
    pub(in crate::step) fn sublist(&self, at: u32) -> TapeItems<'a> {
        self.file.items(at)
    }

    /// The token at the position of an item.
    pub(in crate::step) fn token(&self, at: u32) -> TapeToken {
        self.file.token(at)
    }

    /// The number at a position of the tape; also of a typed parameter, and an integer in the place of a real number.
    pub(in crate::step) fn number_at(&self, at: u32) -> Option<f64> {
        match self.file.token(at) {
            TapeToken::Real(real) => Some(real),
            TapeToken::Integer(integer) => Some(integer as f64),
            TapeToken::Typed { .. } => match self.file.token(at + 1) {
                TapeToken::Real(real) => Some(real),
                TapeToken::Integer(integer) => Some(integer as f64),
                _ => None,
            },
            _ => None,
        }
    }

    /// A number.
    pub(in crate::step) fn number(&self, i: usize) -> Result<f64, Refusal> {
        self.number_at(self.position(i)?).ok_or_else(|| self.mismatch(i, "a number"))
    }

    /// The numbers in a list.
    pub(in crate::step) fn numbers(&self, i: usize) -> Result<Vec<f64>, Refusal> {
        let numbers = self.list(i)?.map(|at| self.number_at(at)).collect::<Option<_>>();
        numbers.ok_or_else(|| self.mismatch(i, "a list of numbers"))
    }

    /// A number from 0, not larger than 2^32.
    pub(in crate::step) fn count(&self, i: usize) -> Result<usize, Refusal> {
        match self.file.token(self.position(i)?) {
            TapeToken::Integer(integer) => u32::try_from(integer).map(|count| count as usize).ok(),
            _ => None,
        }
        .ok_or_else(|| self.mismatch(i, "an integer from 0"))
    }

    /// The numbers from 0 in a list.
    pub(in crate::step) fn counts(&self, i: usize) -> Result<Vec<usize>, Refusal> {
        let count = |at| match self.file.token(at) {
            TapeToken::Integer(integer) => u32::try_from(integer).ok().map(|count| count as usize),
            _ => None,
        };
        let counts = self.list(i)?.map(count).collect::<Option<_>>();
        counts.ok_or_else(|| self.mismatch(i, "a list of integers from 0"))
    }

    /// The word of an enumeration.
    pub(in crate::step) fn enumeration(&self, i: usize) -> Option<&'a [u8]> {
        match self.file.token(self.position(i).ok()?) {
            TapeToken::Enumeration(span) => Some(self.file.text(span)),
            _ => None,
        }
    }

    /// `.T.` or `.F.`.
    pub(in crate::step) fn boolean(&self, i: usize) -> Result<bool, Refusal> {
        match self.enumeration(i) {
            Some(b"T" | b"TRUE") => Ok(true),
            Some(b"F" | b"FALSE") => Ok(false),
            _ => Err(self.mismatch(i, ".T. or .F.")),
        }
    }

    /// A text, of which the first 200 characters are kept: many entities may share it, each with a copy. Empty if there is none.
    pub(in crate::step) fn text(&self, i: usize) -> String {
        match self.position(i).map(|at| self.file.token(at)) {
            Ok(TapeToken::Text(span)) => {
                let text = decode(first_bytes(self.file.text(span)));
                text.trim().chars().take(MAX_TEXT).collect()
            }
            _ => String::new(),
        }
    }
}
