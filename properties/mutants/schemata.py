#!/usr/bin/env python3
"""A random sample of cargo-mutants' mutants, all of them in one source tree, switched at run time.

One build per mutant is out of reach for code that is compiled for each dimension and scalar. So the sampled mutants are
written into one copy of the tree ("mutant schemata", Untch, Offutt and Harrold 1993): a function with sampled mutants
becomes

    if crate::mutant::is(7) { BODY OF MUTANT 7 } else if crate::mutant::is(12) { … } else { ORIGINAL BODY }

with the bodies exactly as cargo-mutants would write them, and MUTANT=7 in the environment of a test chooses one. What
cargo-mutants calls unviable (the mutant does not compile) is found with `cargo check` and replaced by the next of the
draw.

    schemata.py list    TREE LIST.json                    what `cargo mutants --list --json` prints for the mathematics
    schemata.py sample  TREE LIST.json SAMPLE.jsonl       draw, write the copy, check, drop what does not compile
    schemata.py write   TREE LIST.json SAMPLE.jsonl COPY  write the copy of a finished sample again

TREE is a clean checkout. Python's standard library only.
"""

import argparse
import json
import random
import re
import shutil
import subprocess
import sys
from pathlib import Path

MODULES = ["scalar", "algebra", "group", "retraction", "tableau", "mechanics", "groupoid", "discrete", "integrators"]
FILES = [f"src/{module}/**" for module in MODULES] + ["src/newton.rs"]

SWITCH = """//! Which mutant is active: the number in the environment variable MUTANT, none without it.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

static ACTIVE: AtomicU32 = AtomicU32::new(u32::MAX);

extern "C" fn read() {
    if let Some(number) = std::env::var("MUTANT").ok().and_then(|text| text.parse().ok()) {
        ACTIVE.store(number, Relaxed);
    }
}

// Before main, so that `is` is one load and one comparison.
#[used]
#[unsafe(link_section = ".init_array")]
static READ: extern "C" fn() = read;

/// Whether mutant `number` is active.
#[inline(always)]
pub fn is(number: u32) -> bool {
    ACTIVE.load(Relaxed) == number
}
"""


def mutants_of(tree):
    """What cargo-mutants finds in the mathematics modules, in its order."""
    files = [word for pattern in FILES for word in ("-f", pattern)]
    command = ["cargo", "mutants", "--no-config", "--list", "--json", *files]
    return json.loads(subprocess.run(command, cwd=tree, check=True, capture_output=True, text=True).stdout)


# Rust text, as far as it takes to find the braces of a function.
TOKEN = re.compile(
    r"""//[^\n]*
      | /\*.*?\*/
      | (?:b|c)?"(?:\\.|[^"\\])*"
      | (?:b|c)?r(?P<hashes>\#*)".*?"(?P=hashes)
      | b?'(?:\\(?:x..|u\{[^}]*\}|.)|[^'\\])'
      | '[A-Za-z_]\w*
      | [A-Za-z_]\w*
      | .""",
    re.VERBOSE | re.DOTALL,
)


def body_of(text, start, end):
    """The offsets of the braces of the function at text[start:end]."""
    depth, opened = 0, None
    for match in TOKEN.finditer(text, start, end):
        token = match.group()
        if token in ("(", "[", "{"):
            if depth == 0 and token == "{":
                opened = match.start()
            depth += 1
        elif token in (")", "]", "}"):
            depth -= 1
    if opened is None or text[end - 1] != "}":
        raise ValueError(f"no body: {text[start:end][:60]}")
    return opened, end - 1


def offsets(text):
    """Of (line, column), both from 1, columns in characters."""
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    return lambda place: starts[place["line"] - 1] + place["column"] - 1


def span(at, span):
    return at(span["start"]), at(span["end"])


def boxed(head):
    """The branches of an `impl Trait` are of different types: the head with a boxed type, and what boxes a branch."""
    strategy = re.search(r"-> impl Strategy<Value = (\w+)>", head)
    if strategy:
        box = f"-> ::proptest::strategy::BoxedStrategy<{strategy[1]}>"
        return head.replace(strategy[0], box), "::proptest::strategy::Strategy::boxed"
    some = re.search(r"-> impl (.*[^\s])", head)
    if some:
        lives = "" if "'_" in some[1] or "&self" not in head else " + '_"
        return head.replace(some[0], f"-> Box<dyn {some[1]}{lives}>"), "Box::new"
    return head, ""


def rewrite(text, mutants):
    """One file with the schemata of `mutants` (number -> mutant): the new text, and for each new line its mutant."""
    at = offsets(text)
    functions = {}
    for number, mutant in sorted(mutants.items()):
        functions.setdefault(span(at, mutant["function"]["span"]), []).append((number, mutant))
    for (start, end), own in functions.items():
        for (other_start, other_end) in functions:
            if start < other_start and other_end < end:
                raise ValueError("a function in a function")
    pieces, done = [], 0
    for (start, end), own in sorted(functions.items()):
        opened, closed = body_of(text, start, end)
        # A const function cannot read the switch. Those that are needed at compile time `check` names.
        head, wrap = boxed(re.sub(r"\bconst fn\b", "fn", text[start:opened]))
        pieces.append((None, text[done:start] + head + "{\n"))
        for number, mutant in own:
            first, last = span(at, mutant["span"])
            mutated = text[opened + 1 : first] + mutant["replacement"] + text[last:closed]
            pieces.append((None, f"if crate::mutant::is({number}) {{ {wrap}({{"))
            pieces.append((number, mutated.strip("\n") + "\n"))
            pieces.append((None, "}) } else "))
        pieces.append((None, "{ " + wrap + "({" + text[opened + 1 : closed] + "}) } }"))
        done = end
    pieces.append((None, text[done:]))
    lines, new = {}, ""
    for number, piece in pieces:
        if number is not None:
            line = new.count("\n") + 1
            for k in range(piece.count("\n") + 1):
                lines.setdefault(line + k, number)
        new += piece
    return new, lines


def write(tree, copy, chosen):
    """A copy of the tree with the schemata of `chosen` (number -> mutant): file -> line -> number."""
    copy.mkdir(parents=True, exist_ok=True)
    for name in subprocess.run(["git", "ls-files"], cwd=tree, check=True, capture_output=True, text=True).stdout.split("\n"):
        if name and (tree / name).is_file():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            place(copy / name, (tree / name).read_bytes())
    place(copy / "src/mutant.rs", SWITCH.encode())
    library = (tree / "src/lib.rs").read_text()
    place(copy / "src/lib.rs", (library + "\n#[doc(hidden)]\npub mod mutant;\n").encode())
    lines = {}
    for file in sorted({mutant["file"] for mutant in chosen.values()}):
        own = {number: mutant for number, mutant in chosen.items() if mutant["file"] == file}
        text, lines[file] = rewrite((tree / file).read_text(), own)
        place(copy / file, text.encode())
    return lines


def place(path, data):
    """Writes a file only where it changes, so that cargo sees no change where there is none."""
    if not path.exists() or path.read_bytes() != data:
        path.write_bytes(data)


def constant(message, chosen):
    """The mutants of the function that rustc needs at compile time, where they have taken its `const`."""
    called = re.search(r"cannot call non-const function `(?:.*::)?(\w+)` in constants", message["message"])
    file = message["spans"][0]["file_name"]
    return {number for number, mutant in chosen.items()
            if called and mutant["file"] == file and mutant["function"]["function_name"].split("::")[-1] == called[1]}


def errors(copy, lines, chosen):
    """Numbers of the mutants that rustc refuses, with the codes of the errors; and the errors outside every mutant."""
    command = ["cargo", "check", "--lib", "--message-format=json", "--quiet"]
    out = subprocess.run(command, cwd=copy, capture_output=True, text=True)
    refused, strange = {}, []
    for line in out.stdout.splitlines():
        message = json.loads(line).get("message") if line.startswith("{") else None
        if not message or message.get("level") != "error" or not message["spans"]:
            continue
        code = (message.get("code") or {}).get("code") or message["message"]
        numbers = {lines.get(s["file_name"], {}).get(k) for s in message["spans"] for k in range(s["line_start"], s["line_end"] + 1)
                   if s["is_primary"]} - {None}
        numbers = numbers or constant(message, chosen)
        if not numbers:
            strange.append(message["rendered"])
        for number in numbers:
            refused.setdefault(number, f"{code}: {message['message']}")
    if out.returncode != 0 and not refused and not strange:
        strange.append(out.stderr)
    return refused, strange


def sample(tree, listed, path, copy, seed, size):
    order = list(range(len(listed)))
    random.Random(seed).shuffle(order)
    verdicts = {}  # number -> None, or why it is unviable
    drawn = 0
    while True:
        while sum(v is None for v in verdicts.values()) < size:
            number = order[drawn]
            drawn += 1
            verdicts[number] = None if listed[number]["function"] else "not in a function"
        viable = {number: listed[number] for number, why in verdicts.items() if why is None}
        refused, strange = errors(copy, write(tree, copy, viable), viable)
        print(f"{drawn} drawn, {len(viable)} viable so far, {len(refused)} refused now, {len(strange)} strange", file=sys.stderr, flush=True)
        for text in strange[:3]:
            print(text, file=sys.stderr)
        if not refused:
            if strange:
                sys.exit("errors outside the mutants")
            break
        verdicts.update(refused)
    with path.open("w") as out:
        for rank, number in enumerate(order[:drawn]):
            row = {"draw": rank, "number": number, "name": listed[number]["name"], "unviable": verdicts[number]}
            out.write(json.dumps(row, ensure_ascii=False) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["list", "sample", "write"])
    parser.add_argument("tree", type=Path)
    parser.add_argument("list", type=Path)
    parser.add_argument("sample", type=Path, nargs="?")
    parser.add_argument("copy", type=Path, nargs="?")
    parser.add_argument("--seed", type=int, default=20261122)
    parser.add_argument("--size", type=int, default=240)
    given = parser.parse_args()
    if given.what == "list":
        given.list.write_text(json.dumps(mutants_of(given.tree)))
        return
    listed = json.loads(given.list.read_text())
    if given.what == "sample":
        sample(given.tree, listed, given.sample, given.copy, given.seed, given.size)
    else:
        rows = [json.loads(line) for line in given.sample.read_text().splitlines()]
        write(given.tree, given.copy, {row["number"]: listed[row["number"]] for row in rows if row["unviable"] is None})


if __name__ == "__main__":
    main()
