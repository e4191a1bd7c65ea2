//! Body of an upload: a line of JSON that lists the files, then their bytes.

use std::future::poll_fn;
use std::io::Write;
use std::pin::Pin;

use axum::body::{Body, Bytes, HttpBody};

use super::UploadError;

/// Body of an upload as it arrives. Only what arrived together is in memory.
pub(super) struct UploadBody {
    body: Body,
    /// Bytes that have arrived and were not taken.
    rest: Bytes,
}

impl UploadBody {
    pub(super) fn new(body: Body) -> Self {
        Self { body, rest: Bytes::new() }
    }

    /// Takes the first line, `[["NAME", SIZE], ...]`: name and bytes of each file.
    ///
    /// # Errors
    /// A line of more than `max_bytes`, or that is no such list; a body that ends before it.
    pub(super) async fn list(&mut self, max_bytes: usize) -> Result<Vec<(String, usize)>, UploadError> {
        let mut line = Vec::new();
        while line.last() != Some(&b'\n') {
            self.fill().await?;
            let end = self.rest.iter().position(|&byte| byte == b'\n').map_or(self.rest.len(), |at| at + 1);
            line.extend_from_slice(&self.rest.split_to(end));
            if line.len() > max_bytes {
                return Err(UploadError::too_large(format!(
                    "the list of files has more than {max_bytes} bytes"
                )));
            }
        }
        serde_json::from_slice(&line)
            .map_err(|error| UploadError::bad(format!("the list of files cannot be read: {error}")))
    }

    /// Writes the next `size` bytes to `target` as they arrive.
    ///
    /// # Errors
    /// A body that ends before, or the error of `target`.
    pub(super) async fn copy(&mut self, mut size: usize, target: &mut impl Write) -> Result<(), UploadError> {
        while size > 0 {
            self.fill().await?;
            let chunk = self.rest.split_to(size.min(self.rest.len()));
            // Small writes into the cache of the system do not need a blocking thread.
            target.write_all(&chunk)?;
            size -= chunk.len();
        }
        Ok(())
    }

    /// Waits until there are bytes to take.
    async fn fill(&mut self) -> Result<(), UploadError> {
        while self.rest.is_empty() {
            let frame = poll_fn(|context| Pin::new(&mut self.body).poll_frame(context)).await;
            let frame = frame
                .ok_or_else(|| UploadError::bad("the upload ends before its last file"))?
                .map_err(|error| UploadError::bad(error.to_string()))?;
            self.rest = frame.into_data().unwrap_or_default();
        }
        Ok(())
    }
}
