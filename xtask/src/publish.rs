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

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use crate::workspace::{files_below, root};

    /// A package holds only files of its crate's folder, so that crates have copies of the scenes that they contain.
    #[test]
    fn scenes_in_crates_are_those_of_the_repository() {
        let mut copies = 0;
        for extension in ["pbrt", "txt"] {
            for file in files_below(&root().join("crates"), extension) {
                let parts: Vec<_> = file.components().collect();
                let Some(at) = parts.iter().rposition(|part| part.as_os_str() == "scenes") else { continue };
                let original = root().join("scenes").join(parts[at + 1..].iter().collect::<PathBuf>());
                assert_eq!(
                    fs::read(&file).expect("a copy"),
                    fs::read(&original).expect("its original"),
                    "{}",
                    file.display()
                );
                copies += 1;
            }
        }
        assert!(copies > 0);
    }
}
