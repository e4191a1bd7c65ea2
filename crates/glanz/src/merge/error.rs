//! Errors of joining parts, with the paths of their files.

use std::fmt;
use std::path::PathBuf;

use glanz_job::{IdentityMismatch, JobPart};
use glanz_transport::FilmError;

use super::PartKind;

/// Parts that cannot be joined.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JoinError {
    /// No part can be read.
    #[error("there are no parts; at least one is needed")]
    Empty,
    /// Parts of different kinds.
    #[error("{} is a part of kind \"{}\" and {} one of kind \"{}\"", .parts[0].display(), .kinds[0], .parts[1].display(), .kinds[1])]
    Kinds {
        /// Two parts.
        parts: [PathBuf; 2],
        /// Their kinds.
        kinds: [PartKind; 2],
    },
    /// A picture was asked for, of parts of another kind.
    #[error("these are no parts of a picture, but of kind \"{kind}\"")]
    NoPicture {
        /// Their kind.
        kind: PartKind,
    },
    /// Parts of a kind that cannot be joined.
    #[error("parts of kind \"{kind}\" cannot be joined")]
    Unsupported {
        /// Their kind.
        kind: PartKind,
    },
    /// A part of another job than the first.
    #[error(
        "{} and {} are not parts of one {kind}: {} is {} in {} and {} in {}", .parts[0].display(), .parts[1].display(),
        .mismatch.what, .mismatch.wanted, .parts[0].display(), .mismatch.found, .parts[1].display()
    )]
    Identity {
        /// The kind of both.
        kind: PartKind,
        /// The first part, and the other.
        parts: [PathBuf; 2],
        /// The difference.
        mismatch: Box<IdentityMismatch>,
    },
    /// A part whose samples depend on earlier ones.
    #[error(
        "the samples of {} depend on earlier ones (a noise level, or a guide that was learnt during the render)", .part.display()
    )]
    Ordered {
        /// Its file.
        part: PathBuf,
    },
    /// The checkpoint of a whole job.
    #[error("{} is no part of a job, but the checkpoint of a whole one", .part.display())]
    NoPart {
        /// Its file.
        part: PathBuf,
    },
    /// Two parts with something in common.
    #[error("{} and {} both have {common}", .parts[0].display(), .parts[1].display())]
    Overlap {
        /// The parts.
        parts: [PathBuf; 2],
        /// What they share, such as "samples 0 to 31".
        common: String,
    },
    /// Parts of one job with different results for the same.
    #[error("{} and {} contradict each other in the {what}; they were computed by different programs", .parts[0].display(), .parts[1].display())]
    Contradiction {
        /// The parts; the first may be joined with others already.
        parts: [PathBuf; 2],
        /// What differs.
        what: &'static str,
    },
    /// A part whose film cannot be added to that of the first.
    #[error("{} cannot be joined with {}: {error}", .parts[1].display(), .parts[0].display())]
    Film {
        /// The first part, and the other.
        parts: [PathBuf; 2],
        /// The reason.
        error: FilmError,
    },
    /// The film of all parts cannot be created, or its temporary file failed.
    #[error("the parts cannot be joined: {0}")]
    Whole(FilmError),
    /// Parts that are not among those given.
    #[error(transparent)]
    Missing(MissingParts),
}

/// Parts of one job that are missing, or of which something is missing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct MissingParts(pub Vec<MissingPart>);

/// Number of missing parts that a message names.
const NAMED: usize = 8;

impl fmt::Display for MissingParts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, part) in self.0.iter().take(NAMED).enumerate() {
            write!(f, "{}{part}", if i == 0 { "" } else { "; " })?;
        }
        match self.0.len().saturating_sub(NAMED) {
            0 => Ok(()),
            others => write!(f, "; and {others} more parts"),
        }
    }
}

/// A part that is missing, or of which something is missing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingPart {
    /// The part.
    pub part: JobPart,
    /// What is missing of it, such as "samples 64..96".
    pub missing: String,
    /// Whether that is all of it.
    pub is_whole: bool,
}

impl fmt::Display for MissingPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { part, missing, is_whole } = self;
        match is_whole {
            true => write!(f, "part {part} ({missing}) is missing"),
            false => write!(f, "part {part} lacks {missing}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_parts_are_named_up_to_a_number() {
        let part = |number, is_whole| MissingPart {
            part: JobPart::try_new(number, 20).unwrap(),
            missing: format!("samples {}..{number}", number - 1),
            is_whole,
        };
        let two = MissingParts(vec![part(3, true), part(5, false)]);
        let text = "part 3/20 (samples 2..3) is missing; part 5/20 lacks samples 4..5";
        assert_eq!(two.to_string(), text);
        let text = MissingParts((1..=20).map(|number| part(number, true)).collect()).to_string();
        assert!(text.contains("part 8/20") && !text.contains("part 9/20"), "{text}");
        assert!(text.ends_with("is missing; and 12 more parts"), "{text}");
    }
}
