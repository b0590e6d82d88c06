//! What is built in from elsewhere: licences that go with this program's, and one place that it comes from.
//!
//! `cargo metadata` knows both without a network. Known vulnerabilities take one: `cargo audit` tells.

use std::process::Command;

/// Each dependency offers at least one of these.
const LICENCES: [&str; 10] = [
    "MIT",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "BSL-1.0",
    "Unlicense",
    "Unicode-3.0",
];

/// States its licence in a file: Apache-2.0, as Embree itself.
const BY_FILE: [&str; 1] = ["embree4-sys"];

/// Whether an expression like `(MIT OR Apache-2.0) AND Unicode-3.0` can be met.
fn fits(expression: &str) -> bool {
    let all =
        |side: &str| side.split(" OR ").flat_map(|side| side.split('/')).any(|name| LICENCES.contains(&name.trim()));
    expression.split(" AND ").all(|side| all(side.trim().trim_matches(['(', ')'])))
}

#[test]
fn every_dependency_has_a_licence_that_fits_and_comes_from_the_registry() {
    let target = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let metadata = ["metadata", "--locked", "--offline", "--format-version", "1", "--filter-platform", &target];
    let output = Command::new(env!("CARGO")).args(metadata).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    assert!(packages.len() > 50, "{}", packages.len());
    for package in packages {
        let name = package["name"].as_str().unwrap();
        match package["license"].as_str() {
            Some(licence) => assert!(fits(licence), "{name}: {licence}"),
            None => assert!(BY_FILE.contains(&name), "{name} states no licence"),
        }
        let registry = "registry+https://github.com/rust-lang/crates.io-index";
        assert!(name == "pellicle" || package["source"] == registry, "{name} comes from {}", package["source"]);
    }
    assert!(!fits("GPL-3.0-only") && !fits("MIT AND GPL-2.0") && fits("0BSD OR MIT OR Apache-2.0"));
}
