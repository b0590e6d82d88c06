//! SIGINT and SIGTERM in mid-render.

use super::*;

/// A render that would take hours, and is under way.
pub struct Rendering {
    child: Child,
    stderr: BufReader<std::process::ChildStderr>,
}

impl Rendering {
    pub fn start(file: &str, size: &str) -> Self {
        Self::start_scene("room.dae", file, size, &[])
    }

    pub fn start_scene(scene: &str, file: &str, size: &str, more: &[&str]) -> Self {
        let arguments = ["render", scene, "-o", file, "--spp", "1000000", "--size", size, "--progress", "none"];
        let mut child =
            command(&[&arguments, more].concat()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        // Rendering begins right after the line that tells how many samples there will be.
        let mut line = String::new();
        while !line.contains("1000000 spp") {
            line.clear();
            assert_ne!(stderr.read_line(&mut line).unwrap(), 0, "it ended early");
        }
        Self { child, stderr }
    }

    pub fn send(&self, signals: &[&str]) {
        for signal in signals {
            let pid = self.child.id().to_string();
            assert!(Command::new("kill").args(["-s", signal, &pid]).status().unwrap().success());
        }
    }

    /// The exit code and the rest of stderr; within 5 s.
    pub fn end(mut self) -> (Option<i32>, String) {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(start.elapsed() < Duration::from_secs(5), "still running 5 s after the signal");
            std::thread::sleep(Duration::from_millis(10));
        };
        let mut rest = String::new();
        self.stderr.read_to_string(&mut rest).unwrap();
        (status.code(), rest)
    }
}

impl Drop for Rendering {
    /// Nothing goes on rendering behind a test that failed.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn sigint_and_sigterm_save_what_was_rendered() {
    let folder = Folder::new("signals");
    for (signal, name, code) in [("INT", "a.exr", 130), ("TERM", "b.png", 143)] {
        let rendering = Rendering::start(&folder.file(name), "64x48");
        std::thread::sleep(Duration::from_millis(500));
        rendering.send(&[signal]);
        let (status, stderr) = rendering.end();
        assert_eq!(status, Some(code), "{stderr}");
        assert!(stderr.contains(&format!("stopped by SIG{signal} after ")), "{stderr}");
        assert!(is_complete(Path::new(&folder.file(name))));
    }
    let picture = read_exr(Path::new(&folder.file("a.exr"))).unwrap();
    assert!(!is_black(&picture.rgba));
    assert_eq!(folder.names(), ["a.exr", "b.png"]);
}

/// A pass over this picture takes seconds: nobody waits for its end.
#[test]
fn a_signal_ends_even_a_large_picture_and_leaves_the_old_one() {
    let folder = Folder::new("large");
    fs::write(folder.file("a.exr"), "old").unwrap();
    let rendering = Rendering::start(&folder.file("a.exr"), "3000x2000");
    rendering.send(&["TERM"]);
    let (status, stderr) = rendering.end();
    assert_eq!(status, Some(143), "{stderr}");
    assert!(stderr.contains("no picture was written"), "{stderr}");
    assert_eq!(fs::read_to_string(folder.file("a.exr")).unwrap(), "old");
    assert_eq!(folder.names(), ["a.exr"]);
}

#[test]
fn a_second_signal_ends_at_once() {
    let folder = Folder::new("second");
    // All these layers take ten times as long to write as the picture alone: time for the second to arrive meanwhile. Held
    // back and let go together, two threads could take one each, and neither would know of the other.
    let layers = ["--aov", "variance,N,Z,albedo,object,material,lights"];
    let rendering = Rendering::start_scene("room.dae", &folder.file("a.exr"), "640x480", &layers);
    std::thread::sleep(Duration::from_millis(1500));
    rendering.send(&["INT", "TERM"]);
    let (status, stderr) = rendering.end();
    assert!(matches!(status, Some(130 | 143)), "{status:?} {stderr}");
    assert_eq!(stderr, "", "ended without saving");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}
