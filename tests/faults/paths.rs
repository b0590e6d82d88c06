//! Images that lie where a scene from a stranger has no business.

use std::os::unix::fs::symlink;

use super::*;

/// A scene whose floor shows this image.
fn showing(uri: &str) -> String {
    room(&[(
        "<diffuse reflectance=\"0.5\"/>",
        &format!("<diffuse reflectance=\"0.5\"><map for=\"reflectance\" image=\"{uri}\"/></diffuse>"),
    )])
}

#[test]
fn only_the_scenes_own_folder_is_read() {
    let folder = Folder::new("paths");
    for name in ["scene", "secret"] {
        fs::create_dir(folder.file(name)).unwrap();
    }
    let scene = folder.file("scene/scene.dae");
    fs::copy(data("good/dot.png"), folder.file("secret/dot.png")).unwrap();
    fs::copy(data("good/dot.png"), folder.file("scene/own.png")).unwrap();
    symlink(folder.file("secret/dot.png"), folder.file("scene/link.png")).unwrap();
    symlink(folder.file("secret"), folder.file("scene/folder")).unwrap();
    symlink("own.png", folder.file("scene/inside.png")).unwrap();
    symlink("loop.png", folder.file("scene/loop.png")).unwrap();
    symlink("/dev/zero", folder.file("scene/zero.png")).unwrap();
    let pipe = Command::new("mkfifo").arg(folder.file("scene/pipe.png")).status().unwrap();
    assert!(pipe.success());

    let absolute = folder.file("secret/dot.png");
    let outside = "lies outside the scene's folder";
    for (uri, words) in [
        ("../secret/dot.png", outside),
        ("..%2Fsecret%2fdot.png", outside),
        ("%2e%2e/secret/dot.png", outside),
        ("..\\secret\\dot.png", outside),
        ("own.png/../../secret/dot.png", "missing"),
        // The folder that a link leads to has another parent.
        ("folder/../../secret/dot.png", "is missing"),
        (&absolute, outside),
        (&format!("file://{absolute}"), outside),
        (&format!("file://localhost{absolute}"), outside),
        ("/etc/passwd", outside),
        ("link.png", outside),
        ("folder/dot.png", outside),
        ("zero.png", outside),
        ("pipe.png", "is not a file"),
        (".", "is not a file"),
        ("loop.png", "is missing"),
        ("http://127.0.0.1/a.png", "scheme `http:`"),
        ("HTTPS://127.0.0.1/a.png", "scheme `HTTPS:`"),
        ("data:image/png,abc", "scheme `data:`"),
    ] {
        fs::write(&scene, showing(uri)).unwrap();
        let stderr = refused(&scene, &[], &[words, "of material `grey`"]);
        assert!(!stderr.contains("root:"), "{uri}: {stderr}");
    }
    for uri in ["own.png", "./own.png", "inside.png", "../scene/own.png"] {
        fs::write(&scene, showing(uri)).unwrap();
        assert_eq!(confined(&["check", &scene]).code, Some(0), "{uri}");
    }
    fs::write(&scene, showing("link.png")).unwrap();
    assert_eq!(confined(&["check", &scene, "--allow-path", &folder.file("secret")]).code, Some(0));
}

#[test]
fn scenes_are_files() {
    let folder = Folder::new("no-files");
    refused(&folder.file("."), &[], &["Is a directory"]);
    refused("/dev/zero", &[], &["is a device"]);
    refused(&folder.file("no\0thing").replace('\0', "\n"), &[], &["cannot be opened"]);
}
