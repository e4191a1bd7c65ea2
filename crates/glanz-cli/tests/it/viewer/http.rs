//! HTTP requests as raw bytes.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// Time limit for data from the server.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);

/// The response of a server.
pub(crate) struct Answer {
    /// The status code; 0 if the server closed the connection without a response.
    pub(crate) status: u16,
    /// The status line and the headers.
    pub(crate) head: String,
    pub(crate) body: Vec<u8>,
}

/// Sends bytes and reads the response, up to its declared length or until the server closes the connection.
///
/// # Errors
/// The connection is refused, or no data arrive within the time limit.
pub(crate) fn send(host: &str, bytes: &[u8]) -> std::io::Result<Answer> {
    let mut stream = TcpStream::connect(host)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    // A server that refuses early closes the connection while data are still being sent, and its response may be lost.
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    let mut buffer = vec![0; 1 << 16];
    while !is_whole(&answer) {
        match stream.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => answer.extend(&buffer[..count]),
            Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => break,
            Err(error) => return Err(error),
        }
    }
    Ok(parse(&answer))
}

/// Whether a response is as long as its headers declare.
fn is_whole(answer: &[u8]) -> bool {
    let Answer { head, body, .. } = parse(answer);
    let mut lines = head.lines().filter_map(|line| line.split_once(':'));
    let length = lines.find(|(name, _)| name.eq_ignore_ascii_case("content-length"));
    length
        .and_then(|(_, value)| value.trim().parse::<usize>().ok())
        .is_some_and(|length| body.len() >= length)
}

/// Sends a GET request for a path.
///
/// # Errors
/// As [`send`].
pub(crate) fn get(host: &str, path: &str) -> std::io::Result<Answer> {
    send(host, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").as_bytes())
}

fn parse(answer: &[u8]) -> Answer {
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap_or(answer.len());
    let (head, rest) = answer.split_at(end);
    let head = String::from_utf8_lossy(head).into_owned();
    let status = head.split(' ').nth(1).and_then(|word| word.parse().ok()).unwrap_or(0);
    Answer { status, head, body: rest.get(4..).unwrap_or_default().to_vec() }
}

/// Whether an error is a time-out.
pub(crate) fn is_timeout(error: &std::io::Error) -> bool {
    matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut)
}
