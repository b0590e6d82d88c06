//! Every scene of this repository (and of the shared folder, where there is one) with something changed: bytes, words,
//! attributes, numbers. Whatever comes of it is a scene or an error, soon. Fuzzing with a guide finds more (`fuzz/`); this needs
//! nothing but `cargo test`, and does the same each time.
//!
//! `PELLICLE_MUTATIONS=100000 cargo test --release mutations` tries that many for each way in.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::*;

/// For each file, where nobody says.
const USUAL: usize = 30;
/// Beyond this a file is mostly numbers of one mesh.
const LARGEST: usize = 200_000;

/// A way into the program.
type Take = fn(&[u8]);

/// xorshift64*, so that every run tries the same.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % end.max(1)
    }

    fn one<'t>(&mut self, texts: &[&'t str]) -> &'t str {
        texts[self.below(texts.len())]
    }
}

const NUMBERS: [&str; 16] = [
    "NaN",
    "INF",
    "-INF",
    "inf",
    "0",
    "-0",
    "-1",
    "1e39",
    "1e-46",
    "1e38",
    "4294967295",
    "4294967296",
    "99999999999999999999",
    "0,5",
    "",
    "1e",
];
const WORDS: [&str; 12] = ["<", ">", "/>", "\"", "&#0;", "&amp;", "#", "<!--", "<node>", "</node>", "]]>", "\u{301}"];

/// Where words, attribute values and numbers begin and end.
fn tokens(bytes: &[u8]) -> Vec<(usize, usize)> {
    let is_inside = |byte: &u8| byte.is_ascii_alphanumeric() || b".-+_#".contains(byte);
    let mut tokens = Vec::new();
    let mut start = None;
    for (at, byte) in bytes.iter().enumerate() {
        match (is_inside(byte), start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                tokens.push((from, at));
                start = None;
            }
            _ => {}
        }
    }
    tokens
}

fn mutate(original: &[u8], tokens: &[(usize, usize)], random: &mut Random) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..1 + random.below(3) {
        let at = random.below(bytes.len());
        let length = random.below(40).min(bytes.len() - at);
        // Later changes of a file may find their token moved: that is a change as well.
        let (start, end) = tokens.get(random.below(tokens.len())).copied().unwrap_or((at, at));
        let (start, end) = (start.min(bytes.len()), end.min(bytes.len()));
        match random.below(8) {
            0 if at < bytes.len() => bytes[at] = random.below(256) as u8,
            1 => drop(bytes.drain(at..at + length)),
            2 => {
                let piece = bytes[at..at + length].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece).for_each(drop);
            }
            3 => bytes.splice(at..at, random.one(&WORDS).bytes()).for_each(drop),
            4 => bytes.truncate(at + 1),
            // A word in the place of another.
            5 => {
                let (from, to) = tokens.get(random.below(tokens.len())).copied().unwrap_or((0, 0));
                let word = original[from..to].to_vec();
                bytes.splice(start..end, word).for_each(drop);
            }
            _ => bytes.splice(start..end, random.one(&NUMBERS).bytes()).for_each(drop),
        }
    }
    bytes
}

/// All scene files under a folder that are not too large.
fn scenes(folder: PathBuf) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        let is_scene = path.extension().is_some_and(|extension| extension == "dae" || extension == "zae");
        if path.is_dir() {
            found.extend(scenes(path));
        } else if is_scene && fs::metadata(&path).unwrap().len() < LARGEST as u64 {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Hands the bytes over; where that panics or takes too long, says which and keeps them.
fn survive(name: &str, bytes: &[u8], take: Take) {
    let start = Instant::now();
    let survived = catch_unwind(AssertUnwindSafe(|| take(bytes))).is_ok();
    if !survived || start.elapsed() > PATIENCE {
        let kept = std::env::temp_dir().join(format!("pellicle-found-{}", name.replace(['/', ' '], "_")));
        fs::write(&kept, bytes).unwrap();
        panic!("{name} after {:?}: see {}", start.elapsed(), kept.display());
    }
}

#[test]
fn changed_scenes_are_scenes_or_errors() {
    let rounds = std::env::var("PELLICLE_MUTATIONS").map_or(USUAL, |count| count.parse().expect("a number"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = [scenes(root.join("scenes")), scenes(root.join("tests/data"))].concat();
    match std::env::var_os("PELLICLE_SHARED") {
        Some(shared) => files.extend(scenes(Path::new(&shared).join("scenes"))),
        None => println!("skipped: PELLICLE_SHARED does not name a folder with more scenes"),
    }
    assert!(files.len() > 100, "{} scenes", files.len());
    let mut executions = 0;
    for (seed, file) in files.iter().enumerate() {
        let original = fs::read(file).unwrap();
        if original.is_empty() {
            continue;
        }
        let is_archive = file.extension().is_some_and(|extension| extension == "zae");
        let tokens = tokens(&original);
        let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ (seed as u64 + 1));
        for round in 0..rounds {
            let name = format!("mutation {round} of {}", file.display());
            let bytes = mutate(&original, &tokens, &mut random);
            survive(&name, &bytes, if is_archive { feed::archive } else { feed::picture });
        }
        executions += rounds;
    }
    println!("{executions} executions over {} scenes", files.len());
}

/// Every number of the loader's own test files, one at a time, with every value that no file should hold.
#[test]
fn nan_and_infinity_in_every_place_are_scenes_or_errors() {
    let mut executions = 0;
    for name in ["good/profile.dae", "good/cgl.dae", "good/blender_lights.dae", "good/nodes.dae", "cli/moving.dae"] {
        let original = fs::read(data(name)).unwrap();
        for (start, end) in tokens(&original) {
            let Ok(token) = std::str::from_utf8(&original[start..end]) else { continue };
            if token.parse::<f32>().is_err() || token.chars().any(char::is_alphabetic) {
                continue;
            }
            for value in ["NaN", "INF", "-INF", "1e39", "-1", "0", "4294967295"] {
                let bytes = [&original[..start], value.as_bytes(), &original[end..]].concat();
                survive(&format!("{name} with {value} at byte {start}"), &bytes, feed::picture);
                survive(&format!("{name} with {value} at byte {start}, posed"), &bytes, feed::scene);
                executions += 2;
            }
        }
    }
    println!("{executions} executions");
    assert!(executions > 5_000, "{executions}");
}

/// What fuzzing and these tests have found, fixed, and must not come back.
#[test]
fn what_was_found_stays_fixed() {
    let takers: [(&str, Take); 9] = [
        ("scene", feed::scene),
        ("picture", feed::picture),
        ("archive", feed::archive),
        ("image", feed::image),
        ("frame", feed::frame),
        ("part", feed::part),
        ("medium", feed::medium),
        ("words", feed::words),
        ("arguments", feed::arguments),
    ];
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/found");
    for (target, take) in takers {
        for entry in fs::read_dir(found.join(target)).into_iter().flatten() {
            let path = entry.unwrap().path();
            survive(&path.file_name().unwrap().to_string_lossy(), &fs::read(&path).unwrap(), take);
        }
    }
}
