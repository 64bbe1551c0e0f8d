//! Lie groupoids: the abstraction, and the instances of the doubled theory.
