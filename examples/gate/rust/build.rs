// Cargo: fails the build if `norma check` refuses a mesh below assets/. Needs serde_json under [build-dependencies]. This file was not compiled here: no test runs it.
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=assets");
    let norma = std::env::var("NORMA").unwrap_or_else(|_| "norma".into());
    let run = Command::new(norma)
        .args(["check", "assets", "--format", "json", "--profile", "generated"])
        .output()
        .expect("norma is not installed");
    let report: serde_json::Value = serde_json::from_slice(&run.stdout).expect("norma check printed no JSON");
    let text = |value: &serde_json::Value, key: &str| value[key].as_str().unwrap_or("").to_owned();
    for file in report["files"].as_array().into_iter().flatten() {
        for finding in file["findings"].as_array().into_iter().flatten() {
            if text(finding, "severity") != "info" {
                println!("cargo:warning={}: {} {}: {} Usual cause: {}", text(file, "path"), text(finding, "severity"), text(finding, "rule"), text(finding, "message"), text(finding, "cause"));
            }
        }
    }
    assert!(run.status.success(), "norma check refuses meshes of assets; the warnings say which");
}
