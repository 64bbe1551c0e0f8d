//! x
use super::CaseLaw;
/// x
pub const LAWS: &[CaseLaw] = &[];
