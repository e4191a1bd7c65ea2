//! Peak memory of reading hostile files under a limit, counted in bytes by the allocator of this program.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot write its files has failed"
)]

use std::path::{Path, PathBuf};

use glanz_formats::image::{Format, write, write_srgb8};
use glanz_formats::{Options, load};
use glanz_job::{Resource, ResourceLimits};
use glanz_light::{Pixels, Tone};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// The limit.
const MEMORY: usize = 64 << 20;

/// Bytes at the peak beyond the limit: per byte of all files, and in any case.
const BEYOND: [usize; 2] = [8, 1 << 20];

/// A scene with a texture from a file.
fn textured(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    std::fs::write(folder.join(name), bytes).unwrap();
    let scene = folder.join(format!("{name}.pbrt"));
    let text =
        format!("WorldBegin\nTexture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"{name}\"\n");
    std::fs::write(&scene, text).unwrap();
    scene
}

/// A flat PNG of 4000 x 4000 pixels: 48 MB in the decoder, 192 MB as planes.
fn png() -> Vec<u8> {
    write_srgb8(4000, 4000, &vec![[200; 3]; 4000 * 4000]).unwrap()
}

/// An OpenEXR file of some kilobytes whose header declares 16384 x 16384 pixels in lossy blocks, which may be that small.
fn exr() -> Vec<u8> {
    let small = Pixels::try_from_rgb(64, 64, &[[0.5; 3]; 64 * 64]).unwrap();
    let mut bytes = write(&small, Format::Exr, &Tone::default(), &Default::default()).unwrap();
    let after =
        |bytes: &[u8], mark: &[u8]| bytes.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
    for window in [&b"dataWindow\0box2i\0\x10\0\0\0"[..], b"displayWindow\0box2i\0\x10\0\0\0"] {
        let max = after(&bytes, window) + 8;
        bytes[max..max + 8].copy_from_slice(&[16383_i32.to_le_bytes(), 16383_i32.to_le_bytes()].concat());
    }
    let compression = after(&bytes, b"compression\0compression\0\x01\0\0\0");
    // DWAA.
    bytes[compression] = 8;
    bytes.resize(10_000, 0);
    bytes
}

/// Files that include one another twice per level, with a mesh each.
fn includes(folder: &Path) -> PathBuf {
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\n";
    for level in 0..31 {
        let next = format!("Include \"{}.pbrt\"\n", level + 1);
        std::fs::write(folder.join(format!("{level}.pbrt")), format!("{mesh}{next}{next}")).unwrap();
    }
    std::fs::write(folder.join("31.pbrt"), mesh).unwrap();
    folder.join("0.pbrt")
}

#[test]
fn hostile_files_stay_within_the_limit_of_memory() {
    let folder = tempfile::tempdir().unwrap();
    let [png, exr] = [png(), exr()];
    let cases = [
        ("png", textured(folder.path(), "a.png", &png), png.len()),
        ("exr", textured(folder.path(), "a.exr", &exr), exr.len()),
        ("includes", includes(folder.path()), 3200),
    ];
    drop((png, exr));
    let limits = ResourceLimits { memory: MEMORY as u64, ..ResourceLimits::default() };
    let options = Options { limits, ..Options::default() };
    for (name, scene, size) in cases {
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let end = load(&scene, &options).unwrap_err();
        let peak = ALLOCATOR.peak_usage() - before;
        println!("{name}: {size} bytes, {peak} bytes at the peak: {end}");
        assert_eq!(end.limit().map(|limit| limit.resource), Some(Resource::Memory), "{name}: {end}");
        let [per_byte, free] = BEYOND;
        assert!(peak <= MEMORY + per_byte * size + free, "{name}: {peak} bytes");
    }
}
