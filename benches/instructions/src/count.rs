//! Counting: this program under callgrind, which collects only while [`instructions_measured`] runs.

use crate::kernels::{Kernel, Step};
use std::hint::black_box;
use std::io;
use std::process::Command;

/// Steps before the count: caches of the method are filled, the stages are warm.
const BEFORE: usize = 4;
/// Steps that are counted.
const COUNTED: usize = 16;

/// The function whose instructions are collected, with everything that it calls; callgrind knows it by this name.
#[unsafe(no_mangle)]
#[inline(never)]
extern "Rust" fn instructions_measured(step: &mut Step, steps: usize) {
    for _ in 0..steps {
        step();
    }
}

/// What is run under callgrind.
pub fn run(kernel: &Kernel) {
    let mut step = (kernel.start)();
    for _ in 0..BEFORE {
        step();
    }
    instructions_measured(black_box(&mut step), black_box(COUNTED));
}

/// Why there is no count.
#[derive(Debug)]
pub enum Missing {
    /// There is no valgrind.
    Valgrind,
    /// It did not work.
    Failed(String),
}

/// The version of valgrind.
///
/// # Errors
/// There is none, or it does not run.
pub fn valgrind() -> Result<String, Missing> {
    match Command::new("valgrind").arg("--version").output() {
        Ok(output) => Ok(String::from_utf8_lossy(&output.stdout).trim().to_string()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Err(Missing::Valgrind),
        Err(error) => Err(Missing::Failed(error.to_string())),
    }
}

/// Instructions of one step.
///
/// # Errors
/// Callgrind fails, or prints no count.
pub fn count(kernel: &Kernel) -> Result<u64, Missing> {
    let failed = |why: String| Missing::Failed(format!("{}: {why}", kernel.name));
    let program = std::env::current_exe().map_err(|e| failed(e.to_string()))?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .args(["--collect-atstart=no", "--toggle-collect=instructions_measured"])
        .arg(program)
        .args(["--kernel", kernel.name])
        .output()
        .map_err(|e| failed(e.to_string()))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(failed(said.into_owned()));
    }
    // "==123== Collected : 456"
    let collected = said.lines().find_map(|line| line.split_once("Collected :"));
    let total: u64 = collected.and_then(|(_, n)| n.trim().parse().ok()).ok_or_else(|| failed(said.to_string()))?;
    if total == 0 {
        return Err(failed("nothing was collected".into()));
    }
    Ok(total / COUNTED as u64)
}
