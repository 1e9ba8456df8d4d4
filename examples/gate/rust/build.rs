// Cargo: fails the build if `norma check` refuses a mesh below assets/. Needs serde_json under [build-dependencies]. NORMA names another program than the norma of the path.
use std::process::{exit, Command};

fn stop(why: &str) -> ! {
    eprintln!("{}", why);
    exit(1)
}

fn main() {
    println!("cargo:rerun-if-changed=assets");
    println!("cargo:rerun-if-env-changed=NORMA");
    let norma = std::env::var("NORMA").unwrap_or_else(|_| "norma".into());
    let run = Command::new(&norma)
        .args(["check", "assets", "--format", "json", "--profile", "generated"])
        .output()
        .unwrap_or_else(|error| stop(&format!("{}: cannot be run: {}", norma, error)));
    let report: serde_json::Value = serde_json::from_slice(&run.stdout)
        .unwrap_or_else(|_| stop(&format!("norma check assets: {}", String::from_utf8_lossy(&run.stderr))));
    let text = |value: &serde_json::Value, key: &str| value[key].as_str().unwrap_or("").to_owned();
    for file in report["files"].as_array().into_iter().flatten() {
        for finding in file["findings"].as_array().into_iter().flatten() {
            if text(finding, "severity") != "info" {
                println!(
                    "cargo:warning={}: {} {}: {}. Usual cause: {}",
                    text(file, "path"), text(finding, "severity"), text(finding, "rule"), text(finding, "message"), text(finding, "cause")
                );
            }
        }
    }
    if !run.status.success() {
        stop("norma check refuses meshes of assets; the warnings say which")
    }
}
