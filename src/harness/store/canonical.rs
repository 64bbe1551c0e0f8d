//! Lines of JSON in canonical order.

use super::{Positions, StoreError, each_line, position};
use crate::file::Output;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
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

/// The lines of all `inputs` in canonical order, in place of `output`.
pub(super) fn write(
    inputs: &[PathBuf],
    positions: &Positions,
    repeats: Repeats,
    output: &Path,
) -> Result<(), StoreError> {
    let mut lines = BTreeMap::<(usize, usize), Vec<u8>>::new();
    for path in inputs {
        each_line(path, |text| {
            let Key { law, index } = serde_json::from_slice(text).map_err(|error| error.to_string())?;
            let position = position(positions, &law)?;
            let before = lines.insert((position, index), text.to_vec());
            if before.is_some() && repeats == Repeats::Refused {
                return Err(format!("holds case {index} of law number {} twice", position + 1));
            }
            Ok(())
        })?;
    }
    let mut writer = Output::create(output).map_err(StoreError::io(output))?;
    for line in lines.values() {
        writer.write_all(line).and_then(|()| writer.write_all(b"\n")).map_err(StoreError::io(output))?;
    }
    writer.commit().map_err(StoreError::io(output))
}
