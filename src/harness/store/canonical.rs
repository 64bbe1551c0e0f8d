//! Lines of JSON in canonical order, however large the files: the keys are in memory, the lines are copied as they are.

use super::{Positions, StoreError, each_line};
use crate::file::Output;
use serde::Deserialize;
use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// Two lines with one key.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Repeats {
    /// Are damage.
    Refused,
    /// Are a case that was checked again; the last one counts.
    LastCounts,
}

#[derive(Deserialize)]
struct Key<'a> {
    #[serde(borrow)]
    law: Cow<'a, str>,
    index: usize,
}

/// Where a line is. The order is the canonical one, then that of the files.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    law: usize,
    index: usize,
    file: usize,
    offset: u64,
    length: usize,
}

impl Place {
    fn key(&self) -> (usize, usize) {
        (self.law, self.index)
    }
}

/// The lines of all `inputs` in canonical order, in place of `output`.
pub(super) fn write(
    inputs: &[PathBuf],
    positions: &Positions,
    repeats: Repeats,
    output: &Path,
) -> Result<(), StoreError> {
    let mut places = Vec::new();
    for (file, path) in inputs.iter().enumerate() {
        add_places(path, file, positions, &mut places)?;
    }
    if inputs == [output] && places.is_sorted() && places.windows(2).all(|pair| pair[0].key() != pair[1].key()) {
        return Ok(());
    }
    places.sort_unstable();
    if repeats == Repeats::Refused
        && let Some(pair) = places.windows(2).find(|pair| pair[0].key() == pair[1].key())
    {
        let reason = format!("holds case {} of law number {} twice", pair[0].index, pair[0].law + 1);
        return Err(StoreError::Damaged { path: inputs[pair[1].file].clone(), line: 0, reason });
    }
    copy(inputs, &places, output)
}

fn add_places(path: &Path, file: usize, positions: &Positions, places: &mut Vec<Place>) -> Result<(), StoreError> {
    let mut offset = 0;
    each_line(path, |line, text| {
        let damaged = |reason: String| StoreError::Damaged { path: path.to_owned(), line, reason };
        let key: Key = serde_json::from_slice(text).map_err(|error| damaged(error.to_string()))?;
        let law =
            positions.get(&*key.law).ok_or_else(|| damaged(format!("the campaign has no law \"{}\"", key.law)))?;
        let length = text.len() + 1;
        places.push(Place { law: *law, index: key.index, file, offset, length });
        offset += length as u64;
        Ok(())
    })
}

/// The last line of each key.
fn copy(inputs: &[PathBuf], places: &[Place], output: &Path) -> Result<(), StoreError> {
    let mut readers = Vec::new();
    for path in inputs {
        // An input may be missing: it has no places.
        readers.push(File::open(path).ok().map(|file| (BufReader::with_capacity(1 << 16, file), 0_u64)));
    }
    let mut writer = Output::create(output).map_err(StoreError::io(output))?;
    let mut line = Vec::new();
    for (at, place) in places.iter().enumerate() {
        if places.get(at + 1).is_some_and(|next| next.key() == place.key()) {
            continue;
        }
        let Some((reader, position)) = &mut readers[place.file] else { continue };
        line.resize(place.length, 0);
        // Mostly the next one: what the buffer holds already is not read again.
        let seek = reader.seek_relative(place.offset as i64 - *position as i64);
        let read = seek.and_then(|()| reader.read_exact(&mut line));
        read.map_err(StoreError::io(&inputs[place.file]))?;
        *position = place.offset + place.length as u64;
        writer.write_all(&line).map_err(StoreError::io(output))?;
    }
    writer.commit().map_err(StoreError::io(output))
}
