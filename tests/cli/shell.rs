//! What packages install beside the program: completions, manual pages, and what `--version` tells of the machine.

use std::fs;
use std::process::Command;

use super::{Folder, fail, succeed};

#[test]
fn every_shell_and_the_manual_are_served() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = succeed(&["completions", shell]).stdout;
        assert!(script.contains("turntable") && script.contains("environment"), "{shell}");
    }
    let manual = succeed(&["man"]).stdout;
    assert!(manual.contains(".TH pellicle 1") && manual.contains("pellicle\\-turntable"), "{manual}");
    let page = succeed(&["man", "render"]).stdout;
    assert!(page.contains(".TH pellicle-render 1") && page.contains("\\-\\-environment"), "{page}");
    assert!(!page.contains("CPU:"), "{page}");
    assert!(fail(2, &["man", "paint"]).contains("no command `paint`; there are render, turntable"));
}

/// Sources the script in bash and asks it what follows on a command line.
fn completed(script: &str, words: &[&str]) -> Vec<String> {
    let line = words.join(" ");
    let ask = format!(
        "source {script}; COMP_WORDS=({line}); COMP_CWORD={}; COMP_LINE='{line}'; COMP_POINT={}
         _pellicle pellicle '{}' '{}'; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        words.len() - 1,
        line.len(),
        words[words.len() - 1],
        words[words.len() - 2],
    );
    let output = Command::new("bash").args(["--norc", "-c", &ask]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn bash_completes_commands_options_and_values() {
    if Command::new("bash").arg("--version").output().is_err() {
        eprintln!("skipped: there is no bash");
        return;
    }
    let folder = Folder::new("completions");
    let script = folder.file("pellicle.bash");
    fs::write(&script, succeed(&["completions", "bash"]).stdout).unwrap();
    assert_eq!(completed(&script, &["pellicle", "tur"]), ["turntable"]);
    assert_eq!(completed(&script, &["pellicle", "render", "--env"]), ["--environment"]);
    assert_eq!(completed(&script, &["pellicle", "render", "--mode", "sp"]), ["spectral"]);
}

#[test]
fn version_is_short_or_tells_of_the_machine() {
    let short = succeed(&["-V"]).stdout;
    assert_eq!(short, format!("pellicle {}\n", env!("CARGO_PKG_VERSION")));
    let long = succeed(&["--version"]).stdout;
    let lines: Vec<&str> = long.lines().collect();
    let [name, embree, cpu, compiled] = lines.as_slice() else { panic!("{long}") };
    assert!(short.starts_with(name) && embree.starts_with("Embree 4."), "{long}");
    assert!(cpu.starts_with("CPU: ") && compiled.starts_with("compiled for: "), "{long}");
}
