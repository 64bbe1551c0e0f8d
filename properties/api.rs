//! The public surface, read from the sources: every public type stands in an example of the documentation, by name.
//!
//! The sources are formatted, so that lines tell enough: an item begins in the first column, and its attributes stand above it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A path of modules, from the root of the crate.
type Module = Vec<String>;

/// The types of the crate, and what leads to them.
#[derive(Default)]
struct Sources {
    /// Modules that a user can name.
    public: BTreeSet<Module>,
    /// Types by the module that defines them, without hidden ones.
    types: BTreeSet<(Module, String)>,
    /// `pub use` of a type: from which module, which item of which module.
    exports: Vec<(Module, Module, String)>,
}

/// The lines of a file as items: each with the attributes above it, and put together where it goes over several lines.
fn items(text: &str) -> Vec<(String, String)> {
    let (mut items, mut attributes) = (Vec::new(), String::new());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.starts_with("#[") {
            attributes += line;
        } else if line.starts_with("pub ") || line.starts_with("mod ") {
            let mut item = line.to_owned();
            while item.starts_with("pub use ") && !item.ends_with(';') {
                item += lines.next().expect("the end of a `use`").trim();
            }
            items.push((std::mem::take(&mut attributes), item));
        } else if !line.is_empty() && !line.starts_with([' ', '/']) {
            attributes.clear();
        }
    }
    items
}

/// The paths that a `use` names: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn paths(prefix: &str, tree: &str, out: &mut Vec<String>) {
    let Some((start, rest)) = tree.split_once('{') else {
        out.push(format!("{prefix}{}", tree.trim()));
        return;
    };
    let (prefix, inner) = (format!("{prefix}{}", start.trim()), rest.strip_suffix('}').expect("a closed brace"));
    let (mut depth, mut begin) = (0, 0);
    for (k, sign) in inner.char_indices().chain([(inner.len(), ',')]) {
        match sign {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !inner[begin..k].trim().is_empty() {
                    paths(&prefix, &inner[begin..k], out);
                }
                begin = k + 1;
            }
            _ => {}
        }
    }
}

/// What a line declares: `pub struct Name…` with one of these keywords.
fn declared<'a>(item: &'a str, keywords: &[&str]) -> Option<&'a str> {
    let rest = keywords.iter().find_map(|word| item.strip_prefix(word))?;
    rest.split(|sign: char| !(sign.is_alphanumeric() || sign == '_')).next()
}

impl Sources {
    fn read(&mut self, module: &Module, file: &Path, public: bool) {
        if public {
            self.public.insert(module.clone());
        }
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let stem = file.file_stem().and_then(|stem| stem.to_str()).expect("a name");
        let folder = if ["lib", "mod"].contains(&stem) { file.with_file_name("") } else { file.with_extension("") };
        for (attributes, item) in items(&text) {
            let hidden = attributes.contains("doc(hidden)");
            if let Some(name) = declared(&item, &["pub mod ", "mod "]).filter(|_| item.ends_with(';')) {
                let paths = [folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs")];
                let inner = module.iter().cloned().chain([name.to_owned()]).collect();
                let file = paths.iter().find(|path| path.exists()).unwrap_or_else(|| panic!("no file of {inner:?}"));
                self.read(&inner, file, public && item.starts_with("pub ") && !hidden);
            } else if let Some(tree) = item.strip_prefix("pub use ").filter(|_| public && !hidden) {
                let mut named = Vec::new();
                paths("", tree.trim_end_matches(';'), &mut named);
                for path in named {
                    let mut path: Module = path.split("::").map(str::to_owned).collect();
                    let name = path.pop().expect("a path");
                    let from = match path.first().map(String::as_str) {
                        Some("crate") => path.split_off(1),
                        Some("super") => [&module[..module.len() - 1], &path[1..]].concat(),
                        _ => [module.as_slice(), &path].concat(),
                    };
                    self.exports.push((module.clone(), from, name));
                }
            } else if let Some(name) =
                declared(&item, &["pub struct ", "pub enum ", "pub trait ", "pub type ", "pub union "])
                && !hidden
            {
                self.types.insert((module.clone(), name.to_owned()));
            }
        }
    }

    /// The types that a user can name, with the modules that have them.
    fn reachable(&self) -> BTreeMap<&(Module, String), Vec<&Module>> {
        let mut reachable: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for item in self.types.iter().filter(|(module, _)| self.public.contains(module)) {
            reachable.entry(item).or_default().push(&item.0);
        }
        for (by, from, name) in &self.exports {
            // Of a module that exports it in turn, perhaps.
            if let Some(item) = self.types.iter().find(|item| item.1 == *name && item.0.starts_with(from)) {
                reachable.entry(item).or_default().push(by);
            }
        }
        reachable
    }
}

/// The files under a folder.
fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() { files(&path, out) } else { out.push(path) }
    }
}

/// The Rust examples of a text: in doc comments, or of a page.
fn examples(text: &str, page: bool, out: &mut Vec<String>) {
    let mut example: Option<(bool, String)> = None;
    for line in text.lines() {
        let line = line.trim();
        let Some(line) =
            (if page { Some(line) } else { ["///", "//!"].iter().find_map(|sign| line.strip_prefix(sign)) })
        else {
            continue;
        };
        match (line.trim().strip_prefix("```"), &mut example) {
            (Some(tags), None) => {
                let rust = tags.split(',').all(|tag| ["", "rust", "no_run", "should_panic"].contains(&tag.trim()));
                example = Some((rust, String::new()));
            }
            (Some(_), Some(_)) => out.extend(example.take().filter(|(rust, _)| *rust).map(|(_, text)| text)),
            (None, Some((_, text))) => *text += &format!("{line}\n"),
            (None, None) => {}
        }
    }
}

fn names(word: &str, example: &str) -> bool {
    example.split(|sign: char| !(sign.is_alphanumeric() || sign == '_')).any(|other| other == word)
}

#[test]
fn every_public_type_stands_in_an_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut sources = Sources::default();
    sources.read(&Vec::new(), &root.join("src/lib.rs"), true);
    let reachable = sources.reachable();
    assert!(reachable.len() > 250, "only {} types were found", reachable.len());

    let (mut paths, mut found) = (vec![root.join("README.md")], Vec::new());
    files(&root.join("src"), &mut paths);
    for path in paths {
        let page = path.extension().is_some_and(|extension| extension == "md");
        if page || path.extension().is_some_and(|extension| extension == "rs") {
            examples(&fs::read_to_string(&path).expect("a text"), page, &mut found);
        }
    }
    assert!(found.len() > 60, "only {} examples were found", found.len());

    // A name may be that of several types: the example has to name a module of this one as well.
    let shown = |name: &str, modules: &[&Module]| {
        found.iter().any(|example| {
            names(name, example) && modules.iter().any(|path| path.last().is_none_or(|module| names(module, example)))
        })
    };
    let without: Vec<String> = reachable
        .into_iter()
        .filter(|((_, name), modules)| !shown(name, modules))
        .map(|((_, name), modules)| [modules[0].join("::"), name.clone()].join("::"))
        .collect();
    assert!(without.is_empty(), "public types without an example:\n{}", without.join("\n"));
}
