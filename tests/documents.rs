//! The documents keep their word: every XML example loads without a warning, every command line runs.
//!
//! In README.md, docs/*.md and the scenes' README files a block of code is an indented paragraph or a ```xml, ```sh or ```
//! fence; other languages are left alone.
//!
//! - A block that starts with `<` is an example of our format: a whole `<COLLADA>`, or fragments, each put into a small scene
//!   where it belongs (`examples::Place`). Images that it names are there.
//! - Every line of any other block is a command, run by bash in a folder of its document, in order, so that one may use what
//!   an earlier one made; so are `pellicle ...` between backticks in a table, and the examples of `--help`. The folder holds
//!   `scenes/`, `scene.dae`, which is the whole scene of docs/format.md, and the files of `commands::fixtures`.
//!   `commands::SMALL` makes renders tiny. Lines that cannot run here are in `commands::NOT_RUN`, with the reason.

use std::fs;
use std::path::{Path, PathBuf};

#[path = "documents/commands.rs"]
mod commands;
#[path = "documents/examples.rs"]
mod examples;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A block of code, or the command of a table's cell.
struct Block {
    /// Where its first line stands, for messages: `docs/format.md:12`.
    place: String,
    text: String,
}

impl Block {
    fn is_xml(&self) -> bool {
        self.text.trim_start().starts_with('<')
    }
}

/// Files with this ending, sorted.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == ending));
    paths.sort();
    paths
}

/// All documents, paths from the repository's root.
fn documents() -> Vec<String> {
    let mut found = vec![root().join("README.md")];
    found.extend(files("docs", "md"));
    for folder in ["scenes", "contrib"] {
        found.extend(files(folder, "md"));
        let folders = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        found.extend(folders.map(|path| path.join("README.md")).filter(|path| path.exists()));
    }
    found.iter().map(|path| path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned()).collect()
}

/// The blocks of a document, and the commands in its tables.
fn blocks(document: &str) -> Vec<Block> {
    let text = fs::read_to_string(root().join(document)).unwrap();
    let mut blocks: Vec<Block> = Vec::new();
    let mut fence: Option<bool> = None;
    // Whether an indented line starts or goes on with a block: not inside a list.
    let (mut blank, mut inside, mut list) = (true, false, false);
    for (number, line) in text.lines().enumerate() {
        let place = || format!("{document}:{}", number + 1);
        if let Some(language) = line.strip_prefix("```") {
            fence = match fence {
                Some(_) => None,
                None => Some(matches!(language.trim(), "" | "xml" | "sh")),
            };
            if fence == Some(true) {
                blocks.push(Block { place: place(), text: String::new() });
            }
            (inside, blank) = (false, true);
            continue;
        }
        if let Some(kept) = fence {
            if kept {
                let block = blocks.last_mut().unwrap();
                block.text += line;
                block.text += "\n";
            }
            continue;
        }
        let indented = line.strip_prefix("    ").filter(|_| inside || (blank && !list));
        if let Some(code) = indented {
            if !inside {
                blocks.push(Block { place: place(), text: String::new() });
            }
            let block = blocks.last_mut().unwrap();
            block.text += code;
            block.text += "\n";
            inside = true;
            continue;
        }
        blank = line.trim().is_empty();
        inside &= blank;
        list = line.starts_with("- ") || line.starts_with("* ") || (list && (blank || line.starts_with("  ")));
        if line.starts_with('|') {
            let cells = line.split('`').skip(1).step_by(2).filter(|cell| cell.starts_with("pellicle "));
            blocks.extend(cells.map(|cell| Block { place: place(), text: cell.replace("\\|", "|") + "\n" }));
        }
    }
    blocks
}
