//! `.zae` archives that unpack to more than they should, or elsewhere.

use std::io::Write;

use zip::write::{SimpleFileOptions, ZipWriter};

use super::*;

fn pack(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, content) in members {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn manifest(root: &str) -> String {
    format!("<dae_root xmlns=\"x\">{root}</dae_root>")
}

#[test]
fn bombs_stop_at_the_limit() {
    let folder = Folder::new("zip-bombs");
    let small = ["--max-memory", "20M"];
    let zeros = vec![b' '; 50_000_000];
    let words = ["unpacks to more bytes than the limit"];
    refuses(&folder, pack(&[("a.dae", &zeros)]), &small, &words);
    refuses(&folder, pack(&[("manifest.xml", &zeros)]), &small, &words);
    let textured = room(&[(
        "<diffuse reflectance=\"0.5\"/>",
        "<diffuse reflectance=\"0.5\"><map for=\"reflectance\" image=\"a.png\"/></diffuse>",
    )]);
    refuses(&folder, pack(&[("a.dae", textured.as_bytes()), ("a.png", &zeros)]), &small, &words);

    // A size that the directory plays down is found out as it is unpacked.
    let mut liar = pack(&[("a.dae", &zeros)]);
    let size = 50_000_000u32.to_le_bytes();
    while let Some(at) = liar.windows(4).position(|bytes| bytes == size) {
        liar[at..at + 4].copy_from_slice(&1000u32.to_le_bytes());
    }
    refuses(&folder, liar, &small, &[]);
}

#[test]
fn nothing_outside_the_archive_is_read() {
    let folder = Folder::new("zip-paths");
    fs::copy(data("good/dot.png"), folder.file("dot.png")).unwrap();
    for root in ["../a.dae", "/etc/passwd", "x/../../a.dae", "%2e%2e/a.dae"] {
        let archive = pack(&[("manifest.xml", manifest(root).as_bytes()), ("a.dae", room(&[]).as_bytes())]);
        refuses(&folder, archive, &[], &["leads out of the archive"]);
    }
    for image in ["../dot.png", "dot.png"] {
        let map = format!("<diffuse reflectance=\"0.5\"><map for=\"reflectance\" image=\"{image}\"/></diffuse>");
        let textured = room(&[("<diffuse reflectance=\"0.5\"/>", &map)]);
        refuses(&folder, pack(&[("a.dae", textured.as_bytes())]), &[], &["of material `grey`"]);
    }
}

#[test]
fn broken_archives_are_refused() {
    let folder = Folder::new("zip-broken");
    let whole = pack(&[("manifest.xml", manifest("a.dae").as_bytes()), ("a.dae", room(&[]).as_bytes())]);
    for length in [4, 30, whole.len() / 2, whole.len() - 1] {
        refuses(&folder, &whole[..length], &[], &[]);
    }
    refuses(&folder, pack(&[]), &[], &[]);
    refuses(&folder, pack(&[("a.dae", b"x"), ("b.dae", b"x")]), &[], &["not exactly one .dae"]);
    refuses(&folder, pack(&[("manifest.xml", b"<a/>"), ("a.dae", b"x")]), &[], &["without <dae_root>"]);
    refuses(&folder, pack(&[("manifest.xml", manifest("b.dae").as_bytes())]), &[], &["does not contain"]);
    refuses(&folder, pack(&[("a.zae", &whole)]), &[], &["not exactly one .dae"]);
}
