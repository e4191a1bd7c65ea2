//! Files that were read wrongly once.

use super::{run, text};

#[test]
fn files_of_the_corpus_are_read_within_the_limits() {
    let (output, _) = run("corpus", &["--corpus"]);
    assert!(output.status.success(), "{}", text(&output));
    let entries: usize =
        glanz_fuzz::targets::targets().map(|target| glanz_fuzz::corpus::entries(target.name).len()).sum();
    assert!(
        entries > 10 && text(&output).contains(&format!("{entries} files, 0 with a fault")),
        "{}",
        text(&output)
    );
}

#[test]
fn every_folder_of_the_corpus_has_its_target() {
    for folder in ["corpus", "pending"] {
        let folders =
            std::fs::read_dir(glanz_fuzz::corpus::root().join(folder)).into_iter().flatten().flatten();
        for entry in folders.filter(|entry| entry.path().is_dir()) {
            let name = entry.file_name().into_string().unwrap();
            assert!(glanz_fuzz::targets::target(&name).is_some(), "{folder}/{name}");
        }
    }
}
