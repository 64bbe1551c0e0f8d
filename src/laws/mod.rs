//! The laws: generators, oracles and planted faults, one file per module that they judge.
pub mod planted;
