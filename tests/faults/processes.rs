//! Others that are at work at the same time: readers that go away, files that go away, the same output twice, clocks.

use super::*;
use crate::cli::signals::Rendering;
use crate::cli::{run, succeed};
use pellicle::output::is_complete;

/// `command` as a line of the shell, in the folder of the tests' scenes; `$P` is the program.
fn shell(line: &str) -> Run {
    let mut command = Command::new("bash");
    command.args(["-c", &format!("set -o pipefail; {line}")]).env("P", env!("CARGO_BIN_EXE_pellicle"));
    command.current_dir(data("cli")).stdin(Stdio::null()).output().unwrap().into()
}

#[test]
fn readers_that_go_away_are_no_error() {
    let folder = Folder::new("pipes");
    let picture = folder.file("a.exr");
    for line in [
        "$P check room.dae | true".to_owned(),
        "$P film --base Au --angles 0:90:0.01 | head -1 >/dev/null".to_owned(),
        format!("$P render room.dae -q --hash -o {picture} | true"),
        format!("$P render room.dae --progress json -o {picture} 2>&1 | true"),
        format!("$P render room.dae --hash -o {picture} >&- 2>&-"),
        "$P --help | true".to_owned(),
    ] {
        let run = shell(&line);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{line}");
    }
    assert!(is_complete(Path::new(&picture)));
}

#[test]
fn a_scene_that_goes_away_has_been_read() {
    let folder = Folder::new("gone");
    let scene = folder.file("scene.dae");
    let map = "<diffuse reflectance=\"0.5\"><map for=\"reflectance\" image=\"dot.png\"/></diffuse>";
    for replaced in [false, true] {
        fs::write(&scene, room(&[("<diffuse reflectance=\"0.5\"/>", map)])).unwrap();
        fs::copy(data("good/dot.png"), folder.file("dot.png")).unwrap();
        let rendering = Rendering::start_scene(&scene, &folder.file("a.exr"), "64x48", &[]);
        for name in ["scene.dae", "dot.png"] {
            if replaced {
                fs::write(folder.file(name), "other").unwrap()
            } else {
                fs::remove_file(folder.file(name)).unwrap()
            }
        }
        std::thread::sleep(Duration::from_millis(300));
        rendering.send(&["INT"]);
        assert_eq!(rendering.end().0, Some(130));
        assert!(is_complete(Path::new(&folder.file("a.exr"))));
    }
}

#[test]
fn several_processes_may_write_the_same_picture() {
    let folder = Folder::new("twice");
    let picture = folder.file("a.exr");
    let expected = succeed(&["render", "room.dae", "-q", "--hash", "--seed", "5", "-o", &folder.file("b.exr")]).stdout;
    let start = |_| {
        let arguments = ["render", "room.dae", "-q", "--hash", "--seed", "5", "-o", &picture];
        command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let children: Vec<_> = (0..6).map(start).collect();
    for child in children {
        let run: Run = child.wait_with_output().unwrap().into();
        assert_eq!((run.code, run.stdout), (Some(0), expected.clone()), "{}", run.stderr);
    }
    assert_eq!(folder.names(), ["a.exr", "b.exr"], "and nothing else is left");
    let [a, b] = ["a.exr", "b.exr"].map(|name| pellicle::output::read_exr(Path::new(&folder.file(name))).unwrap());
    assert_eq!(a.rgba, b.rgba);
    let run = run(&["compare", &picture, &folder.file("b.exr")]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

/// Times are taken from a clock that is never set: nothing in the program asks for the time of day, or for the time zone.
#[test]
fn no_code_looks_at_the_time_of_day() {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = fs::read_to_string(&path).unwrap();
            assert!(!text.contains("SystemTime") && !text.contains("UNIX_EPOCH"), "{}", path.display());
            files += 1;
        }
    }
    assert!(files > 200);
}
