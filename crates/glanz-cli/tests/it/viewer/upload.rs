//! Uploads as pages send them.

use super::http::{self, Answer};

/// A file: its name and its bytes.
pub(crate) type UploadedFile = (String, Vec<u8>);

/// A scene of a ball.
pub(crate) const BALL: &str = "LookAt 0 -4 0  0 0 0  0 0 1\nCamera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\nShape \"sphere\"\n";

/// The request that opens files on the page of a session.
pub(crate) fn request(host: &str, session: &str, files: &[UploadedFile]) -> Vec<u8> {
    let sizes: Vec<(&str, usize)> = files.iter().map(|(name, bytes)| (name.as_str(), bytes.len())).collect();
    let mut body = format!("{}\n", serde_json::json!(sizes)).into_bytes();
    files.iter().for_each(|(_, bytes)| body.extend(bytes));
    let mut request = head(host, session, body.len() as u64).into_bytes();
    request.extend(body);
    request
}

/// The headers of such a request with a body of so many bytes.
pub(crate) fn head(host: &str, session: &str, bytes: u64) -> String {
    format!(
        "POST /open?session={session} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n\
         Content-Length: {bytes}\r\nConnection: close\r\n\r\n"
    )
}

/// Opens files on the page of a session.
///
/// # Errors
/// As [`http::send`].
pub(crate) fn open(host: &str, session: &str, files: &[UploadedFile]) -> std::io::Result<Answer> {
    http::send(host, &request(host, session, files))
}

/// A file of text.
pub(crate) fn text_file(name: &str, text: &str) -> UploadedFile {
    (name.to_owned(), text.as_bytes().to_vec())
}

/// Arguments of a server that does not end [`endless_includes`] by the number of files.
pub(crate) const ANY_FILES: [&str; 2] = ["--limit", "files=1e12"];

/// Files of 1.4 kB of which each includes the next one twice, 2^30 times the last one: to read them takes far longer than the minute that the server
/// grants, if it has the arguments [`ANY_FILES`].
pub(crate) fn endless_includes() -> Vec<UploadedFile> {
    let mut files = vec![text_file("room.pbrt", "WorldBegin\nInclude \"0.pbrt\"\n")];
    files.extend((0..30).map(|level| {
        text_file(&format!("{level}.pbrt"), &format!("Include \"{}.pbrt\"\n", level + 1).repeat(2))
    }));
    files.push(text_file("30.pbrt", "#\n"));
    files
}
