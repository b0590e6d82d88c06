//! The house rules: rooms know only the rooms above them, unsafe lives in two rooms, files stay readable.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Lines beyond which a file makes its reader scroll for minutes.
const LONGEST_FILE: usize = 500;

fn source_files() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![root.clone()];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                files.push((path.strip_prefix(&root).unwrap().to_owned(), text));
            }
        }
    }
    files
}

/// The room a file belongs to: its folder in src/, or its own name.
fn room(file: &Path) -> String {
    let first = file.components().next().unwrap().as_os_str().to_string_lossy();
    first.trim_end_matches(".rs").to_owned()
}

#[test]
fn rooms_know_only_the_rooms_before_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs");
    let order: BTreeMap<String, usize> = fs::read_to_string(root)
        .unwrap()
        .lines()
        .filter_map(|line| line.strip_prefix("pub mod "))
        .enumerate()
        .map(|(i, name)| (name.trim_end_matches(';').to_owned(), i))
        .collect();
    let mut broken = Vec::new();
    for (file, text) in source_files() {
        let here = room(&file);
        let Some(&rank) = order.get(&here) else { continue };
        for (number, line) in text.lines().enumerate() {
            let mentions = line.split("crate::").skip(1).filter(|_| !line.trim_start().starts_with("//"));
            for other in mentions {
                let name: String = other.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if order.get(&name).is_some_and(|&r| r > rank) {
                    broken.push(format!("{}:{}: {here} knows {name}", file.display(), number + 1));
                }
            }
        }
    }
    assert!(order.len() > 8, "lib.rs lists the rooms one per line");
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn unsafe_lives_where_c_is_spoken_and_gives_its_reasons() {
    // Embree is linked, the denoiser looked up as the program runs: neither has a safe interface.
    const ROOMS: [&str; 2] = ["embree", "denoise"];
    for (file, text) in source_files() {
        let lines: Vec<&str> = text.lines().collect();
        for (i, line) in lines.iter().enumerate() {
            let code = line.split("//").next().unwrap();
            if !code.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == "unsafe") {
                continue;
            }
            assert!(ROOMS.contains(&room(&file).as_str()), "{}:{}: unsafe", file.display(), i + 1);
            let reasoned =
                lines[i.saturating_sub(9)..i].iter().any(|l| l.contains("SAFETY:") || l.contains("# Safety"));
            assert!(reasoned, "{}:{}: unsafe without a SAFETY comment", file.display(), i + 1);
        }
    }
}

#[test]
fn files_stay_readable() {
    let long: Vec<String> = source_files()
        .iter()
        .filter(|(_, text)| text.lines().count() > LONGEST_FILE)
        .map(|(file, text)| format!("{}: {} lines", file.display(), text.lines().count()))
        .collect();
    assert!(long.is_empty(), "{}", long.join("\n"));
}
