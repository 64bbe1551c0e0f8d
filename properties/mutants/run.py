#!/usr/bin/env python3
"""Runs the laws and the tests on each mutant of a sample, in the tree that schemata.py wrote.

    run.py baseline COPY BASELINE.json                       every program without a mutant: must pass; its time
    run.py mutants  COPY BASELINE.json SAMPLE.jsonl RESULTS  every viable mutant; RESULTS is appended to, and a mutant
                                                             that has a row is not run again

A mutant goes through the programs in this order until one fails: the test target of its own module where that comes
first by FIRST, the laws (driver.rs, one case of each law; the first to be broken is the killer), the test target
of its module, those of NEAR, then the laws on more cases and the other test targets from quick to slow. A program that
takes more than LIMIT times the processor time that it takes without a mutant is stopped: the mutant hangs, which counts as
caught ("timeout"), as cargo-mutants counts it.

The programs are compiled by the caller, with the target directory and profile that the environment sets:
    cargo build --example mutant; cargo test --no-run --tests
Python's standard library only.
"""

import argparse
import json
import os
import re
import resource
import signal
import subprocess
import threading
from pathlib import Path

SEED, FEW, MANY = "1", "1", "8"
LIMIT, LEAST, WALL = 8, 10.0, 1800.0
MEMORY = 6 << 30
OWN = {"newton.rs": "integrators"}
# Their own tests are quick, and the laws hardly see them.
FIRST = {"scalar", "algebra", "tableau", "group"}
# The targets that use a module most, where its own does not see the mutant.
NEAR = {
    "scalar": ["tableau", "retraction"],
    "tableau": ["order", "system", "integrators"],
    "group": ["retraction"],
    "retraction": ["continuous", "integrators"],
    "mechanics": ["integrators", "continuous"],
    "discrete": ["continuous", "integrators"],
    "groupoid": ["mechanics"],
    "newton.rs": ["discrete"],
}


def programs(copy, targets):
    """Name -> command, of the driver and the test targets that are compiled."""
    names = targets or sorted(re.findall(r'\[\[test\]\]\nname = "(\w+)"', (copy / "Cargo.toml").read_text()))
    words = [word for name in names for word in ("--test", name)]
    command = ["cargo", "test", "--no-run", "--message-format=json", "--quiet", "--example", "mutant", *words]
    out = subprocess.run(command, cwd=copy, check=True, capture_output=True, text=True).stdout
    found = {}
    for line in out.splitlines():
        message = json.loads(line)
        if message.get("executable") and message["target"]["kind"] == ["test"]:
            found[message["target"]["name"]] = [message["executable"], "--test-threads=1"]
    target = Path(os.environ.get("CARGO_TARGET_DIR", copy / "target"))
    driver = [str(target / "debug/examples/mutant"), SEED]
    return {"few cases": [*driver, FEW], **found, "many cases": [*driver, MANY]}


def run(command, copy, mutant, limit):
    """(outcome, killer): outcome is "passed", "caught" or "timeout". Stopped at the first test that fails."""
    # A failure that proptest keeps in the tree would be found again by the next mutant; the same cases for all.
    environment = {**os.environ, "RAYON_NUM_THREADS": "1", "INSTA_UPDATE": "no", "RUST_BACKTRACE": "0",
                   "PROPTEST_DISABLE_FAILURE_PERSISTENCE": "1", "PROPTEST_RNG_SEED": SEED}
    environment.pop("MUTANT", None)
    if mutant is not None:
        environment["MUTANT"] = str(mutant)

    def bounded():
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit + 1), int(limit + 2)))

    process = subprocess.Popen(command, cwd=copy, env=environment, text=True, errors="replace", process_group=0,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, preexec_fn=bounded)
    late = threading.Event()

    def stop():
        late.set()
        os.killpg(process.pid, signal.SIGKILL)

    timer = threading.Timer(WALL, stop)
    timer.start()
    last, failed, running = "", None, ""
    for line in process.stdout:
        last = line.strip() or last
        started = re.match(r"test (\S+)", line)
        running = started[1] if started else running
        # What a test prints comes between its name and its verdict, or is captured.
        if re.match(r"(test \S+ \.\.\. )?FAILED", line) and running:
            failed = running
            os.killpg(process.pid, signal.SIGKILL)
            break
    process.stdout.close()
    code = process.wait()
    timer.cancel()
    if failed:
        return "caught", failed
    if late.is_set() or code in (-signal.SIGXCPU, -signal.SIGKILL):
        return "timeout", running
    return ("passed", "") if code == 0 else ("caught", running or last[:300] or f"exit {code}")


def tidy(copy, kept):
    """Removes the failing cases that a test has saved in the tree: they are replayed by the tests of the next mutant."""
    for path in saved(copy) - kept:
        path.unlink()


def saved(copy):
    return set((copy / "snapshots/regressions").glob("*"))


def processor():
    """The processor time of the programs that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def baseline(copy, path, targets, words):
    times = json.loads(path.read_text()) if path.exists() else {}
    for name, command in programs(copy, [name for name in targets if "cases" not in name]).items():
        if targets and name not in targets:
            continue
        start = processor()
        outcome, killer = run(command + (words if "cases" not in name else []), copy, None, 3600)
        seconds = processor() - start
        print(f"{name}: {outcome} {killer} {seconds:.1f} s", flush=True)
        if outcome == "passed":
            times[name] = {"command": command, "seconds": seconds}
        path.write_text(json.dumps(times, indent=1))


def order(mutant, times, stages):
    module = re.match(r"src/([\w.]+)", mutant["name"])[1]
    own = OWN.get(module, module)
    near = [own, *NEAR.get(module, [])]
    rest = sorted((name for name in times if name not in near and name != "few cases"), key=lambda name: times[name]["seconds"])
    split = 1 if own in FIRST else 0
    whole = [*near[:split], "few cases", *near[split:], *rest]
    return [name for name in whole if name in times and (not stages or name in stages)]


def mutants(copy, times, sample, results, stages, part, words):
    rows = [json.loads(line) for line in sample.read_text().splitlines()]
    rows = [row for row in rows if row["unviable"] is None]
    done = {}
    if results.exists():
        for line in results.read_text().splitlines():
            row = json.loads(line)
            done.setdefault(row["number"], {})[row["program"]] = row["outcome"]
    kept = saved(copy)
    for k, row in enumerate(rows):
        if k % part[1] != part[0]:
            continue
        seen = done.get(row["number"], {})
        if any(outcome != "passed" for outcome in seen.values()):
            continue
        for name in order(row, times, stages):
            if name in seen:
                continue
            start = processor()
            limit = max(LEAST, LIMIT * times[name]["seconds"])
            command = times[name]["command"] + (words if "cases" not in name else [])
            outcome, killer = run(command, copy, row["number"], limit)
            tidy(copy, kept)
            answer = {"number": row["number"], "name": row["name"], "program": name, "outcome": outcome,
                      "killer": killer, "seconds": round(processor() - start, 1)}
            with results.open("a") as out:
                out.write(json.dumps(answer, ensure_ascii=False) + "\n")
            if outcome != "passed":
                break


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["baseline", "mutants"])
    parser.add_argument("copy", type=Path)
    parser.add_argument("baseline", type=Path)
    parser.add_argument("sample", type=Path, nargs="?")
    parser.add_argument("results", type=Path, nargs="?")
    parser.add_argument("--programs", nargs="*", default=[], help="these only")
    parser.add_argument("--part", default="0/1", help="i/n: every n-th mutant, from the i-th")
    parser.add_argument("--without", nargs="*", default=[], help="tests to leave out")
    parser.add_argument("--only", nargs="*", default=[], help="the tests to run")
    given = parser.parse_args()
    words = [word for name in given.without for word in ("--skip", name)] + ["--exact"] * bool(given.only) + given.only
    if given.what == "baseline":
        baseline(given.copy, given.baseline, given.programs, words)
    else:
        part = [int(word) for word in given.part.split("/")]
        times = json.loads(given.baseline.read_text())
        mutants(given.copy, times, given.sample, given.results, set(given.programs), part, words)


if __name__ == "__main__":
    main()
