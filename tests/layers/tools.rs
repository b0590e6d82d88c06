//! What other programs make of our files. Each test skips, and says why, where the program is missing.

use super::*;

/// A picture with everything.
fn written(folder: &Folder) -> String {
    let file = folder.file("all.exr");
    succeed(&["render", "film.dae", "-o", &file, "--aov", ALL, "-q"]);
    file
}

fn stdout(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output().unwrap();
    assert!(output.status.success(), "{program} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn exrinfo_lists_every_channel_and_finds_no_fault() {
    if !has("exrinfo", "apt-get install openexr") {
        return;
    }
    let folder = Folder::new("exrinfo");
    let output = Command::new("exrinfo").args(["-v", "-s", &written(&folder)]).output().unwrap();
    // Debian's version ends with any status, whoever wrote the file.
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    let found = String::from_utf8(output.stdout).unwrap();
    for expected in [
        "'R': half",
        "'albedo.G': half",
        "'N.Z': half",
        "'Z': float",
        "'film.thickness_nm': float",
        "'CryptoMaterial02.A': float",
        "cryptomatte/3ae39a5/manifest",
        "'zip'",
    ] {
        assert!(found.contains(expected), "{expected} is not in\n{found}");
    }
}

#[test]
fn oiiotool_reads_names_values_and_manifest() {
    if !has("oiiotool", "apt-get install openimageio-tools") {
        return;
    }
    let folder = Folder::new("oiiotool");
    let file = written(&folder);
    let found = stdout("oiiotool", &["--info", "-v", "--stats", &file]);
    assert!(found.contains("32 x   24, 48 channel"), "{found}");
    for expected in ["CryptoObject00.R", "film.thickness_nm", "\"floor-node\"", "MurmurHash3_32"] {
        assert!(found.contains(expected), "{expected} is not in\n{found}");
    }
    // A channel that is taken out holds what we wrote.
    let film = folder.file("film.exr");
    stdout("oiiotool", &[&file, "--ch", "film.thickness_nm", "-o", &film]);
    let [ours, theirs] = [&file, &film].map(|file| read_exr(Path::new(file)).unwrap());
    assert_eq!(layer(&theirs, "film.thickness_nm"), layer(&ours, "film.thickness_nm"));
}

#[test]
fn python_openexr_reads_layers_as_arrays() {
    let python = std::env::var("PELLICLE_TEST_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = "import OpenEXR, sys
part = OpenEXR.File(sys.argv[1], separate_channels=True).parts[0]
film, z = part.channels['film.thickness_nm'].pixels, part.channels['Z'].pixels
manifest = part.header['cryptomatte/3ae39a5/manifest']
print(len(part.channels), film.shape, film.max(), z.min(), manifest)";
    let folder = Folder::new("python");
    let output = Command::new(&python).args(["-c", script, &written(&folder)]).output();
    let output = match output {
        Ok(output) if output.status.success() => String::from_utf8(output.stdout).unwrap(),
        failed => {
            let reason = failed.map(|output| String::from_utf8_lossy(&output.stderr).into_owned());
            assert!(!reason.as_ref().is_ok_and(|text| !text.contains("No module")), "{reason:?}");
            println!("skipped: needs Python with OpenEXR 3.3 or later (pip install OpenEXR; PELLICLE_TEST_PYTHON)");
            return;
        }
    };
    assert!(output.starts_with("48 (24, 32) 550.0 "), "{output}");
    assert!(output.contains("\"floor-node\""), "{output}");
}

/// `compare` goes by the colours and the variance, whatever else there is.
#[test]
fn compare_takes_files_with_many_layers() {
    let folder = Folder::new("compare-layers");
    let file = written(&folder);
    let plain = folder.file("plain.exr");
    succeed(&["render", "film.dae", "-o", &plain, "--aov", "variance", "-q"]);
    let found = succeed(&["compare", &file, &plain, "--json", "--alpha", "0.01"]).stdout;
    assert!(found.contains("\"mse\": 0.0"), "{found}");
}
