#!/usr/bin/env python3
"""The table of a sample and its figures.

    table.py SAMPLE.jsonl RESULTS EQUIVALENT.json [AGAIN] > mutants.jsonl     the figures go to the standard error

RESULTS is what run.py wrote with the laws and tests as they were, AGAIN what it wrote for the mutants that those missed
with the tests written against them. A row of the table: draw (the place in the random order), mutant (as cargo-mutants
prints it, with file and line), outcome, killer. Outcomes: caught, timeout (it hangs: counted as caught), equivalent (with
"why": no input tells it from the original), missed, unviable (does not compile, or stands in a constant: redrawn).

The first figure, of RESULTS, is an estimate for all mutants of these modules, with its interval. The second is not: the
tests added are aimed at this sample. Python's standard library only.
"""

import json
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


def fates(path):
    """number -> (outcome, killer) of the programs run."""
    fate = {}
    for row in read(path):
        if row["outcome"] != "passed":
            fate[row["number"]] = (row["outcome"], killer(row))
        else:
            fate.setdefault(row["number"], ("missed", None))
    return fate


def killer(row):
    if "cases" in row["program"]:
        return "law " + row["killer"].split(":")[0].split(" case ")[0] if row["killer"] else "laws"
    return row["program"] + (" " + row["killer"] if row["killer"] else "")


def main():
    sample, before = read(sys.argv[1]), fates(sys.argv[2])
    equivalent = json.loads(Path(sys.argv[3]).read_text())
    after = fates(sys.argv[4]) if len(sys.argv) > 4 else {}
    rows = []
    for drawn in sample:
        row = {"draw": drawn["draw"], "mutant": drawn["name"]}
        if drawn["unviable"] is not None:
            row |= {"outcome": "unviable", "why": drawn["unviable"].split("\n")[0]}
        else:
            outcome, by = before[drawn["number"]]
            row |= {"outcome": outcome}
            if by:
                row["killer"] = by
            if outcome == "missed" and drawn["name"] in equivalent:
                row |= {"outcome": "equivalent", "why": equivalent[drawn["name"]]}
            elif outcome == "missed" and after.get(drawn["number"], ("missed",))[0] != "missed":
                row |= {"outcome": after[drawn["number"]][0], "killer": after[drawn["number"]][1], "new": True}
        rows.append(row)
        print(json.dumps(row, ensure_ascii=False))
    viable = [row for row in rows if row["outcome"] != "unviable"]
    told = [row for row in viable if row["outcome"] != "equivalent"]
    caught = [row for row in told if row["outcome"] != "missed"]
    old = [row for row in caught if "new" not in row]
    laws = [row for row in old if row.get("killer", "").startswith("law")]

    def figure(what, k, n):
        low, high = wilson(k, n)
        print(f"{what}: {k} of {n}, {100 * k / n:.1f} % (Wilson 95 %: {100 * low:.1f} to {100 * high:.1f})", file=sys.stderr)

    print(f"{len(rows)} drawn, {len(viable)} viable, {len(viable) - len(told)} equivalent", file=sys.stderr)
    figure("caught before any test was added, of all viable", len(old), len(viable))
    figure("caught before any test was added, of the not equivalent", len(old), len(told))
    print(f"of these {len(laws)} by a law, {sum(row['outcome'] == 'timeout' for row in old)} by the time limit", file=sys.stderr)
    figure("caught now, of the not equivalent", len(caught), len(told))


if __name__ == "__main__":
    main()
