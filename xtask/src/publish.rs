//! Whether every crate can be published.

use crate::suite::succeed;
use crate::workspace;

/// Packages all crates, builds each from its package, and stops before the upload.
///
/// # Errors
/// A text if one cannot be packaged or its package does not build.
pub(crate) fn dry_run() -> Result<String, String> {
    let mut command = workspace::cargo(["publish", "--workspace", "--dry-run", "--allow-dirty"]);
    succeed(&mut command, "a crate cannot be published, see above")
        .map(|()| "every crate is packaged and builds from its package".to_owned())
}
