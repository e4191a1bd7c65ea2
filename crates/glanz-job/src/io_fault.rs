//! Errors of the operating system in words.

use std::fmt;
use std::io::{self, ErrorKind};

/// A common error of reading or writing a file, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IoFault {
    /// What is wrong.
    pub fact: &'static str,
    /// What to do.
    pub advice: &'static str,
}

impl IoFault {
    /// The fault of an error; `None` for one whose own text suffices.
    #[must_use]
    pub fn of(error: &io::Error) -> Option<Self> {
        let (fact, advice) = match error.kind() {
            ErrorKind::StorageFull => {
                ("the disk is full", "free some space on the disk, or choose a file on another one")
            }
            ErrorKind::QuotaExceeded => (
                "your share of the disk is used up",
                "delete files of yours on this disk, or choose a file on another one",
            ),
            ErrorKind::FileTooLarge => (
                "the file becomes larger than the system permits",
                "raise the limit of this shell (ulimit -f), or choose a file on another file system",
            ),
            ErrorKind::ReadOnlyFilesystem => (
                "the file system is read-only",
                "choose a file on another disk, or mount this one for writing",
            ),
            ErrorKind::InvalidFilename => {
                ("the name is too long for the file system, or invalid", "choose a shorter name")
            }
            _ => Self::of_number(error.raw_os_error()?)?,
        };
        Some(Self { fact, advice })
    }

    /// Fact and advice of errors that have no kind of their own.
    #[cfg(unix)]
    fn of_number(number: i32) -> Option<(&'static str, &'static str)> {
        // These three have the same numbers on all systems.
        const EIO: i32 = 5;
        const ENFILE: i32 = 23;
        const EMFILE: i32 = 24;
        match number {
            EIO => Some((
                "the disk or its connection fails",
                "check the disk and the system's log; choose a file on another disk",
            )),
            ENFILE | EMFILE => Some((
                "too many files are open at once",
                "raise the limit of this shell (ulimit -n), or end other programs",
            )),
            _ => None,
        }
    }

    #[cfg(not(unix))]
    fn of_number(_: i32) -> Option<(&'static str, &'static str)> {
        None
    }

    /// The error in words with the system's text in brackets, or that text alone.
    #[must_use]
    pub fn sentence(error: &io::Error) -> impl fmt::Display {
        let fact = Self::of(error).map(|fault| fault.fact);
        fact.map_or_else(|| error.to_string(), |fact| format!("{fact} ({error})"))
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn errors_of_disks_and_limits_have_words_and_advice() {
        // ENOSPC, EFBIG, EROFS, EIO, EMFILE have the same numbers on all Unix systems.
        for (number, words) in
            [(28, "full"), (27, "larger"), (30, "read-only"), (5, "fails"), (24, "too many")]
        {
            let error = io::Error::from_raw_os_error(number);
            let fault = IoFault::of(&error).unwrap();
            assert!(fault.fact.contains(words) && !fault.advice.is_empty(), "{error}");
            let sentence = IoFault::sentence(&error).to_string();
            assert_eq!(sentence, format!("{} ({error})", fault.fact));
        }
        #[cfg(target_os = "linux")]
        for (number, words) in [(122, "share"), (36, "too long")] {
            assert!(IoFault::of(&io::Error::from_raw_os_error(number)).unwrap().fact.contains(words));
        }
        // ENOENT and EACCES speak for themselves.
        for number in [2, 13] {
            let error = io::Error::from_raw_os_error(number);
            assert_eq!(IoFault::of(&error), None);
            assert_eq!(IoFault::sentence(&error).to_string(), error.to_string());
        }
    }
}
