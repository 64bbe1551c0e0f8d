//! Running a check so that a panic is a finding, not the end of the campaign.

use super::law::{Fault, Law, Verdict};
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// How many guards are open on this thread.
    static GUARDS: Cell<usize> = const { Cell::new(0) };
    /// Where the last guarded panic of this thread happened.
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Makes the panic hook note the place instead of printing, on threads that have a guard open, and only there.
fn quiet_hook() {
    static INSTALL: Once = Once::new();
    INSTALL.call_once(|| {
        let previous = take_hook();
        set_hook(Box::new(move |info| {
            if GUARDS.get() == 0 {
                previous(info);
            } else {
                let place = info.location().map(|at| format!("{}:{}", at.file(), at.line())).unwrap_or_default();
                PLACE.set(place);
            }
        }));
    });
}

/// The value of `f`, or the message and place of its panic.
pub(crate) fn guarded<R>(f: impl FnOnce() -> R) -> Result<R, String> {
    quiet_hook();
    GUARDS.set(GUARDS.get() + 1);
    // What `f` touches is dropped with it or, like a value tree, not used again after a panic.
    let result = catch_unwind(AssertUnwindSafe(f));
    GUARDS.set(GUARDS.get() - 1);
    result.map_err(|payload| {
        let message = payload
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned())
            .or_else(|| payload.downcast_ref::<String>().cloned())
            .unwrap_or_else(|| "a panic without a message".to_owned());
        format!("{message} ({})", PLACE.take())
    })
}

/// The verdict of `law` on `case`, with `fault` planted if there is one. A panic is `Broken`, with message and place.
pub fn verdict_on<C>(law: &dyn Law<C>, case: &C, fault: Option<&Fault>) -> Verdict {
    guarded(|| law.check(case, fault)).unwrap_or_else(|panic| Verdict::broken(format!("the check panicked: {panic}")))
}
