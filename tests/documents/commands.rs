//! Command lines run as they stand, with the program in place of its name and renders made tiny.

use std::fs;
use std::io::{Read, copy, sink};
use std::net::TcpListener;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

use rayon::prelude::*;

use super::{Block, blocks, documents, root};
use crate::cli::Folder;

/// Stands on the path as `pellicle`: notes the arguments that it runs with, so that the files they name can be looked for,
/// and makes renders tiny. Sizes become 24x16, samples 2 (a `--samples` range its share of them), frames the first two
/// (of two, where the whole is named); renders that say nothing about these are told.
const SMALL: &str = r#"#!/bin/bash
said=" $* " spp=2 given= args=()
for word in "$@"; do [ "$last" = --spp ] && spp=$word; last=$word; done
while [ $# -gt 0 ]; do
    args+=("$1")
    case $1 in
        --size) args+=(24x16); shift ;;
        --spp) case $2 in *,*) args+=(1,2) ;; *) args+=(2) ;; esac; shift ;;
        --reference-spp) args+=(16); shift ;;
        --repeats) args+=(1); shift ;;
        --samples) args+=($((${2%:*} * 2 / spp)):$((${2#*:} * 2 / spp))); shift ;;
        --frames) case $2 in */*) args+=(0-1/2) ;; *-*) args+=(1-2) ;; *) args+=(2) ;; esac; shift ;;
    esac
    shift
done
add() { [[ $said == *" $1 "* ]] || args+=("$@"); }
case ${args[0]} in
    render | turntable | animate) add --size 24x16; add --spp 2 ;;
    chart)
        case ${args[1]} in
            convergence) add --size 24x16; add --spp 1,2; add --reference-spp 16; add --repeats 1 ;;
            growth) add --quick ;;
        esac ;;
esac
printf '%s\0' "${args[@]}" END >>"$ARGUMENTS"
exec "$PELLICLE" "${args[@]}"
"#;

/// Lines with these words are not run, for these reasons.
const NOT_RUN: [(&str, &str); 12] = [
    ("apt-get ", "installs packages"),
    ("pip install", "installs packages"),
    ("cargo ", "builds the program"),
    ("sbatch ", "wants a Slurm cluster; tests/cli/slurm.rs has one"),
    ("tests/slurm/", "starts a Slurm cluster"),
    ("parallel ", "GNU parallel is not everywhere; the same parts are merged in docs/farms.md"),
    ("make_scenes.py", "writes into scenes/, for minutes"),
    ("docs/make_", "writes into docs/, for minutes"),
    ("export ", "for the reader's own shell"),
    ("git archive", "wants the repository, not only its files"),
    ("contrib/blender/", "wants Blender's `bpy`; contrib/blender/tests runs it where it is"),
    ("...", "a gap"),
];

/// Options that name a file that is written, or the first part of its name.
const OUTPUTS: [&str; 10] =
    ["-o", "--output", "--csv", "--swatch", "--plot", "--diff", "--video", "--stats", "--preview", "--report"];

/// The files that documents name without having made them. Nothing here leads a command back into the repository, but for
/// `scenes/`.
fn fixtures(folder: &Folder) {
    let pellicle = env!("CARGO_BIN_EXE_pellicle");
    symlink(root().join("scenes"), folder.file("scenes")).unwrap();
    symlink(pellicle, folder.file("pellicle-before")).unwrap();
    fs::write(folder.file("scene.dae"), super::examples::whole_scene()).unwrap();
    for name in [
        "bin",
        "docs",
        "frames",
        ".zfunc",
        ".local/share/bash-completion/completions",
        ".local/share/man/man1",
        ".config/fish/completions",
    ] {
        fs::create_dir_all(folder.file(name)).unwrap();
    }
    fs::write(folder.file("model.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        .unwrap();
    let small = folder.file("bin/pellicle");
    fs::write(&small, SMALL).unwrap();
    fs::set_permissions(&small, fs::Permissions::from_mode(0o755)).unwrap();

    let render = |name: &str, more: &[&str]| {
        let mut render = Command::new(pellicle);
        render.args(["render", "scene.dae", "-q", "--size", "24x16", "--spp", "2", "-o", name]).args(more);
        assert!(render.current_dir(folder.file(".")).status().unwrap().success(), "{name}");
    };
    render("a.exr", &["--aov", "variance"]);
    render("frames/f.0000.png", &[]);
    render("0.part", &["--samples", "0:1"]);
    render("1.part", &["--samples", "1:2"]);
    for name in ["b.exr", "noisy.exr", "reference.exr", "today.exr", "yesterday.exr", "f.0000.exr"] {
        fs::copy(folder.file("a.exr"), folder.file(name)).unwrap();
    }
}

/// The examples in the help of a subcommand.
fn help_examples(file: &Path) -> Vec<Block> {
    let place = file.strip_prefix(root()).unwrap().display().to_string();
    let text = fs::read_to_string(file).unwrap();
    let examples = text.lines().filter(|line| line.starts_with("  pellicle "));
    let block = |line: &str| Block { place: place.clone(), text: line.trim_end_matches("\")]").replace("\\\"", "\"") };
    examples.map(block).collect()
}

/// Lines that a backslash continues, as one.
fn command_lines(block: &Block) -> Vec<String> {
    block.text.replace("\\\n", " ").lines().map(str::trim).filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

/// What is wrong with a command line, if anything.
fn run(folder: &Folder, line: &str) -> Result<(), String> {
    let arguments = folder.file("arguments");
    let _ = fs::remove_file(&arguments);
    let path = format!("{}:{}", folder.file("bin"), std::env::var("PATH").unwrap());
    let mut bash = Command::new("bash");
    bash.args(["-e", "-o", "pipefail", "-c", line]).current_dir(folder.file("."));
    bash.env("HOME", folder.file("."))
        .env("PATH", path)
        .env("PELLICLE", env!("CARGO_BIN_EXE_pellicle"))
        .env("ARGUMENTS", &arguments);
    let output = bash.output().unwrap();
    if !output.status.success() {
        return Err(format!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr)));
    }
    let noted = fs::read_to_string(&arguments).unwrap_or_default();
    let words: Vec<&str> = noted.split('\0').collect();
    for pair in words.windows(2).filter(|pair| OUTPUTS.contains(&pair[0])) {
        if !exists(folder, pair[1]) {
            return Err(format!("there is no {}", pair[1]));
        }
    }
    Ok(())
}

/// Whether a file is there whose name begins like `name`, of which `####` is a number.
fn exists(folder: &Folder, name: &str) -> bool {
    let path = folder.file(name);
    let (directory, start) = path.rsplit_once('/').unwrap();
    let start = start.split(['#', '%']).next().unwrap();
    let mut entries = fs::read_dir(directory).into_iter().flatten();
    entries.any(|entry| entry.unwrap().file_name().to_str().unwrap().starts_with(start))
}

/// A listener where the viewer `tev` would be, which takes whatever is sent. It ends with the program.
fn stand_in_for_tev() {
    let Ok(listener) = TcpListener::bind("127.0.0.1:14158") else {
        println!("something listens at tev's port already: perhaps tev");
        return;
    };
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            std::thread::spawn(move || copy(&mut stream.take(u64::MAX), &mut sink()));
        }
    });
}

/// Whether bash finds the program.
fn is_installed(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| Path::new(&folder).join(program).exists())
}

/// Runs the commands of one document; gives what failed, and how many there were.
fn failures(blocks: &[Block], new_folder: impl Fn() -> Folder) -> (Vec<String>, usize) {
    let has_ffmpeg = is_installed("ffmpeg");
    let (mut failures, mut ran, mut folder) = (Vec::new(), 0, None);
    for block in blocks {
        for line in command_lines(block) {
            // How README starts the program before it is installed; the program stands here already.
            let line = line.replace("./setup.sh && cargo run --release -- ", "pellicle ");
            if let Some((_, reason)) = NOT_RUN.iter().find(|(words, _)| line.contains(words)) {
                println!("{}: not run ({reason}): {line}", block.place);
            } else if !has_ffmpeg && [".mp4", ".mkv", ".webm", ".mov"].iter().any(|video| line.contains(video)) {
                println!("{}: not run (no ffmpeg here): {line}", block.place);
            } else {
                ran += 1;
                if let Err(message) = run(folder.get_or_insert_with(&new_folder), &line) {
                    failures.push(format!("{}: {line}\n{message}", block.place));
                }
            }
        }
    }
    (failures, ran)
}

#[test]
fn every_command_runs() {
    stand_in_for_tev();
    let mut sources: Vec<Vec<Block>> = documents().iter().map(|document| blocks(document)).collect();
    for folder in ["src/cli", "src/cli/chart"] {
        sources.extend(super::files(folder, "rs").iter().map(|file| help_examples(file)));
    }
    sources.iter_mut().for_each(|blocks| blocks.retain(|block| !block.is_xml()));

    let template = Folder::new("documents");
    fixtures(&template);
    let new_folder = |number: usize| {
        let folder = Folder::new(&format!("documents-{number}"));
        let from = template.file(".");
        assert!(Command::new("cp").args(["-a", &from, &folder.file(".")]).status().unwrap().success());
        folder
    };
    let results: Vec<(Vec<String>, usize)> =
        sources.par_iter().enumerate().map(|(number, blocks)| failures(blocks, || new_folder(number))).collect();
    let ran: usize = results.iter().map(|(_, ran)| ran).sum();
    let failures: Vec<String> = results.into_iter().flat_map(|(failures, _)| failures).collect();
    println!("{ran} commands ran");
    assert!(ran >= 60, "only {ran} commands were found");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
