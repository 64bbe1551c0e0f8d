//! Which cases of which laws a campaign checks, and in which sequence they are begun.

use super::law::Cost;
use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// Part `index` of `count` of a campaign, from 0: of each law, the cases whose index is `index` modulo `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

/// Text that names no shard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a shard is i/n with 0 ≤ i < n ≤ 1000000, as 0/4, 1/4, 2/4, 3/4; \"{0}\" is none")]
#[non_exhaustive]
pub struct NoShard(pub String);

impl Shard {
    /// The whole campaign.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Shard `index` of `count`; `None` unless `index` < `count` ≤ 10⁶.
    pub fn new(index: usize, count: usize) -> Option<Self> {
        (index < count && count <= 1_000_000).then_some(Self { index, count })
    }

    /// Which of them, from 0.
    pub fn index(self) -> usize {
        self.index
    }

    /// How many there are.
    pub fn count(self) -> usize {
        self.count
    }

    /// Whether the case of this index is in it.
    pub fn owns(self, index: usize) -> bool {
        index % self.count == self.index
    }

    /// How many of the indices below `cases` are in it.
    pub fn size(self, cases: usize) -> usize {
        cases.saturating_sub(self.index).div_ceil(self.count)
    }

    /// Its case number `position`, from 0.
    fn nth(self, position: usize) -> usize {
        self.index + position * self.count
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = NoShard;

    fn from_str(text: &str) -> Result<Self, NoShard> {
        let number = |digits: &str| digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok()).flatten();
        let shard = text.split_once('/').and_then(|(i, n)| Self::new(number(i)?, number(n)?));
        shard.ok_or_else(|| NoShard(text.to_owned()))
    }
}

/// A set of the cases of one law in one shard. Small where the cases are nearly in their order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Done {
    shard: Shard,
    /// All positions below this are in it.
    next: usize,
    /// And these, which are larger.
    ahead: BTreeSet<usize>,
}

impl Done {
    /// The empty set.
    pub fn new(shard: Shard) -> Self {
        Self { shard, next: 0, ahead: BTreeSet::new() }
    }

    /// Adds a case; false where it was there already, or is not in the shard.
    pub fn insert(&mut self, index: usize) -> bool {
        let position = index / self.shard.count;
        if !self.shard.owns(index) || position < self.next || !self.ahead.insert(position) {
            return false;
        }
        while self.ahead.remove(&self.next) {
            self.next += 1;
        }
        true
    }

    /// How many cases are in it.
    pub fn len(&self) -> usize {
        self.next + self.ahead.len()
    }

    /// Whether no case is in it.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The least index of the shard that is not in it.
    pub fn first_missing(&self) -> usize {
        self.shard.nth(self.next)
    }

    fn contains_position(&self, position: usize) -> bool {
        position < self.next || self.ahead.contains(&position)
    }
}

/// What a block of cheap cases holds at most, so that the queue is asked less often.
const BLOCK: usize = 16;

/// The work that is left, given out in pieces.
///
/// The laws go forward side by side, each by the same share of its cases, so that a campaign that is stopped has the
/// composition of a smaller one; without a number of cases, by the shares that [`Cost::cases`] gives in the long run.
/// Where the number is given, those of higher cost are a little ahead: what is left for the end is short.
pub(super) struct Queue {
    shard: Shard,
    lanes: Vec<Lane>,
}

struct Lane {
    cost: Cost,
    /// Cases of the law in all shards; without a number, as many as are asked for.
    cases: Option<usize>,
    /// The next position of the shard.
    position: usize,
    done: Done,
}

impl Queue {
    /// For laws of these costs, in a campaign of `cases`, without what is done.
    pub fn new(laws: impl Iterator<Item = (Cost, Option<usize>)>, shard: Shard, done: Vec<Done>) -> Self {
        let lane =
            |((cost, cases), done): ((Cost, Option<usize>), Done)| Lane { cost, cases, position: done.next, done };
        Self { shard, lanes: laws.zip(done).map(lane).collect() }
    }

    /// A law and indices of its cases, ascending.
    pub fn next(&mut self) -> Option<(usize, Vec<usize>)> {
        let Self { shard, lanes } = self;
        // Those that are done are passed over first, so that a lane's rank is that of a case.
        for lane in lanes.iter_mut() {
            while lane.done.contains_position(lane.position) {
                lane.position += 1;
            }
        }
        let ranks = lanes.iter().enumerate().filter_map(|(law, lane)| {
            let index = shard.nth(lane.position);
            let within = lane.cases.is_none_or(|cases| index < cases);
            within.then(|| (lane.rank(index), std::cmp::Reverse(lane.cost), law))
        });
        let (.., law) = ranks.min_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))))?;
        let lane = &mut lanes[law];
        let size = if lane.cost == Cost::Cheap { BLOCK } else { 1 };
        let mut block = Vec::with_capacity(size);
        while block.len() < size {
            let index = shard.nth(lane.position);
            if lane.cases.is_some_and(|cases| index >= cases) {
                break;
            }
            if !lane.done.contains_position(lane.position) {
                block.push(index);
            }
            lane.position += 1;
        }
        Some((law, block))
    }
}

impl Lane {
    /// How far the campaign is when the case is begun.
    fn rank(&self, index: usize) -> f64 {
        match self.cases {
            Some(cases) => index as f64 / cases as f64 * ahead(self.cost),
            None => index as f64 * pace(self.cost),
        }
    }
}

/// Where in the campaign a law has begun all of its cases.
fn ahead(cost: Cost) -> f64 {
    match cost {
        Cost::Cheap => 1.0,
        Cost::Moderate => 0.95,
        Cost::Expensive => 0.85,
        Cost::Heavy => 0.7,
    }
}

/// How many cases a cheap law gets for one of this cost.
fn pace(cost: Cost) -> f64 {
    match cost {
        Cost::Cheap => 1.0,
        Cost::Moderate => 4.0,
        Cost::Expensive => 50.0,
        Cost::Heavy => 100.0,
    }
}
