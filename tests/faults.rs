//! What files from strangers, full disks and stopped processes must not do, mostly through the program as it is run. The table
//! of docs/reliability.md says which test stands for which fault.

#[path = "faults/archives.rs"]
mod archives;
#[path = "faults/bits.rs"]
mod bits;
#[path = "faults/bugs.rs"]
mod bugs;
#[path = "faults/disks.rs"]
mod disks;
#[path = "faults/images.rs"]
mod images;
#[path = "faults/memory.rs"]
mod memory;
#[path = "faults/mutations.rs"]
mod mutations;
#[path = "faults/nodes.rs"]
mod nodes;
#[path = "faults/paths.rs"]
mod paths;
#[path = "faults/processes.rs"]
mod processes;
#[path = "faults/soak.rs"]
mod soak;
#[path = "faults/xml.rs"]
mod xml;

/// The same ways in as the fuzz targets use.
#[path = "../fuzz/src/lib.rs"]
mod feed;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::cli::{Folder, Run, command};

/// No bad file may take longer; most take milliseconds.
const PATIENCE: Duration = Duration::from_secs(10);

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The room of the command-line tests with some of its words replaced.
fn room(replace: &[(&str, &str)]) -> String {
    let mut text = fs::read_to_string(data("cli/room.dae")).unwrap();
    for (old, new) in replace {
        assert!(text.contains(old), "{old}");
        text = text.replacen(old, new, 1);
    }
    text
}

/// Runs the program where it cannot get more than 4 GB of addresses: what asks for too much aborts, and the test fails.
fn confined(arguments: &[&str]) -> Run {
    let start = Instant::now();
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 4000000; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_pellicle")])
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(start.elapsed() < PATIENCE, "{arguments:?} took {:?}", start.elapsed());
    output.into()
}

/// `check` refuses the file with exit code 1 and these words.
fn refused(file: &str, options: &[&str], words: &[&str]) -> String {
    let run = confined(&[&["check", file], options].concat());
    assert_eq!(run.code, Some(1), "{file}: {}{}", run.stdout, run.stderr);
    assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "{word}: {}", run.stderr);
    }
    run.stderr
}

/// The same for the content of a file.
fn refuses(folder: &Folder, content: impl AsRef<[u8]>, options: &[&str], words: &[&str]) -> String {
    let file = folder.file("scene.dae");
    fs::write(&file, content).unwrap();
    refused(&file, options, words)
}
