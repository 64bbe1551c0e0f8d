//! What the figures were measured on: processor, compiler, clock, and how many multiply-adds a second one thread does.

use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// The machine and the build.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// The name the processor gives itself.
    pub processor: String,
    /// Threads that can run at once.
    pub threads: usize,
    /// The widest vectors of multiply-adds it has.
    pub vectors: &'static str,
    /// The clock while it is busy with integers, in GHz: from the latency (3) of a multiplication; x86-64 only.
    pub gigahertz: Option<f64>,
    /// Multiply-adds of `f64` a second on one thread, in 10⁹: the most that was reached.
    pub fma_peak: f64,
    /// The compiler.
    pub rustc: &'static str,
    /// The flags it was given by `RUSTFLAGS` or a configuration file.
    pub rustflags: &'static str,
    /// The packages that take part, with their versions.
    pub packages: Vec<String>,
}

impl Machine {
    /// Asks and measures.
    pub fn find() -> Self {
        let (vectors, fma_peak) = multiply_adds();
        Self {
            processor: processor(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            vectors,
            gigahertz: gigahertz(),
            fma_peak,
            rustc: env!("PEERS_RUSTC"),
            rustflags: env!("PEERS_RUSTFLAGS"),
            packages: packages(),
        }
    }

    /// A few lines for people.
    pub fn describe(&self) -> String {
        let flags = if self.rustflags.is_empty() { "no special flags" } else { self.rustflags };
        let clock = self.gigahertz.map_or(String::new(), |g| format!(", {g:.2} GHz"));
        format!(
            "{}, {} threads, {}{clock}; {:.1}e9 multiply-adds a second on one thread\n{}, {flags}\n{}",
            self.processor,
            self.threads,
            self.vectors,
            self.fma_peak,
            self.rustc,
            self.packages.join(", ")
        )
    }
}

fn processor() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = known.lines().find(|line| line.starts_with(name))?;
        line.split_once(':').map(|(_, value)| value.trim().to_string())
    };
    let Some(name) = field("model name") else {
        return format!("{} processor", std::env::consts::ARCH);
    };
    // Virtual machines hide the name; the numbers tell the generation.
    match (field("cpu family"), field("model\t")) {
        (Some(family), Some(model)) => format!("{name} (family {family}, model {model})"),
        _ => name,
    }
}

/// The packages of this comparison, as the lock file has them.
fn packages() -> Vec<String> {
    let lock = include_str!("../Cargo.lock");
    let mut names = vec!["ode_solvers", "ivp", "differential-equations"];
    if cfg!(feature = "russell") {
        names.push("russell_ode");
    }
    if cfg!(feature = "diffsol") {
        names.push("diffsol");
    }
    let version = |name: &str| {
        let (_, rest) = lock.split_once(&format!("name = \"{name}\"\nversion = \""))?;
        rest.split_once('"').map(|(version, _)| format!("{name} {version}"))
    };
    names.into_iter().filter_map(version).collect()
}

/// The best of some runs of `work` operations, in 10⁹ a second.
fn best(work: f64, mut run: impl FnMut()) -> f64 {
    (0..40).fold(0.0f64, |best, _| {
        let start = Instant::now();
        run();
        best.max(work / start.elapsed().as_secs_f64() / 1e9)
    })
}

/// A chain of multiplications, each of which waits three cycles for the one before (on every x86-64 since 2008).
#[cfg(target_arch = "x86_64")]
fn gigahertz() -> Option<f64> {
    const CHAIN: usize = 300_000;
    Some(best(3.0 * CHAIN as f64, || {
        let mut x = black_box(3u64);
        for _ in 0..CHAIN / 10 {
            // SAFETY: integer arithmetic in one register.
            unsafe {
                std::arch::asm!(
                    "imul {x}, {x}", "imul {x}, {x}", "imul {x}, {x}", "imul {x}, {x}", "imul {x}, {x}",
                    "imul {x}, {x}", "imul {x}, {x}", "imul {x}, {x}", "imul {x}, {x}", "imul {x}, {x}",
                    x = inout(reg) x, options(pure, nomem, nostack)
                );
            }
        }
        black_box(x);
    }))
}

#[cfg(not(target_arch = "x86_64"))]
fn gigahertz() -> Option<f64> {
    None
}

/// Chains of multiply-adds side by side: enough to hide a latency of five on two units.
const CHAINS: usize = 12;
/// Multiply-adds in a chain.
const LENGTH: usize = 20_000;

/// The widest kind that the processor has, and its rate.
#[cfg(target_arch = "x86_64")]
fn multiply_adds() -> (&'static str, f64) {
    let work = |lanes: usize| (CHAINS * LENGTH * lanes) as f64;
    // SAFETY (both): the features have been detected.
    if is_x86_feature_detected!("avx512f") {
        return ("AVX-512", best(work(8), || unsafe { vectors::wide(black_box(0.5)) }));
    }
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        return ("AVX2", best(work(4), || unsafe { vectors::narrow(black_box(0.5)) }));
    }
    ("no vectors of multiply-adds", best(work(1), scalars))
}

#[cfg(not(target_arch = "x86_64"))]
fn multiply_adds() -> (&'static str, f64) {
    ("vectors unknown", best((CHAINS * LENGTH) as f64, scalars))
}

/// One number at a time; a multiplication and an addition where there is no instruction for both.
fn scalars() {
    let mut x = [black_box(0.5f64); CHAINS];
    for _ in 0..LENGTH {
        for x in &mut x {
            *x = if cfg!(target_feature = "fma") { x.mul_add(0.5, 0.25) } else { *x * 0.5 + 0.25 };
        }
    }
    black_box(x);
}

#[cfg(target_arch = "x86_64")]
mod vectors {
    use super::{CHAINS, LENGTH};
    use std::arch::x86_64::*;
    use std::hint::black_box;

    /// # Safety
    /// The processor has AVX-512F.
    #[target_feature(enable = "avx512f")]
    pub unsafe fn wide(start: f64) {
        let (half, quarter) = (_mm512_set1_pd(0.5), _mm512_set1_pd(0.25));
        let mut x = [_mm512_set1_pd(start); CHAINS];
        for _ in 0..LENGTH {
            for x in &mut x {
                *x = _mm512_fmadd_pd(*x, half, quarter);
            }
        }
        black_box(x);
    }

    /// # Safety
    /// The processor has AVX2 and FMA.
    #[target_feature(enable = "avx2,fma")]
    pub unsafe fn narrow(start: f64) {
        let (half, quarter) = (_mm256_set1_pd(0.5), _mm256_set1_pd(0.25));
        let mut x = [_mm256_set1_pd(start); CHAINS];
        for _ in 0..LENGTH {
            for x in &mut x {
                *x = _mm256_fmadd_pd(*x, half, quarter);
            }
        }
        black_box(x);
    }
}
