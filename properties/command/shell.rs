//! What a shell needs from the command: completions, manual pages, and the version with its commit.

use super::{Ended, directory, has_all, run, stderr, stdout};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

const SUB_COMMANDS: [&str; 11] =
    ["verify", "merge", "replay", "report", "laws", "probe", "order", "paper", "integrate", "completions", "man"];

#[test]
fn completions_name_every_sub_command_and_option() {
    let here = directory("completions");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = run(&here, &["completions", shell]).quiet();
        has_all(stdout(&output), &format!("{} ¦ declared ¦ ensemble", SUB_COMMANDS.join(" ¦ ")));
    }
    run(&here, &["completions", "cmd"]).ends(2).says("bash");
}

#[test]
fn bash_reads_its_completions() {
    let here = directory("bash");
    let script = here.join("script");
    fs::write(&script, stdout(&run(&here, &["completions", "bash"]))).unwrap();
    // It completes `ver` to `verify`.
    let question = ". ./script; by=$(complete -p euler-poincare); by=${by##*-F }; \
                    COMP_WORDS=(euler-poincare ver); COMP_CWORD=1; ${by%% *} euler-poincare ver euler-poincare; \
                    echo \"${COMPREPLY[@]}\"";
    let Ok(output) = Command::new("bash").args(["-c", question]).current_dir(&here).output() else { return };
    assert_eq!(stdout(&output).trim(), "verify", "{}", stderr(&output));
}

#[test]
fn the_manual_has_a_page_for_each_sub_command() {
    let here = directory("man");
    let output = run(&here, &["man"]).ends(0);
    for part in [".TH", "SYNOPSIS", "EXIT CODES", "130"].into_iter().chain(SUB_COMMANDS) {
        assert!(stdout(&output).to_uppercase().contains(&part.to_uppercase()), "{part}\n{output}");
    }
    run(&here, &["man", "--out", "pages"]).ends(0);
    for ending in SUB_COMMANDS.map(|name| format!("-{name}")).into_iter().chain([String::new()]) {
        let name = format!("euler-poincare{ending}.1");
        let page = fs::read_to_string(here.join("pages").join(&name)).expect(&name);
        assert!(page.contains(".TH ") && page.contains("SYNOPSIS"), "{name}");
    }
}

/// What git says, where it is there and this is a clone.
fn git(arguments: &[&str]) -> Option<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
    (root.join(".git").exists() && output.status.success())
        .then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

#[test]
fn the_version_has_the_commit() {
    let here = directory("version");
    let output = run(&here, &["--version"]);
    let version = stdout(&output).trim();
    let plain = concat!("euler-poincare ", env!("CARGO_PKG_VERSION"));
    match git(&["rev-parse", "--short=12", "HEAD"]) {
        Some(commit) => {
            let allowed = [format!("{plain} ({commit})"), format!("{plain} ({commit}, modified)")];
            assert!(allowed.iter().any(|allowed| allowed == version), "{version}, at {commit}");
        }
        // A package may know its commit without git.
        None => assert!(version == plain || version.starts_with(&format!("{plain} (")), "{version}"),
    }
    assert_eq!(stdout(&run(&here, &["-V"])).trim(), version);
}

/// What the build script says in a directory.
fn built(script: &Path, package: &Path) -> Ended {
    Ended::of(Command::new(script).env("CARGO_MANIFEST_DIR", package).env("CARGO_PKG_VERSION", "1.2.3"))
}

#[test]
fn a_commit_is_that_of_the_package_or_none() {
    let here = directory("commit");
    let script = here.join("build-script");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("build.rs");
    let mut rustc = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    Ended::of(rustc.args(["--edition", "2024", "-o"]).args([&script, &source]).stdin(Stdio::null())).ends(0);

    // A clone of its own: git is asked when the command is compiled. Nothing in it is watched.
    let clone = here.join("clone");
    fs::create_dir_all(clone.join(".git")).unwrap();
    let said = built(&script, &clone);
    assert!(stdout(&said).contains("rustc-cfg=own_repository") && !stdout(&said).contains("EULER_POINCARE_VERSION"));
    // The script itself, and the pages of the guide.
    assert_eq!(stdout(&said).matches("rerun-if").count(), 2);

    // A copy inside of it has no commit.
    let vendored = clone.join("vendor").join("euler-poincare");
    fs::create_dir_all(&vendored).unwrap();
    let version = |package: &Path| {
        let said = built(&script, package);
        assert!(!stdout(&said).contains("rustc-cfg=own_repository"), "{said}");
        let version =
            stdout(&said).lines().find_map(|line| line.strip_prefix("cargo::rustc-env=EULER_POINCARE_VERSION="));
        version.expect("a version").to_owned()
    };
    assert_eq!(version(&vendored), "1.2.3");
    // A packed one has that which cargo noted.
    let noted = vendored.join(".cargo_vcs_info.json");
    fs::write(
        &noted,
        "{\n  \"git\": {\n    \"sha1\": \"a1b2c3d4e5f60718293a4b5c6d7e8f9012345678\"\n  },\n  \"path_in_vcs\": \"\"\n}",
    )
    .unwrap();
    assert_eq!(version(&vendored), "1.2.3 (a1b2c3d4e5f6)");
    fs::write(&noted, "{\"git\": {\"sha1\": \"a1b2c3d4e5f60718293a4b5c6d7e8f9012345678\", \"dirty\": true}}").unwrap();
    assert_eq!(version(&vendored), "1.2.3 (a1b2c3d4e5f6, modified)");
    for broken in ["", "{}", "{\"git\": {\"sha1\": \"a1b2\"}}", "{\"git\": {\"sha1\": \"\n cargo::rustc-env=X=\"}}"] {
        fs::write(&noted, broken).unwrap();
        assert_eq!(version(&vendored), "1.2.3", "{broken}");
    }
}
