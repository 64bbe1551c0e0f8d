//! Fused multiply-add of the machine it runs on: products in 32 digits are made of it, and a build for any machine
//! calls a function for each.

/// f(a, b), compiled with the fused multiply-add of the machine where it has one. The result is the same: a fused
/// multiply-add is rounded once, by whatever means.
#[inline(always)]
pub(super) fn apply<A, B, R>(a: A, b: B, f: impl Fn(A, B) -> R) -> R {
    #[cfg(all(target_arch = "x86_64", not(target_feature = "fma")))]
    if std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the machine has the feature.
        return unsafe { with_fma(a, b, f) };
    }
    f(a, b)
}

#[cfg(all(target_arch = "x86_64", not(target_feature = "fma")))]
#[target_feature(enable = "fma")]
fn with_fma<A, B, R>(a: A, b: B, f: impl Fn(A, B) -> R) -> R {
    f(a, b)
}

/// A function whose body is compiled twice, for machines with and without a fused multiply-add, and called once. What the body calls has
/// to be compiled in its place (`#[inline(always)]` throughout): a closure of some size is not.
macro_rules! loops {
    ($($(#[$doc:meta])* fn $name:ident<$($g:ident: $bound:path),*>($($x:ident: $type:ty),* $(,)?) $body:block)*) => {$(
        $(#[$doc])*
        #[inline(never)]
        pub(crate) fn $name<$($g: $bound),*>($($x: $type),*) {
            #[inline(always)]
            fn run<$($g: $bound),*>($($x: $type),*) $body

            #[cfg(all(target_arch = "x86_64", not(target_feature = "fma")))]
            #[target_feature(enable = "fma")]
            fn run_with_fma<$($g: $bound),*>($($x: $type),*) {
                run($($x),*);
            }

            #[cfg(all(target_arch = "x86_64", not(target_feature = "fma")))]
            if std::arch::is_x86_feature_detected!("fma") {
                // SAFETY: the machine has the feature.
                return unsafe { run_with_fma($($x),*) };
            }
            run($($x),*);
        }
    )*};
}
pub(super) use loops;
