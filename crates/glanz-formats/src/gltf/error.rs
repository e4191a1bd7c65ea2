//! Errors of glTF files.

/// A fault of a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{message}", pointer.as_ref().map(|pointer| format!("{pointer}: ")).unwrap_or_default())]
pub(super) struct GltfError {
    /// JSON pointer to the value at fault; `None`: the file as a whole.
    pub(super) pointer: Option<String>,
    /// The fault, and the remedy if there is one.
    pub(super) message: String,
}

impl GltfError {
    /// A fault of the file as a whole.
    pub(super) fn of_file(message: impl Into<String>) -> Self {
        Self { pointer: None, message: message.into() }
    }
}
