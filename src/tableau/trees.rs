//! Rooted trees with coloured edges, generated, never listed: they index the order conditions.
//!
//! A tree is its root with a multiset of branches (colour of the edge, subtree). Trees are numbered in the order of
//! generation, by order (number of vertices) first, and branches refer to earlier trees by number, so that whatever is
//! computed for a tree is computed once.

use std::fmt::Write;

/// An edge from the root of a tree to the root of a subtree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Branch {
    /// The number of the subtree in its [`Catalogue`].
    pub tree: usize,
    /// The colour of the edge, from 0.
    pub colour: usize,
}

/// A rooted tree; two trees of one [`Catalogue`] are equal if and only if their branches are.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Tree {
    order: usize,
    density: u64,
    symmetry: u64,
    branches: Vec<Branch>,
}

impl Tree {
    /// The number of vertices.
    pub fn order(&self) -> usize {
        self.order
    }

    /// γ: the order times the product of the densities of the subtrees (Butcher 1963); colours do not matter.
    pub fn density(&self) -> u64 {
        self.density
    }

    /// σ: the number of automorphisms that keep the root and the colours, Π m! σ(u)^m over the distinct branches with their
    /// multiplicities m (Butcher 1963); at most 19!, for a bush of order 20.
    pub fn symmetry(&self) -> u64 {
        self.symmetry
    }

    /// The branches at the root, in non-increasing order.
    pub fn branches(&self) -> &[Branch] {
        &self.branches
    }
}

/// The largest order of a tree: its density, at most 20!, fits in 64 bits.
pub const MAX_ORDER: usize = 20;

/// The rooted trees up to some order with edges of 1, 2, … colours.
///
/// One colour: 1, 1, 2, 4, 9, 20, 48, … trees of order 1, 2, …; two colours: 1, 2, 7, 26, 107, 458, …
#[derive(Clone, Debug)]
pub struct Catalogue {
    colours: usize,
    trees: Vec<Tree>,
    /// The number of trees of order at most n.
    upto: Vec<usize>,
}

impl Catalogue {
    /// An empty catalogue for edges of `colours` (at least 1) colours; see [`Catalogue::extend_to`].
    pub fn new(colours: usize) -> Self {
        Self { colours: colours.max(1), trees: Vec::new(), upto: vec![0] }
    }

    /// All trees up to `order` (at most [`MAX_ORDER`]).
    pub fn up_to(colours: usize, order: usize) -> Self {
        let mut catalogue = Self::new(colours);
        catalogue.extend_to(order);
        catalogue
    }

    /// Adds the missing trees up to `order` (at most [`MAX_ORDER`]).
    pub fn extend_to(&mut self, order: usize) {
        for n in self.order() + 1..=order.min(MAX_ORDER) {
            let new: Vec<Tree> = self.grown(n, n - 1).collect();
            self.trees.extend(new);
            self.upto.push(self.trees.len());
        }
    }

    /// The order up to which the catalogue is complete.
    pub fn order(&self) -> usize {
        self.upto.len() - 1
    }

    /// The number of colours.
    pub fn colours(&self) -> usize {
        self.colours
    }

    /// All trees, in the order of their numbers.
    pub fn trees(&self) -> &[Tree] {
        &self.trees
    }

    /// The trees of order n (none beyond [`Catalogue::order`]).
    pub fn of_order(&self, n: usize) -> &[Tree] {
        if n == 0 || n > self.order() { &[] } else { &self.trees[self.upto[n - 1]..self.upto[n]] }
    }

    /// The tree of order n whose root carries these branches.
    fn grow(&self, branches: Vec<Branch>) -> Tree {
        let order = 1 + branches.iter().map(|e| self.trees[e.tree].order).sum::<usize>();
        let density = branches.iter().map(|e| self.trees[e.tree].density).product::<u64>() * order as u64;
        // Equal branches are neighbours: the m-th of a kind contributes m σ(u).
        let (mut symmetry, mut equal) = (1, 0);
        for (at, edge) in branches.iter().enumerate() {
            equal = if at > 0 && branches[at - 1] == *edge { equal + 1 } else { 1 };
            symmetry *= equal * self.trees[edge.tree].symmetry;
        }
        Tree { order, density, symmetry, branches }
    }

    /// The trees of order `n` all of whose branches have order at most `limit`, which the catalogue must hold.
    fn grown(&self, n: usize, limit: usize) -> impl Iterator<Item = Tree> + '_ {
        let counts = self.upto[..=limit.min(self.order())].iter().map(|count| count * self.colours).collect();
        let weight = |edge: usize| self.trees[edge / self.colours].order;
        Multisets::new(n - 1, counts, weight).map(|edges| self.grow(edges.iter().map(|&e| self.edge(e)).collect()))
    }

    fn edge(&self, number: usize) -> Branch {
        Branch { tree: number / self.colours, colour: number % self.colours }
    }

    /// One rooted tree for each *oriented free tree* with n vertices: 1, 1, 3, 8, 27, 91, 350, … of them.
    ///
    /// Two colours are needed: an edge of colour 0 points away from the root, one of colour 1 towards it. Each oriented
    /// tree is rooted at its centroid; when there are two, at the one from which the edge between them points away.
    /// So every branch has order at most n/2, and the catalogue must be complete up to there.
    pub fn oriented(&self, n: usize) -> impl Iterator<Item = Tree> + '_ {
        let one_centroid = self.grown(n, n.saturating_sub(1) / 2);
        let half = if n.is_multiple_of(2) && n / 2 <= self.order() { n / 2 } else { 0 };
        let halves = if half == 0 { 0..0 } else { self.upto[half - 1]..self.upto[half] };
        let two_centroids = halves.clone().flat_map(move |u| {
            halves.clone().map(move |v| {
                let mut branches = self.trees[u].branches.clone();
                branches.push(Branch { tree: v, colour: 0 });
                branches.sort_by(|x, y| y.cmp(x));
                self.grow(branches)
            })
        });
        one_centroid.chain(two_centroids)
    }

    /// The tree as text: `[…]` a root with its branches, one tick after a branch for each unit of its colour.
    ///
    /// The single vertex is `[]`; `[[][]']` has an edge of colour 0 and one of colour 1.
    pub fn show(&self, tree: &Tree) -> String {
        let mut text = String::from("[");
        for edge in &tree.branches {
            let _ = write!(text, "{}{}", self.show(&self.trees[edge.tree]), "'".repeat(edge.colour));
        }
        text.push(']');
        text
    }
}

/// All multisets of numbered items with a given sum of weights, each as a non-increasing sequence of numbers.
///
/// Weights are non-decreasing in the number, and item 0 has weight 1: so any start can be completed, and the next multiset
/// comes from lowering the last number that is not 0 and filling up greedily.
struct Multisets<W> {
    /// How many items have weight at most r.
    counts: Vec<usize>,
    weight: W,
    next: Option<Vec<usize>>,
}

impl<W: Fn(usize) -> usize> Multisets<W> {
    fn new(sum: usize, counts: Vec<usize>, weight: W) -> Self {
        let empty = sum > 0 && counts.get(1).is_none_or(|&count| count == 0);
        let mut all = Self { counts, weight, next: None };
        all.next = (!empty).then(|| all.filled(Vec::new(), sum));
        all
    }

    /// What is chosen, with as much behind it as it lacks.
    fn filled(&self, mut chosen: Vec<usize>, mut rest: usize) -> Vec<usize> {
        while rest > 0 {
            let fitting = self.counts[rest.min(self.counts.len() - 1)] - 1;
            let item = chosen.last().map_or(fitting, |&last| fitting.min(last));
            rest -= (self.weight)(item);
            chosen.push(item);
        }
        chosen
    }
}

impl<W: Fn(usize) -> usize> Iterator for Multisets<W> {
    type Item = Vec<usize>;

    fn next(&mut self) -> Option<Vec<usize>> {
        let current = self.next.take()?;
        if let Some(at) = current.iter().rposition(|item| *item > 0) {
            let (last, mut chosen) = (current[at], current[..at].to_vec());
            chosen.push(last - 1);
            let rest = current.len() - 1 - at + (self.weight)(last) - (self.weight)(last - 1);
            self.next = Some(self.filled(chosen, rest));
        }
        Some(current)
    }
}
