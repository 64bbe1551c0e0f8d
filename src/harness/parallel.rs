//! Pieces of work on all threads. The machinery of rayon is compiled here once, and not again for each kind of work.

use rayon::prelude::*;
use std::sync::Mutex;

/// What `piece` gives for 0, …, count − 1, in this sequence; on the threads of the rayon pool from which it is called.
pub fn parallel<R: Send>(count: usize, piece: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let places: Vec<Mutex<Option<R>>> = (0..count).map(|_| Mutex::default()).collect();
    each(count, &|k| {
        let value = piece(k);
        if let Ok(mut place) = places[k].lock() {
            *place = Some(value);
        }
    });
    places.into_iter().filter_map(|place| place.into_inner().ok().flatten()).collect()
}

#[inline(never)]
fn each(count: usize, piece: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().with_max_len(1).for_each(piece);
}
