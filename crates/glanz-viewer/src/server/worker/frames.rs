//! Frames of bytes between the server and the process of an opened scene.

use std::io;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;

use crate::stream::MAX_SIDE;

/// Largest frame, bytes: a saved picture of the largest size with twelve floats in each pixel (three channels each of colour, variance, albedo and normal),
/// and its header.
pub(crate) const MAX_FRAME: u32 = 48 * MAX_SIDE * MAX_SIDE + (1 << 20);

/// Kinds of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameKind {
    /// The scene is read and its model written: its name.
    Opened = 0,
    /// The scene cannot be read: the messages of the reader.
    Refused = 1,
    /// A text message of the page, or for it.
    Text = 2,
    /// A binary message for the page.
    Binary = 3,
}

/// A frame: five bytes (the number of bytes, little-endian, and the kind), then the bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct WorkerFrame {
    pub(crate) kind: FrameKind,
    pub(crate) bytes: Vec<u8>,
}

impl WorkerFrame {
    /// Its bytes as text.
    pub(crate) fn into_text(self) -> String {
        String::from_utf8(self.bytes)
            .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned())
    }
}

/// Writes a frame.
///
/// # Errors
/// The error of `target`, or a frame beyond the limit.
pub(crate) async fn write_frame(
    target: &mut (impl AsyncWrite + Unpin),
    frame: &WorkerFrame,
) -> io::Result<()> {
    let length = u32::try_from(frame.bytes.len()).ok().filter(|length| *length <= MAX_FRAME);
    let length = length.ok_or_else(|| io::Error::other("the message is too long"))?;
    let [a, b, c, d] = length.to_le_bytes();
    target.write_all(&[a, b, c, d, frame.kind as u8]).await?;
    target.write_all(&frame.bytes).await
}

/// Reads a frame; `None` at the end, and at a frame that breaks the rules.
async fn read_frame(source: &mut (impl AsyncRead + Unpin)) -> Option<WorkerFrame> {
    let mut header = [0; 5];
    source.read_exact(&mut header).await.ok()?;
    let [a, b, c, d, kind] = header;
    let kind = match kind {
        0 => FrameKind::Opened,
        1 => FrameKind::Refused,
        2 => FrameKind::Text,
        3 => FrameKind::Binary,
        _ => return None,
    };
    let length = u32::from_le_bytes([a, b, c, d]);
    if length > MAX_FRAME {
        return None;
    }
    // Memory is taken for bytes that have arrived only.
    let mut bytes = Vec::new();
    source.take(length.into()).read_to_end(&mut bytes).await.ok()?;
    (bytes.len() as u64 == u64::from(length)).then_some(WorkerFrame { kind, bytes })
}

/// Starts a task that reads the frames of `source` until it ends or nobody receives them. One frame waits at a time, so that a writer is not faster than
/// the receiver.
pub(crate) fn receive_frames(
    mut source: impl AsyncRead + Unpin + Send + 'static,
) -> (mpsc::Receiver<WorkerFrame>, JoinHandle<()>) {
    let (sender, receiver) = mpsc::channel(1);
    let task = tokio::spawn(async move {
        while let Some(frame) = read_frame(&mut source).await {
            if sender.send(frame).await.is_err() {
                return;
            }
        }
    });
    (receiver, task)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block_on<T>(future: impl Future<Output = T>) -> T {
        tokio::runtime::Builder::new_current_thread().build().unwrap().block_on(future)
    }

    #[test]
    fn frames_are_read_as_they_are_written() {
        let frames = [
            WorkerFrame { kind: FrameKind::Opened, bytes: b"a.pbrt".to_vec() },
            WorkerFrame { kind: FrameKind::Refused, bytes: vec![] },
            WorkerFrame { kind: FrameKind::Text, bytes: "\u{e4}".into() },
            WorkerFrame { kind: FrameKind::Binary, bytes: vec![7; 100_000] },
        ];
        block_on(async {
            let mut bytes = Vec::new();
            for frame in &frames {
                write_frame(&mut bytes, frame).await.unwrap();
            }
            assert_eq!(&bytes[..11], b"\x06\0\0\0\0a.pbrt");
            let mut rest = bytes.as_slice();
            for frame in frames {
                assert_eq!(read_frame(&mut rest).await, Some(frame));
            }
            assert_eq!(read_frame(&mut rest).await, None);
        });
    }

    #[test]
    fn bytes_that_break_the_rules_are_no_frames() {
        let mut long = (MAX_FRAME + 1).to_le_bytes().to_vec();
        long.push(2);
        long.resize(100, b' ');
        for bytes in
            [&b"\x01\0\0"[..], b"\x02\0\0\0\x02x", b"\x01\0\0\0\x04x", b"\xff\xff\xff\xff\x02", &long]
        {
            let mut rest = bytes;
            assert_eq!(block_on(read_frame(&mut rest)), None, "{bytes:?}");
        }
        let long = WorkerFrame { kind: FrameKind::Binary, bytes: vec![0; MAX_FRAME as usize + 1] };
        assert!(block_on(write_frame(&mut Vec::new(), &long)).is_err());
    }
}
