//! The model of an opened scene, in a file.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};

use axum::body::{Body, Bytes, HttpBody};
use hyper::body::{Frame, SizeHint};

/// Bytes that are read at a time.
const PIECE: u64 = 1 << 16;

/// A file that the process of a scene writes and the server sends. It is opened before the process starts, which therefore cannot make the server
/// send another one, and its bytes need no memory of the server.
#[derive(Clone, Debug)]
pub(super) struct ModelFile(Arc<Mutex<File>>);

impl ModelFile {
    /// Makes an empty file.
    ///
    /// # Errors
    /// The error of the system.
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(path)?;
        Ok(Self(Arc::new(Mutex::new(file))))
    }

    /// Removes the bytes of the file; bodies that are not yet complete fail.
    pub(super) fn clear(&self) {
        // What stays is removed when the last body ends.
        let _ = self.0.lock().unwrap_or_else(PoisonError::into_inner).set_len(0);
    }

    /// The bytes of the file, as they are now, as a body.
    pub(super) fn body(&self) -> Body {
        let file = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let rest = file.metadata().map_or(0, |about| about.len());
        drop(file);
        Body::new(ModelBody { file: self.clone(), position: 0, rest })
    }

    /// Some of the bytes at a position, at most `most`.
    fn read(&self, position: u64, most: u64) -> io::Result<Bytes> {
        let mut file = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(position))?;
        let mut piece = Vec::new();
        Read::by_ref(&mut *file).take(most).read_to_end(&mut piece)?;
        match piece.is_empty() {
            true => Err(io::ErrorKind::UnexpectedEof.into()),
            false => Ok(piece.into()),
        }
    }
}

/// Rest of a model file.
struct ModelBody {
    file: ModelFile,
    position: u64,
    /// Bytes to come.
    rest: u64,
}

impl HttpBody for ModelBody {
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        _: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, io::Error>>> {
        if self.rest == 0 {
            return Poll::Ready(None);
        }
        // Small reads of what was just written come from memory and do not need a blocking thread.
        let piece = self.file.read(self.position, self.rest.min(PIECE));
        if let Ok(piece) = &piece {
            self.position += piece.len() as u64;
            self.rest -= piece.len() as u64;
        }
        Poll::Ready(Some(piece.map(Frame::data)))
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::with_exact(self.rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_have_the_bytes_of_the_file_each_for_itself() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("model");
        let file = ModelFile::create(&path).unwrap();
        assert!(ModelFile::create(&path).is_err(), "a file of that name is there");
        let bytes: Vec<u8> = (0..200_000_u32).map(|i| (i % 251) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        // As long as the file is open it can be read, whatever is at its path.
        std::fs::remove_file(&path).unwrap();
        std::fs::write(&path, "other").unwrap();
        let mut bodies = [file.body(), file.body()];
        let mut found = [vec![], vec![]];
        let mut context = Context::from_waker(std::task::Waker::noop());
        for _ in 0..bytes.len().div_ceil(PIECE as usize) {
            for (body, found) in bodies.iter_mut().zip(&mut found) {
                let Poll::Ready(Some(Ok(frame))) = Pin::new(body).poll_frame(&mut context) else {
                    panic!("a piece")
                };
                found.extend_from_slice(&frame.into_data().unwrap());
            }
        }
        assert!(found.iter().all(|found| *found == bytes));
        assert!(matches!(Pin::new(&mut bodies[0]).poll_frame(&mut context), Poll::Ready(None)));
        let mut late = file.body();
        file.clear();
        assert!(matches!(Pin::new(&mut late).poll_frame(&mut context), Poll::Ready(Some(Err(_)))));
    }
}
