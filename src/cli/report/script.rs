//! What the page can do with a script: filter and order the laws. Without one it reads as it is.

use maud::{Markup, html};
use sha2::{Digest, Sha256};

/// The script.
pub const TEXT: &str = include_str!("script.js");

/// What a browser may load: nothing but the style of the page, and this script if the page has it.
pub fn policy(script: bool) -> String {
    if !script {
        return "default-src 'none'; style-src 'unsafe-inline'".into();
    }
    format!("default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{}'", base64(&Sha256::digest(TEXT)))
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let bits = (0..3).fold(0u32, |bits, k| bits << 8 | u32::from(chunk.get(k).copied().unwrap_or(0)));
        for k in 0..4 {
            let digit = char::from(DIGITS[(bits >> (18 - 6 * k)) as usize & 63]);
            text.push(if k <= chunk.len() { digit } else { '=' });
        }
    }
    text
}

/// Where to type and choose; hidden until the script shows it.
pub fn tools(orders: &[(&str, &str)], laws: usize) -> Markup {
    html! {
        form #tools hidden {
            label { "Filter " input #filter type="search" autocomplete="off" placeholder="words of a law" aria-controls="verdicts"; }
            label {
                "Order by "
                select #order aria-controls="verdicts" {
                    @for (key, name) in orders { option value=(key) { (name) } }
                }
            }
            output #shown for="filter" aria-live="polite" { (laws) " of " (laws) }
        }
    }
}
