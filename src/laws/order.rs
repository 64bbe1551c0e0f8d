pub const LAWS: &[super::CaseLaw] = &[];
