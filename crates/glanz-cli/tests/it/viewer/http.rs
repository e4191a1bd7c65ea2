//! Plain HTTP, as raw as a test wants it.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// How long a server may keep silent before it is given up.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);

/// What a server answers.
pub(crate) struct Answer {
    /// 0: it closed the connection without a word.
    pub(crate) status: u16,
    /// The status line and the headers.
    pub(crate) head: String,
    pub(crate) body: Vec<u8>,
}

/// Sends bytes, and takes in the answer, as long as it says to be or until the server closes.
///
/// # Errors
/// What the system says if there is nobody, or nothing comes for long.
pub(crate) fn send(host: &str, bytes: &[u8]) -> std::io::Result<Answer> {
    let mut stream = TcpStream::connect(host)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    // A server that refuses early closes while the rest is still on its way, and what it said may be lost with it.
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

/// Whether an answer has as many bytes as its head says.
fn is_whole(answer: &[u8]) -> bool {
    let Answer { head, body, .. } = parse(answer);
    let mut lines = head.lines().filter_map(|line| line.split_once(':'));
    let length = lines.find(|(name, _)| name.eq_ignore_ascii_case("content-length"));
    length
        .and_then(|(_, value)| value.trim().parse::<usize>().ok())
        .is_some_and(|length| body.len() >= length)
}

/// Asks for a path with GET.
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

/// Tells an answer that did not come in time from other errors.
pub(crate) fn is_timeout(error: &std::io::Error) -> bool {
    matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut)
}
