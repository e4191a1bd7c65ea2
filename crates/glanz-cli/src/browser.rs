//! The user's browser.

use std::io;
use std::process::{Command, Stdio};

/// Commands that open an address, tried in turn; the address is their last argument.
#[cfg(target_os = "macos")]
const OPENERS: &[&[&str]] = &[&["open"]];
#[cfg(windows)]
const OPENERS: &[&[&str]] = &[&["rundll32", "url.dll,FileProtocolHandler"]];
#[cfg(not(any(target_os = "macos", windows)))]
const OPENERS: &[&[&str]] = &[&["wslview"], &["xdg-open"], &["gio", "open"], &["gnome-open"], &["kde-open"]];

/// Opens `address` in the browser, without waiting for it.
///
/// # Errors
/// The failure of the last command that was tried.
pub(crate) fn open(address: &str) -> io::Result<()> {
    let mut outcome = Err(io::Error::from(io::ErrorKind::Unsupported));
    for opener in OPENERS {
        let [program, arguments @ ..] = opener else { continue };
        let mut command = Command::new(program);
        command.args(arguments).arg(address);
        outcome =
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().map(|_| ());
        if outcome.is_ok() {
            break;
        }
    }
    outcome
}
