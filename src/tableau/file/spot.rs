//! Entries of a tableau, and where they are in the text of a file.

use crate::file::Excerpt;
use crate::tableau::{Entries, TableauError, entry_name};
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use toml::de::{DeTable, DeValue};

/// A key of the file, or an entry of its list, or of a list in it; indices from 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spot {
    pub(crate) key: &'static str,
    pub(crate) indices: Vec<usize>,
}

impl Spot {
    /// What stands at a key.
    pub(super) fn of(key: &'static str) -> Self {
        Self { key, indices: Vec::new() }
    }

    /// An entry of the list here.
    pub(super) fn entry(&self, index: usize) -> Self {
        let mut indices = self.indices.clone();
        indices.push(index);
        Self { indices, ..*self }
    }

    /// Its name on paper: `a_12`, `row 2 of a`, `b_3`, `c`.
    pub(super) fn name(&self) -> String {
        match (self.key, &self.indices[..]) {
            ("a", [i, j]) => entry_name(*i, *j),
            ("a", [i]) => format!("row {} of a", i + 1),
            (key, [j]) => format!("{key}_{}", j + 1),
            (key, _) => key.into(),
        }
    }

    /// What an error of these entries is about.
    pub(crate) fn blamed(error: &TableauError, entries: &Entries) -> Self {
        let [a, b, c] = ["a", "b", "c"].map(Self::of);
        match error {
            TableauError::RowLength { row, .. } => a.entry(row - 1),
            TableauError::ZeroWeight { stage } => b.entry(stage - 1),
            TableauError::Empty | TableauError::Inconsistent { .. } => b,
            TableauError::BadEntry { entry, .. } | TableauError::NotFinite { entry } => {
                let of_a = |(i, row): (usize, &Vec<_>)| (0..row.len()).map(|j| a.entry(i).entry(j)).collect::<Vec<_>>();
                let of_a = entries.a.iter().enumerate().flat_map(of_a);
                let of_b = (0..entries.b.len()).map(|j| b.entry(j));
                let of_c = (0..entries.c.as_ref().map_or(0, Vec::len)).map(|i| c.entry(i));
                of_a.chain(of_b).chain(of_c).find(|spot| spot.name() == *entry).unwrap_or(c.clone())
            }
            TableauError::RowCount { .. } | TableauError::Unknown { .. } => a,
        }
    }

    /// Its place in the text, or that of the innermost list around it that is there.
    pub(super) fn place(&self, text: &str) -> Excerpt {
        let json = text.trim_start().starts_with('{');
        let at = if json { self.in_json(text) } else { self.in_toml(text) };
        Excerpt::of(text, at.unwrap_or(0))
    }

    fn in_toml(&self, text: &str) -> Option<usize> {
        let table = DeTable::parse(text).ok()?;
        let mut value = table.get_ref().iter().find(|(key, _)| key.get_ref() == self.key)?.1;
        for index in &self.indices {
            let DeValue::Array(items) = value.get_ref() else { break };
            let Some(next) = items.get(*index) else { break };
            value = next;
        }
        Some(value.span().start)
    }

    fn in_json(&self, text: &str) -> Option<usize> {
        let table: BTreeMap<String, &RawValue> = serde_json::from_str(text).ok()?;
        let mut value = *table.get(self.key)?;
        for index in &self.indices {
            let Ok(items) = serde_json::from_str::<Vec<&RawValue>>(value.get()) else { break };
            let Some(next) = items.get(*index) else { break };
            value = next;
        }
        // The value is a part of the text.
        Some(value.get().as_ptr() as usize - text.as_ptr() as usize)
    }
}
