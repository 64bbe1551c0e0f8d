//! `euler_poincare::laws!` on types of a user's own: they hold, and each mistake is found by a law that names it.

mod own {
    pub mod bianchi;
}

use euler_poincare::laws;
use euler_poincare::laws::own::{Outcome, Settings, Suite};
use own::bianchi::{Bianchi, Split, SplitMap, Stiff, Wind};

laws! {
    mod group<T, 3, 3> { group: Bianchi::<T>::new() }
}

laws! {
    mod everything<T, 3, 3> {
        group: Bianchi::<T>::new(),
        retraction: Split::<T>::new(),
        lagrangian: Stiff::<false>,
        force: Wind::<false>,
    }
}

laws! {
    mod from_map<T, 3, 3> {
        group: Bianchi::<T>::new(),
        map: SplitMap::<false>,
    }
}
