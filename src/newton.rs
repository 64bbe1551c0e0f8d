//! One nonlinear solver with a report.
