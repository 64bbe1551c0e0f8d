//! Lines of JSON in canonical order.

use super::{Manifest, RESULTS, StoreError, TIMINGS, each_line};
use crate::file::Output;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

#[derive(Deserialize)]
struct Key<'a> {
    #[serde(borrow)]
    law: Cow<'a, str>,
    index: usize,
}

/// The records and the times of a campaign, from all directories `from`, in canonical order in the directory `to`.
pub(super) fn write(from: &[&Path], manifest: &Manifest, to: &Path) -> Result<(), StoreError> {
    let place = manifest.places();
    for name in [RESULTS, TIMINGS] {
        let mut lines = BTreeMap::<(usize, usize), Vec<u8>>::new();
        for directory in from {
            each_line(&directory.join(name), |text| {
                let Key { law, index } = serde_json::from_slice(text).map_err(|error| error.to_string())?;
                let before = lines.insert((place(&law, index)?, index), text.to_vec());
                // The last time of a case that was checked again counts.
                if before.is_some() && name == RESULTS {
                    return Err(format!("case {index} of {law} for the second time"));
                }
                Ok(())
            })?;
        }
        let output = to.join(name);
        let mut writer = Output::create(&output).map_err(StoreError::io(&output))?;
        for line in lines.values() {
            writer.write_all(line).and_then(|()| writer.write_all(b"\n")).map_err(StoreError::io(&output))?;
        }
        writer.commit().map_err(StoreError::io(&output))?;
    }
    Ok(())
}
