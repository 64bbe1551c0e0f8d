//! The channel by which a check tells its numbers.

use euler_poincare::harness::evidence::{Evidence, gather, is_gathered, note, note_all};
use std::cell::Cell;
use std::panic::catch_unwind;

fn defect(defect: f64) -> Evidence {
    Evidence::Defect { digits: 16, defect, bound: 1.0, alone: 1.0, witness: "here".into() }
}

#[test]
fn nothing_is_made_where_nobody_gathers() {
    let made = Cell::new(0);
    let check = || {
        note(|| {
            made.set(made.get() + 1);
            defect(1.0)
        });
        7
    };
    assert_eq!((check(), made.get()), (7, 0));
    assert_eq!(gather(check), (7, vec![defect(1.0)]));
    assert_eq!((check(), made.get()), (7, 1));
    assert_eq!(gather(|| ()), ((), vec![]));
}

#[test]
fn the_innermost_gathers() {
    let (inner, outer) = gather(|| {
        note(|| defect(1.0));
        let inner = gather(|| {
            note_all(|| [defect(2.0), defect(3.0)]);
            is_gathered()
        });
        // A note that takes notes.
        note(|| {
            note(|| defect(4.0));
            defect(5.0)
        });
        inner
    });
    assert_eq!(inner, (true, vec![defect(2.0), defect(3.0)]));
    assert_eq!(outer, [1.0, 4.0, 5.0].map(defect));
}

#[test]
fn a_panic_leaves_nothing_behind() {
    let caught = catch_unwind(|| gather(|| panic!("as intended")));
    assert!(caught.is_err() && !is_gathered());
    note(|| panic!("nobody gathers"));
    let (_, outer) = gather(|| {
        note(|| defect(1.0));
        let caught = catch_unwind(|| {
            gather(|| {
                note(|| defect(2.0));
                panic!("as intended")
            })
        });
        assert!(caught.is_err());
        note(|| defect(3.0));
    });
    assert_eq!(outer, [1.0, 3.0].map(defect));
}

#[test]
fn threads_gather_apart() {
    let ((), here) = gather(|| {
        std::thread::scope(|scope| {
            scope.spawn(|| note(|| panic!("nobody gathers here")));
            scope.spawn(|| assert_eq!(gather(|| note(|| defect(2.0))).1, [defect(2.0)]));
        });
        note(|| defect(1.0));
    });
    assert_eq!(here, [defect(1.0)]);
}
