//! Directives that begin and end blocks.

use glanz_math::DMat4;

use super::{OpenBlock, Parser};
use crate::pbrt::state::{BlockLevel, MAX_NESTING, SavedState};
use crate::source::{ParseResult, Span};

impl Parser {
    pub(super) fn begin_world(&mut self) {
        self.block = OpenBlock::World;
        self.state.now.ctm = DMat4::IDENTITY;
        self.state.now.start_active = true;
        self.state.named_frames.insert("world".to_owned(), DMat4::IDENTITY);
    }

    pub(super) fn block_directive(&mut self, word: &str, place: Span) -> ParseResult<()> {
        match word {
            "WorldBegin" => {
                if self.block != OpenBlock::Options {
                    let message = "WorldBegin, but the world has begun already";
                    return Err(self.lowering.reporter.error(&place, "nesting", message));
                }
                self.begin_world();
            }
            "WorldEnd" => {
                if self.block == OpenBlock::Options {
                    let message = "WorldEnd without WorldBegin";
                    return Err(self.lowering.reporter.error(&place, "nesting", message));
                }
                self.block = OpenBlock::Done;
            }
            "AttributeBegin" => {
                let saved = SavedState::All(self.state.now.clone());
                self.open_level("AttributeBegin", place, saved)?;
            }
            "TransformBegin" => {
                let saved = SavedState::Transform(self.state.now.ctm, self.state.now.start_active);
                self.open_level("TransformBegin", place, saved)?;
            }
            "ObjectBegin" => {
                let (name, _) = self.name(word, &place)?;
                let saved = SavedState::All(self.state.now.clone());
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

    fn open_level(&mut self, opened_by: &'static str, place: Span, saved: SavedState) -> ParseResult<()> {
        if self.state.levels.len() >= MAX_NESTING {
            let message = format!("{opened_by} is nested more than {MAX_NESTING} deep");
            return Err(self.lowering.reporter.error(&place, "nesting", message));
        }
        self.state.levels.push(BlockLevel { opened_by, place, saved });
        Ok(())
    }

    fn close_level(&mut self, opened_by: &str, word: &str, place: Span) -> ParseResult<()> {
        // An imported file must not close blocks that were opened before it.
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
}
