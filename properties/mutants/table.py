#!/usr/bin/env python3
"""The table of a sample and its figures.

    table.py COPY SAMPLE.jsonl RESULTS EQUIVALENT.json [AGAIN] > mutants.jsonl     the figures go to the standard error

RESULTS is what run.py wrote with the laws and tests as they were, AGAIN what it wrote for the mutants that those missed
with the tests written against them. A row of the table: draw (the place in the random order), mutant (as cargo-mutants
prints it, with file and line), outcome, killer. Outcomes: caught, timeout (it hangs: counted as caught), equivalent (with
"why": no input tells it from the original, or only in the last digits), missed, undecided (nothing that was run fails, but not
every test target of COPY was run on it; "unmet" names those that were not), unviable (does not compile, or stands in a
constant: redrawn). "new" marks what a test of AGAIN caught, after a miss or undecided.

The first figure, of RESULTS, is an estimate for all mutants of these modules, with its interval. The second is not: the
tests added are aimed at this sample. Python's standard library only.
"""

import json
import re
import sys
from math import sqrt
from pathlib import Path


def wilson(k, n, z=1.959963984540054):
    """The 95 % interval of Wilson (1927) for k of n."""
    p = k / n
    middle, half = p + z * z / (2 * n), z * sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return (middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n)


def read(path):
    return [json.loads(line) for line in Path(path).read_text().splitlines()]


def fates(path, targets):
    """number -> (outcome, killer, targets that were not run)."""
    fate, passed = {}, {}
    for row in read(path):
        if row["outcome"] != "passed":
            fate[row["number"]] = (row["outcome"], killer(row), [])
        else:
            passed.setdefault(row["number"], set()).add(row["program"])
    for number, programs in passed.items():
        unmet = sorted(targets - programs)
        fate.setdefault(number, ("undecided" if unmet else "missed", None, unmet))
    return fate


def killer(row):
    if "cases" in row["program"]:
        name = row["killer"].split(" case ")[0].split(":")[0]
        return "law " + name if re.fullmatch("[a-z]+(-[a-z]+)+", name) else "laws: a panic outside the check"
    return row["program"] + (" " + row["killer"] if row["killer"] else "")


def main():
    copy, sample_path, results, reasons, *again = map(Path, sys.argv[1:])
    targets = set(re.findall(r'\[\[test\]\]\nname = "(\w+)"', (copy / "Cargo.toml").read_text()))
    sample, before = read(sample_path), fates(results, targets)
    equivalent = json.loads(reasons.read_text())
    after = fates(again[0], set()) if again else {}
    rows = []
    for drawn in sample:
        row = {"draw": drawn["draw"], "mutant": drawn["name"]}
        if drawn["unviable"] is not None:
            row |= {"outcome": "unviable", "why": drawn["unviable"].split("\n")[0]}
        else:
            outcome, by, unmet = before.get(drawn["number"], ("undecided", None, sorted(targets)))
            row |= {"outcome": outcome}
            if by:
                row["killer"] = by
            unseen = outcome in ("missed", "undecided")
            if unseen and drawn["name"] in equivalent:
                row |= {"outcome": "equivalent", "why": equivalent[drawn["name"]]}
            elif unseen:
                again, test, _ = after.get(drawn["number"], ("missed", None, []))
                if again != "missed":
                    row |= {"outcome": again, "killer": test, "new": True}
                if unmet:
                    row |= {"unmet": unmet}
        rows.append(row)
        print(json.dumps(row, ensure_ascii=False))
    viable = [row for row in rows if row["outcome"] != "unviable"]
    told = [row for row in viable if row["outcome"] != "equivalent"]
    caught = [row for row in told if row["outcome"] in ("caught", "timeout")]
    undecided = sum("unmet" in row for row in told)
    old = [row for row in caught if "new" not in row]
    laws = [row for row in old if row.get("killer", "").startswith("law")]

    def figure(what, k, n, open):
        low, high = wilson(k, n)
        least = "at least " if open else ""
        print(f"{what}: {least}{k} of {n}, {100 * k / n:.1f} % (Wilson 95 %: {100 * low:.1f} to {100 * high:.1f})", file=sys.stderr)

    print(f"{len(rows)} drawn, {len(viable)} viable, {len(viable) - len(told)} equivalent, {undecided} did not meet every "
          "target as it was", file=sys.stderr)
    figure("caught before any test was added, of all viable", len(old), len(viable), undecided)
    figure("caught before any test was added, of the not equivalent", len(old), len(told), undecided)
    print(f"of these {len(laws)} by a law, {sum(row['outcome'] == 'timeout' for row in old)} by the time limit", file=sys.stderr)
    figure("caught now, of the not equivalent", len(caught), len(told), any(row["outcome"] == "undecided" for row in told))


if __name__ == "__main__":
    main()
