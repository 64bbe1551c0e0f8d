//! The case: one plain value that describes algebra, inertia, force, tableau, retraction, state and step.
