//! Instructions of a step, for each kernel, counted by callgrind and compared with the snapshot.

mod count;
mod kernels;

use count::Missing;
use kernels::KERNELS;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
usage: instructions [--update] [--only WORD] [--snapshot PATH]

Counts the instructions of a step of each kernel under callgrind and compares them with snapshots/instructions.txt.

  --update         writes the snapshot instead
  --only WORD      only kernels that have the word in their name
  --snapshot PATH  another snapshot
";

/// The largest relative difference that passes: rounding moves an iteration count now and then, code moves it more.
const BOUND: f64 = 0.02;

#[derive(Default)]
struct Arguments {
    update: bool,
    only: String,
    snapshot: Option<PathBuf>,
    /// Given by this program to itself, under callgrind.
    kernel: Option<String>,
}

/// What the snapshot says.
#[derive(Default)]
struct Snapshot {
    build: String,
    counts: BTreeMap<String, u64>,
}

fn arguments() -> Result<Arguments, String> {
    let mut arguments = Arguments::default();
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value\n\n{USAGE}"));
        match word.as_str() {
            "--update" => arguments.update = true,
            "--only" => arguments.only = value()?,
            "--snapshot" => arguments.snapshot = Some(value()?.into()),
            "--kernel" => arguments.kernel = Some(value()?),
            _ => return Err(format!("unknown argument {word}\n\n{USAGE}")),
        }
    }
    Ok(arguments)
}

/// The compiler, its flags, the target and the vectors that callgrind can offer: other builds have other counts.
fn build() -> String {
    format!("{}, {}{}", env!("INSTRUCTIONS_BUILD"), env!("INSTRUCTIONS_TARGET"), vectors())
}

#[cfg(target_arch = "x86_64")]
fn vectors() -> &'static str {
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") { " with AVX2" } else { "" }
}

#[cfg(not(target_arch = "x86_64"))]
fn vectors() -> &'static str {
    ""
}

impl Snapshot {
    fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let mut snapshot = Self::default();
        for line in text.lines() {
            if let Some(build) = line.strip_prefix("# build: ") {
                snapshot.build = build.into();
            } else if !line.starts_with('#') {
                let entry = line.split_once(' ').and_then(|(name, n)| Some((name.to_string(), n.trim().parse().ok()?)));
                let (name, count) = entry.ok_or_else(|| format!("{}: no count in {line:?}", path.display()))?;
                snapshot.counts.insert(name, count);
            }
        }
        Ok(snapshot)
    }

    fn text(&self) -> String {
        let mut text = String::from("# Instructions of a step, by callgrind: benches/instructions, with --update\n");
        let _ = writeln!(text, "# build: {}", self.build);
        for (name, count) in &self.counts {
            let _ = writeln!(text, "{name:32} {count:>9}");
        }
        text
    }
}

/// Prints each kernel beside its snapshot; returns how many differ.
fn compare(counts: &BTreeMap<String, u64>, known: &Snapshot, all: bool) -> usize {
    let mut different = 0;
    for (name, &count) in counts {
        let verdict = match known.counts.get(name) {
            None => "not in the snapshot".to_string(),
            Some(&before) => {
                let change = count as f64 / before as f64 - 1.0;
                let outside = if change.abs() > BOUND { ", outside the bound" } else { "" };
                format!("{:+.2} % from {before}{outside}", 100.0 * change)
            }
        };
        different += usize::from(!verdict.contains('%') || verdict.contains("outside"));
        println!("{name:32} {count:>9}  {verdict}");
    }
    for name in known.counts.keys().filter(|name| all && !counts.contains_key(*name)) {
        println!("{name:32} {:>9}  in the snapshot, but no kernel", "");
        different += 1;
    }
    different
}

fn run(arguments: &Arguments) -> Result<bool, String> {
    if let Some(name) = &arguments.kernel {
        let kernel = KERNELS.iter().find(|k| k.name == name).ok_or_else(|| format!("no kernel {name}"))?;
        count::run(kernel);
        return Ok(true);
    }
    let path = arguments
        .snapshot
        .clone()
        .unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../snapshots/instructions.txt"));
    let version = match count::valgrind() {
        Ok(version) => version,
        Err(Missing::Valgrind) => {
            println!("instruction counts: NOT RUN: there is no valgrind here");
            return Ok(true);
        }
        Err(Missing::Failed(why)) => return Err(why),
    };
    println!("{version}; {}", build());
    let mut counts = BTreeMap::new();
    for kernel in KERNELS.iter().filter(|k| k.name.contains(&arguments.only)) {
        match count::count(kernel) {
            Ok(n) => counts.insert(kernel.name.to_string(), n),
            Err(Missing::Failed(why)) => return Err(why),
            Err(Missing::Valgrind) => return Err("valgrind has disappeared".into()),
        };
    }
    if arguments.update {
        let mut snapshot = Snapshot { build: build(), counts };
        if !arguments.only.is_empty() {
            let old = Snapshot::read(&path)?;
            if old.build != snapshot.build {
                return Err(format!("the other counts are of another build ({}): update them all", old.build));
            }
            old.counts.into_iter().for_each(|(name, n)| {
                snapshot.counts.entry(name).or_insert(n);
            });
        }
        std::fs::write(&path, snapshot.text()).map_err(|e| format!("{}: {e}", path.display()))?;
        print!("{}", snapshot.text());
        return Ok(true);
    }
    let known = Snapshot::read(&path)?;
    let different = compare(&counts, &known, arguments.only.is_empty());
    if known.build != build() {
        println!("instruction counts: NOT JUDGED: the snapshot is of another build ({})", known.build);
        return Ok(true);
    }
    match different {
        0 => println!("instruction counts: {} kernels within {:.0} %", counts.len(), 100.0 * BOUND),
        n => println!("instruction counts: {n} of {} differ; if that is meant, run it with --update", counts.len()),
    }
    Ok(different == 0)
}

fn main() -> ExitCode {
    match arguments().and_then(|arguments| run(&arguments)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
