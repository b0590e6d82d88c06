//! The add-on for Blender in contrib/blender. Its scenarios are Python; they run where there is a Python with what they need:
//! `bpy`, else NumPy, else none of both. `PELLICLE_BPY_PYTHON` names it; `python3` is the default.

use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("contrib/blender")
}

fn python() -> Command {
    let program = std::env::var("PELLICLE_BPY_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let mut command = Command::new(program);
    // No caches in the repository, and no warnings of what Blender 6 will drop.
    command.current_dir(folder().join("tests")).env("PYTHONDONTWRITEBYTECODE", "1").env("PYTHONWARNINGS", "ignore");
    command.env("PELLICLE_PROGRAM", env!("CARGO_BIN_EXE_pellicle"));
    command
}

/// Whether this Python can import a module; says what is skipped where it cannot.
fn has(module: &str, advice: &str) -> bool {
    // Blender as a module may hang while Python takes it apart.
    let there = python().args(["-c", &format!("import os, {module}; os._exit(0)")]).output();
    let there = there.is_ok_and(|output| output.status.success());
    if !there {
        println!("skipped: needs a Python with {module} ({advice}); $PELLICLE_BPY_PYTHON names one");
    }
    there
}

fn pass(arguments: &[&str]) {
    let output = python().args(arguments).output().unwrap();
    let [said, failed] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{arguments:?}\n{said}\n{failed}");
    println!("{said}");
}

#[test]
fn every_file_is_python() {
    if has("ast", "python3") {
        let parse = "import ast, pathlib; [ast.parse(p.read_text(), str(p)) for p in pathlib.Path('..').rglob('*.py')]";
        pass(&["-c", parse]);
    }
}

#[test]
fn python_files_stay_readable() {
    for name in ["pellicle", "tests", "."] {
        for entry in std::fs::read_dir(folder().join(name)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "py") {
                let lines = std::fs::read_to_string(&path).unwrap().lines().count();
                assert!(lines <= 500, "{}: {lines} lines", path.display());
            }
        }
    }
}

#[test]
fn ids_metals_watts_and_messages() {
    if has("unittest", "python3") {
        pass(&["test_plain.py"]);
    }
}

#[test]
fn numbers_images_and_channels() {
    if has("numpy", "pip install numpy") {
        pass(&["test_arrays.py"]);
    }
}

#[test]
fn scenes_of_blender_are_what_they_were() {
    if has("bpy", "pip install bpy") {
        for scenarios in ["test_lights.py", "test_surfaces.py", "test_scenes.py"] {
            pass(&[scenarios]);
        }
    }
}
