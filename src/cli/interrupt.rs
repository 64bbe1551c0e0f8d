//! Ctrl-C: the first one ends a run with what it has learnt, the second one ends the process.

use super::Failure;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit code of an interrupted run, as that of a process ended by Ctrl-C.
const CODE: u8 = 130;

/// Whether SIGINT (Ctrl-C) or SIGTERM (what batch systems send before they kill) has come.
///
/// SIGHUP is left alone, so that `nohup` keeps its meaning.
#[derive(Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// From now on the first such signal is only noted.
    pub fn catch() -> Result<Self, Failure> {
        let set = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this sequence: the first signal finds nothing set and sets it, the second ends the process.
            flag::register_conditional_shutdown(signal, i32::from(CODE), Arc::clone(&set))
                .and_then(|_| flag::register(signal, Arc::clone(&set)))
                .map_err(|error| Failure::System(format!("cannot catch signal {signal}: {error}")))?;
        }
        Ok(Self(set))
    }

    /// Whether it has come.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// What is set when it comes.
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }

    /// What the process then answers.
    pub fn exit_code() -> ExitCode {
        ExitCode::from(CODE)
    }
}
