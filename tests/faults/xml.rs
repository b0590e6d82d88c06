//! XML that is no scene: bombs, definitions, depth, encodings.

use super::*;

/// Every bad file of the loader's tests, through the program.
#[test]
fn bad_files_end_the_program_with_their_error() {
    for entry in fs::read_dir(data("bad")).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|extension| extension == "dae") {
            let name = file.to_str().unwrap();
            let stderr = refused(name, &[], &[]);
            let expected = fs::read_to_string(file.with_extension("txt")).unwrap();
            assert_eq!(stderr.replace(name, file.file_name().unwrap().to_str().unwrap()), format!("error: {expected}"));
        }
    }
}

#[test]
fn definitions_are_refused_and_nothing_of_them_is_read() {
    let folder = Folder::new("definitions");
    fs::write(folder.file("secret"), "hidden words").unwrap();
    let laughs: String =
        (1..10).map(|i| format!("<!ENTITY l{i} \"{}\">", format!("&l{};", i - 1).repeat(10))).collect();
    let quadratic = format!("<!ENTITY a \"{}\">", "x".repeat(1_000_000));
    for definitions in [
        format!("<!ENTITY l0 \"ha\">{laughs}"),
        quadratic,
        "<!ENTITY x SYSTEM \"file:secret\">".to_owned(),
        "<!ENTITY % x SYSTEM \"http://127.0.0.1:1/x.dtd\"> %x;".to_owned(),
        "<!ATTLIST node id CDATA #FIXED \"x\">".to_owned(),
    ] {
        let text = format!("<!DOCTYPE COLLADA [{definitions}]>\n<COLLADA>&x;&l9;{}</COLLADA>", "&a;".repeat(1000));
        let stderr = refuses(&folder, text, &[], &["a document type definition is refused", ":1:1: "]);
        assert!(!stderr.contains("hidden words"), "{stderr}");
    }
    refuses(&folder, room(&[("<asset>", "<asset>&x;")]), &[], &["unrecognized entity"]);
}

#[test]
fn twenty_thousand_elements_deep_is_too_deep() {
    let folder = Folder::new("deep");
    for depth in [257, 20_000, 1_000_000] {
        let text = format!("<COLLADA>{}{}</COLLADA>", "<node>".repeat(depth), "</node>".repeat(depth));
        refuses(&folder, text, &[], &["elements are nested deeper than 256"]);
        let text = format!("<COLLADA>{}", "<node>".repeat(depth));
        refuses(&folder, text, &[], &["elements are nested deeper than 256"]);
    }
}

#[test]
fn elements_that_take_more_memory_than_there_is_are_refused() {
    let folder = Folder::new("elements");
    for (content, count) in
        [("<a/>", 3_000_000), ("<a b=''/>", 1_000_000), ("<a>x</a>", 1_000_000), ("&lt;", 5_000_000)]
    {
        let text = format!("<COLLADA>{}</COLLADA>", content.repeat(count));
        refuses(&folder, text, &["--max-memory", "100M"], &["take more than 100000000 bytes of memory"]);
    }
    refuses(&folder, room(&[]), &["--max-memory", "1k"], &["larger than the limit of 1000 bytes"]);
}

#[test]
fn what_is_not_unicode_names_its_byte() {
    let folder = Folder::new("encodings");
    let utf16 = |text: &str| [vec![0xFF, 0xFE], text.encode_utf16().flat_map(u16::to_le_bytes).collect()].concat();
    let utf32: Vec<u8> = room(&[]).chars().flat_map(|c| (c as u32).to_le_bytes()).collect();
    refuses(&folder, [room(&[]).as_bytes(), b"<!-- \xE4 -->"].concat(), &[], &["is not UTF-8; save the file as UTF-8"]);
    refuses(&folder, [utf16("<COLLADA"), vec![0x00, 0xD8, 0x41, 0x00]].concat(), &[], &["byte 18 is not UTF-16"]);
    refuses(&folder, utf32, &[], &[]);
    refuses(&folder, b"", &[], &["no root element"]);
    refuses(&folder, [0; 4096], &[], &[]);
    refuses(&folder, b"\x1f\x8b\x08\0\0\0\0\0", &[], &["byte 1 is not UTF-8"]);
    refuses(&folder, "\u{FEFF}\u{FEFF}<\u{301}", &[], &[]);
    for text in [format!("\u{FEFF}{}", room(&[])), format!("\u{FEFF}\u{FEFF}{}", room(&[]))] {
        let file = folder.file("scene.dae");
        fs::write(&file, &text).unwrap();
        assert_eq!(confined(&["check", &file]).code, Some(0));
        fs::write(&file, utf16(&text)).unwrap();
        assert_eq!(confined(&["check", &file]).code, Some(0));
    }
}

/// Everything that may be said at the same time is said in time that grows with the file, not with its square.
#[test]
fn many_mistakes_take_little_time() {
    let folder = Folder::new("mistakes");
    let warned = |text: &str| {
        let file = folder.file("scene.dae");
        fs::write(&file, text).unwrap();
        let run = confined(&["check", &file]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr.lines().count()
    };
    let twice: String = (0..100_000).map(|i| format!("<image id=\"i{i}\"/>\n").repeat(2)).collect();
    assert_eq!(
        warned(&room(&[("<library_effects>", &format!("<library_images>{twice}</library_images><library_effects>"))])),
        100_000
    );
    // Names of any length are compared with what may have been meant.
    let long = "x".repeat(300_000);
    let node = format!("<node id=\"{long}\"/><node><instance_node url=\"#{long}y\"/></node><node id=\"front\">");
    refuses(&folder, room(&[("<node id=\"front\">", &node)]), &[], &["there is no <node> with id"]);
}
