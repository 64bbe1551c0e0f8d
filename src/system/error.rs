//! What can be wrong with a case, and where: errors that a file reader can map back to a line.

use crate::algebra::AlgebraError;
use crate::expression::ExpressionError;
use crate::mechanics::LegendreError;
use crate::mechanics::force::ForceError;
use crate::retraction::RetractionError;
use crate::scalar::NumberError;
use crate::tableau::TableauError;
use std::borrow::Cow;
use std::fmt;

/// One segment of a [`Place`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Segment {
    /// A key of a table; the user may have chosen it.
    Key(Cow<'static, str>),
    /// An index into a list, from 0 (printed from 1).
    Index(usize),
}

/// Where in a case something is: `force[2].matrix[1][3]`, indices printed from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Place(Vec<Segment>);

impl Place {
    /// The top level.
    pub fn root() -> Self {
        Self::default()
    }

    fn with(&self, segment: Segment) -> Self {
        Self(self.0.iter().cloned().chain([segment]).collect())
    }

    /// The key `key` of this place.
    pub fn key(&self, key: &'static str) -> Self {
        self.with(Segment::Key(key.into()))
    }

    /// The key `name` of this place, which the user chose.
    pub fn name(&self, name: &str) -> Self {
        self.with(Segment::Key(name.to_owned().into()))
    }

    /// Item `index` (from 0) of this place.
    pub fn index(&self, index: usize) -> Self {
        self.with(Segment::Index(index))
    }

    /// The segments, outermost first.
    pub fn segments(&self) -> &[Segment] {
        &self.0
    }

    /// The error `problem`, here.
    pub fn error(&self, problem: impl Into<CaseProblem>) -> CaseError {
        CaseError { place: self.clone(), problem: problem.into() }
    }

    /// A value here that is not allowed.
    pub(crate) fn range(&self, found: impl ToString, allowed: impl Into<String>) -> CaseError {
        self.error(CaseProblem::Range { found: found.to_string(), allowed: allowed.into() })
    }

    /// What does not belong here.
    pub(crate) fn excess(&self, allowed: impl Into<String>) -> CaseError {
        self.error(CaseProblem::Excess { allowed: allowed.into() })
    }

    /// What is missing here.
    pub(crate) fn missing(&self, what: impl Into<Cow<'static, str>>, allowed: impl Into<String>) -> CaseError {
        self.error(CaseProblem::Missing { what: what.into(), allowed: allowed.into() })
    }

    /// What is not applicable here.
    pub(crate) fn inapplicable(&self, what: &'static str, why: impl Into<String>) -> CaseError {
        self.error(CaseProblem::NotApplicable { what: what.into(), why: why.into() })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("the system");
        }
        for (position, segment) in self.0.iter().enumerate() {
            match segment {
                Segment::Key(key) if position == 0 => write!(f, "{key}")?,
                Segment::Key(key) => write!(f, ".{key}")?,
                Segment::Index(index) => write!(f, "[{}]", index + 1)?,
            }
        }
        Ok(())
    }
}

/// What is wrong, with what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CaseProblem {
    /// A key is needed that is not there.
    #[error("{what} is missing: {allowed}")]
    Missing {
        /// The key, or the choice of keys.
        what: Cow<'static, str>,
        /// What it may be.
        allowed: String,
    },
    /// Two keys exclude each other, or a key does not belong here.
    #[error("does not belong here: {allowed}")]
    Excess {
        /// What is allowed instead.
        allowed: String,
    },
    /// A list has the wrong length.
    #[error("has {found} entries; allowed: {wanted} ({why})")]
    Length {
        /// Entries found.
        found: usize,
        /// Entries wanted.
        wanted: usize,
        /// Where that number comes from.
        why: &'static str,
    },
    /// A value outside its range.
    #[error("is {found}; allowed: {allowed}")]
    Range {
        /// The value, as it was written.
        found: String,
        /// The range.
        allowed: String,
    },
    /// A structure constant was given twice.
    #[error("gives C^{c}_{a}{b} a second time (antisymmetric partners are filled in; each constant may be given once)")]
    Duplicate {
        /// First lower index, from 1.
        a: usize,
        /// Second lower index, from 1.
        b: usize,
        /// Upper index, from 1.
        c: usize,
    },
    /// A number expression without a finite value.
    #[error("`{text}` has no finite value; allowed: finite numbers")]
    NotFinite {
        /// The expression.
        text: String,
    },
    /// An inertia that is not symmetric.
    #[error(
        "is not symmetric: entry [{row}][{column}] = {entry}, but [{column}][{row}] = {mirrored}; allowed: a list of diagonal entries, or a symmetric matrix by rows"
    )]
    NotSymmetric {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// I_rc, as written.
        entry: String,
        /// I_cr, as written.
        mirrored: String,
    },
    /// What was asked for needs something that the case does not have.
    #[error("{what} is not applicable: {why}")]
    NotApplicable {
        /// What was asked for.
        what: Cow<'static, str>,
        /// Why it cannot be had, and what can.
        why: String,
    },
    /// The structure constants or the basis were refused.
    #[error(transparent)]
    Algebra(#[from] AlgebraError),
    /// A number has no value.
    #[error("{0}; allowed: finite numbers, written as integers, decimals or texts such as \"1/3\" or \"sqrt(2)/2\"")]
    Number(NumberError),
    /// A formula was refused.
    #[error(transparent)]
    Formula(#[from] ExpressionError),
    /// The force was refused.
    #[error(transparent)]
    Force(#[from] ForceError),
    /// The tableau was refused.
    #[error(transparent)]
    Tableau(#[from] TableauError),
    /// The Lagrangian was refused, or could not be inverted at the initial state.
    #[error(transparent)]
    Legendre(#[from] LegendreError),
    /// The retraction was refused, or is not defined at the initial attitude.
    #[error(transparent)]
    Retraction(#[from] RetractionError),
    /// A part with an error of its own kind: its text.
    #[error("{0}")]
    Part(String),
}

impl CaseProblem {
    /// A part that is no part of the case.
    pub(crate) fn given(what: &'static str) -> Self {
        let why = "it is of a user's own type, which the case does not describe; `cargo test` replays such cases, in the crate \
                   that has the type";
        Self::NotApplicable { what: what.into(), why: why.into() }
    }
}

/// Why a case was refused: where, and what is allowed there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}: {problem}")]
#[non_exhaustive]
pub struct CaseError {
    /// Where.
    pub place: Place,
    /// What is wrong.
    pub problem: CaseProblem,
}
