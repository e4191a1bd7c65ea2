//! Places of the library.

use std::ffi::OsStr;
use std::path::PathBuf;

/// Name of the environment variable with the folder of the library, or with the folder of its `lib`, `lib64` or `bin`.
pub const DIRECTORY_VARIABLE: &str = "OIDN_DIR";

#[cfg(target_os = "windows")]
const FILE_NAMES: [&str; 1] = ["OpenImageDenoise.dll"];
#[cfg(target_os = "macos")]
const FILE_NAMES: [&str; 2] = ["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"];
#[cfg(not(any(target_os = "windows", target_os = "macos")))]
const FILE_NAMES: [&str; 2] = ["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"];

/// The files to try, best first. With a `directory` those in it alone, so that a wrong one is noticed; otherwise names that the system looks up.
pub(crate) fn candidates(directory: Option<&OsStr>) -> Vec<PathBuf> {
    let Some(directory) = directory.filter(|directory| !directory.is_empty()) else {
        return FILE_NAMES.map(PathBuf::from).to_vec();
    };
    let directory = PathBuf::from(directory);
    let folders = [directory.clone(), directory.join("lib"), directory.join("lib64"), directory.join("bin")];
    folders.iter().flat_map(|folder| FILE_NAMES.map(|name| folder.join(name))).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn named_folder_is_searched_alone_with_those_of_its_libraries() {
        let found = candidates(Some(OsStr::new("folder")));
        assert!(found.iter().all(|path| path.starts_with("folder")));
        for inner in ["folder", "folder/lib", "folder/lib64", "folder/bin"] {
            assert!(found.iter().any(|path| path.parent() == Some(Path::new(inner))), "{inner}");
        }
    }

    #[test]
    fn without_a_folder_the_system_looks_the_name_up() {
        for directory in [None, Some(OsStr::new(""))] {
            let found = candidates(directory);
            assert!(!found.is_empty() && found.iter().all(|path| path.components().count() == 1));
        }
    }
}
