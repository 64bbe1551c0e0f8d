//! The version with the commit: `0.1.0 (a1b2c3d4e5f6)`.

/// The version; the commit, where it is known; whether tracked files differed from it when the command was compiled.
///
/// In a clone the commit is asked of git while this crate is compiled, so that a commit compiles the library no second time.
#[cfg(own_repository)]
pub const VERSION: &str = git_version::git_version!(
    args = ["--always", "--abbrev=12", "--exclude=*", "--dirty=, modified"],
    prefix = concat!(env!("CARGO_PKG_VERSION"), " ("),
    suffix = ")",
    fallback = env!("CARGO_PKG_VERSION")
);

/// The version; the commit that the package was made from, where cargo noted it.
#[cfg(not(own_repository))]
pub const VERSION: &str = env!("EULER_POINCARE_VERSION");
