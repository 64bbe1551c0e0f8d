//! What users write: laws on their own types (`laws!`), and on parts of a system.

mod own;
mod parts;
