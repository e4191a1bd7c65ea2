//! Identity of saved states.

use std::error::Error;
use std::fmt;

/// Version of this program, as saved states name it.
#[must_use]
pub fn current_version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// Everything the result of a job depends on, in words.
///
/// A saved state may be resumed, or joined with another, only under its own identity.
pub trait JobIdentity {
    /// Beginning of the message about a state of another identity: "it is of another picture".
    const FOREIGN: &'static str;

    /// Name and value of each field, the most important first: versions, hashes of the scene, settings.
    ///
    /// Fields are compared by these texts, so that a text has to show every bit of a number.
    fn fields(&self) -> Vec<(&'static str, String)>;

    /// Compares the identity of a saved state, `self`, with that of the job at hand.
    ///
    /// # Errors
    /// [`IdentityMismatch`] with the first field that differs.
    fn check(&self, wanted: &Self) -> Result<(), IdentityMismatch> {
        for ((what, found), (_, wanted)) in self.fields().into_iter().zip(wanted.fields()) {
            if found != wanted {
                return Err(IdentityMismatch { foreign: Self::FOREIGN, what, found, wanted });
            }
        }
        Ok(())
    }
}

/// The first field in which two identities differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdentityMismatch {
    /// [`JobIdentity::FOREIGN`] of the two.
    pub foreign: &'static str,
    /// Name of the field.
    pub what: &'static str,
    /// Its value in the saved state.
    pub found: String,
    /// Its value in the job at hand.
    pub wanted: String,
}

impl fmt::Display for IdentityMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { foreign, what, found, wanted } = self;
        write!(f, "{foreign}: {what} is {found}, not {wanted}")
    }
}

impl Error for IdentityMismatch {}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone)]
    struct SumIdentity {
        scene: u128,
        seed: u64,
    }

    impl JobIdentity for SumIdentity {
        const FOREIGN: &'static str = "it is of another sum";

        fn fields(&self) -> Vec<(&'static str, String)> {
            vec![("the scene", format!("{:x}", self.scene)), ("the seed", self.seed.to_string())]
        }
    }

    #[test]
    fn mismatch_names_the_first_field_that_differs() {
        let wanted = SumIdentity { scene: 0xa, seed: 1 };
        assert_eq!(wanted.clone().check(&wanted), Ok(()));
        let mismatch = SumIdentity { seed: 2, ..wanted }.check(&wanted).unwrap_err();
        assert_eq!(mismatch.to_string(), "it is of another sum: the seed is 2, not 1");
        let mismatch = SumIdentity { scene: 0xb, seed: 2 }.check(&wanted).unwrap_err();
        assert_eq!(
            (mismatch.what, mismatch.found.as_str(), mismatch.wanted.as_str()),
            ("the scene", "b", "a")
        );
    }
}
