//! Parameters instead of numbers: `"ixx"`, `"0.01*spin"`.
//!
//! A file may name what its `[parameters]` declare wherever a number stands. Each name is replaced by its value when the file is read, so
//! that a [`Case`](super::Case) holds numbers alone.

use super::case::Parameter;
use crate::expression::like;
use crate::scalar::Number;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What has a name.
pub(crate) type Named = BTreeMap<String, Parameter>;

/// The words of a number that are no parameters.
const WORDS: [&str; 3] = ["deg", "pi", "sqrt"];

/// The tables that hold numbers, each with the keys whose values are texts.
const TABLES: [(&str, &[&str]); 9] = [
    ("parameters", &[]),
    ("algebra", &["name", "family", "given"]),
    ("lagrangian", &["formula"]),
    ("force", &["kind", "components"]),
    ("potential", &["kind", "value"]),
    ("method", &["tableau", "tableau-file", "retraction"]),
    ("state", &["axes"]),
    ("run", &["scalar"]),
    ("output", &["csv", "svg", "events"]),
];

/// The longest chain of parameters of which each names the next.
const LONGEST_CHAIN: usize = 50;

/// Why a text is no number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refused {
    /// The byte of the text, if it is one name that is wrong.
    pub at: Option<usize>,
    /// What is wrong.
    pub message: String,
}

/// A text of a file that is no number, where numbers may stand.
pub(super) struct Unread {
    /// Where the text is in the file.
    pub span: Range<usize>,
    /// The text.
    pub text: String,
    /// Why.
    pub refused: Refused,
}

/// The names in a text, with the bytes at which they start.
fn names(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let inside = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
    let mut at = 0;
    std::iter::from_fn(move || {
        loop {
            at += text[at..].find(inside)?;
            let rest = &text[at..];
            let word = &rest[..rest.find(|c: char| !inside(c)).unwrap_or(rest.len())];
            let start = at;
            at += word.len();
            // What starts with a digit is a decimal: `1e5`.
            if word.starts_with(char::is_alphabetic) && !WORDS.contains(&word) {
                return Some((start, word));
            }
        }
    })
}

/// An entry of a list by its index, from 1.
fn entry(list: &[Number], index: &str) -> Option<Number> {
    list.get(index.trim().parse::<usize>().ok()?.checked_sub(1)?).cloned()
}

/// The value of a name at the start of a text, and how long the name is, with its index: `k`, `B_1` or `B[1]`.
fn value(text: &str, name: &str, named: &Named) -> Result<(Number, usize), String> {
    match named.get(name) {
        Some(Parameter::Number(value)) => return Ok((value.clone(), name.len())),
        Some(Parameter::Vector(list)) => {
            let index = text[name.len()..].strip_prefix('[').and_then(|rest| Some(rest.split_once(']')?.0));
            let found = index.and_then(|index| Some((entry(list, index)?, name.len() + index.len() + 2)));
            let several = || format!("`{name}` is a list; its numbers are `{name}_1` to `{name}_{}`", list.len());
            return found.ok_or_else(several);
        }
        None => {}
    }
    if let Some((stem, index)) = name.rsplit_once('_')
        && let Some(Parameter::Vector(list)) = named.get(stem)
        && let Some(value) = entry(list, index)
    {
        return Ok((value, name.len()));
    }
    let hint = match like(name, named.keys().map(String::as_str)) {
        Some(known) => format!("did you mean `{known}`?"),
        None => "a number has `+ - * /`, `sqrt`, `pi`, `deg` and the names of [parameters]".into(),
    };
    Err(format!("unknown name `{name}`; {hint}"))
}

/// The number of a text that may name parameters.
pub(crate) fn number(text: &str, named: &Named) -> Result<Number, Refused> {
    let (mut whole, mut copied) = (String::new(), 0);
    for (at, name) in names(text) {
        let (value, length) = value(&text[at..], name, named).map_err(|message| Refused { at: Some(at), message })?;
        whole += &format!("{}({value})", &text[copied..at]);
        copied = at + length;
    }
    whole += &text[copied..];
    Number::parse(&whole).map_err(|error| Refused { at: None, message: error.to_string() })
}

/// The texts in a value, with where they are.
fn texts<'a, 'i>(value: &'a mut Spanned<DeValue<'i>>, without: &[&str], found: &mut Vec<Text<'a, 'i>>) {
    let span = value.span();
    match value.get_mut() {
        DeValue::String(text) => found.push((span, text)),
        DeValue::Array(items) => items.iter_mut().for_each(|item| texts(item, without, found)),
        DeValue::Table(table) => {
            let inside = table.iter_mut().filter(|(key, _)| !without.contains(&key.get_ref().as_ref()));
            inside.for_each(|(_, item)| texts(item, without, found));
        }
        _ => {}
    }
}

type Text<'a, 'i> = (Range<usize>, &'a mut Cow<'i, str>);

/// The value of a parameter, if it can be read.
fn parameter(value: &DeValue<'_>, named: &Named) -> Option<Parameter> {
    let one = |value: &DeValue<'_>| match value {
        DeValue::String(text) => number(text, named).ok(),
        DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix()).ok().map(Number::from),
        DeValue::Float(digits) => Number::parse(digits.as_str().trim_start_matches('+')).ok(),
        _ => None,
    };
    match value {
        DeValue::Array(items) => {
            items.iter().map(|item| one(item.get_ref())).collect::<Option<_>>().map(Parameter::Vector)
        }
        value => one(value).map(Parameter::Number),
    }
}

/// The parameters of a file that can be read; each may name others.
fn parameters(table: &DeTable<'_>) -> Named {
    let mut named = Named::new();
    for _ in 0..LONGEST_CHAIN {
        let before = named.len();
        for (name, value) in table {
            if !named.contains_key(name.get_ref().as_ref())
                && let Some(value) = parameter(value.get_ref(), &named)
            {
                named.insert(name.get_ref().to_string(), value);
            }
        }
        if named.len() == before {
            break;
        }
    }
    named
}

/// Replaces texts that name parameters of the file by numbers. What is no number stays, and is returned, parameters first: of
/// a key that is none the reader of the whole file says so.
pub(super) fn put(table: &mut DeTable<'_>) -> Vec<Unread> {
    let (mut named, mut declared) = (Named::new(), BTreeSet::new());
    if let Some(DeValue::Table(table)) = table.get("parameters").map(Spanned::get_ref) {
        named = parameters(table);
        declared = table.keys().map(|key| key.get_ref().to_string()).collect();
    }
    let mut unread = Vec::new();
    for (section, without) in TABLES {
        let Some(value) = table.get_mut(section) else { continue };
        let mut found = Vec::new();
        texts(value, without, &mut found);
        for (span, text) in found {
            match number(text, &named) {
                Ok(number) if names(text).next().is_some() => *text = Cow::Owned(number.to_string()),
                Ok(_) => {}
                Err(mut refused) => {
                    let name = refused.at.and_then(|at| names(&text[at..]).next());
                    if let Some((_, name)) =
                        name.filter(|(_, name)| declared.contains(*name) && !named.contains_key(*name))
                    {
                        refused.message = format!(
                            "the parameter `{name}` has no value: it is no number, or names itself through others"
                        );
                    }
                    unread.push(Unread { span, text: text.to_string(), refused });
                }
            }
        }
    }
    unread
}
