#!/usr/bin/env python3
"""Judges released software with `euler-poincare probe`, and writes the table. See README.md."""
import argparse
import concurrent.futures
import csv
import hashlib
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import tomllib

import systems

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
LAWS = {"casimirs": "method-conserves-casimirs", "energy": "method-conserves-energy", "reversible": "method-reversibility",
        "equivariant": "method-equivariance"}
LABELS = {"so3": "SO(3)", "se3": "SE(3)", systems.TORQUE: "SO(3) with a torque"}
COLUMNS = ["package", "version", "integrator", "system", "seed", "cases", "judged", "momentum_least", "momentum_median",
           "attitude_least", "attitude_median", *LAWS, "notes"]


def environment(name, package, folder):
    """Makes the environment of a package, unless it is there. Returns the command of its adapter."""
    place = folder / name
    wanted = json.dumps([package.get(k) for k in ("pip", "npm", "cargo", "debian")])
    source = HERE / package["program"] if "program" in package else None
    for file in [source, *(sorted((HERE / package["cargo"]).rglob("*.*")) if "cargo" in package else [])]:
        wanted += hashlib.sha256(file.read_bytes()).hexdigest() if file and file.is_file() else ""
    stamp, run = place / "installed", lambda *command, **options: subprocess.run(command, check=True, **options)
    fresh = not stamp.exists() or stamp.read_text() != wanted
    if fresh:
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True, exist_ok=True)
    if "pip" in package:
        python = place / "bin/python"
        if fresh:
            run(sys.executable, "-m", "venv", place)
            run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *package["pip"])
        command = [python, HERE / package["adapter"]]
    else:
        # Not in Python: the common adapter, with numpy, and a program behind it.
        if fresh:
            run(sys.executable, "-m", "venv", place / "python")
            run(place / "python/bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "numpy==2.4.6")
        if "npm" in package:
            program = ["node", place / source.name]
            if fresh:
                run("npm", "install", "--silent", "--prefix", place, *package["npm"])
                shutil.copy(source, place)
        elif "cargo" in package:
            program = [place / "release" / (package["cargo"] + "-stepper")]
            if fresh:
                run("cargo", "build", "--quiet", "--release", "--locked", "--target-dir", place, cwd=HERE / package["cargo"])
        else:
            program = [place / source.stem]
            if fresh:
                flags = run("pkg-config", "--cflags", "--libs", package["library"], capture_output=True, text=True).stdout.split()
                run("g++", "-O2", "-std=c++17", source, "-o", program[0], *flags)
        command = [place / "python/bin/python", HERE / "piped.py", *program]
    stamp.write_text(wanted)
    return [str(word) for word in command]


def version(name, package):
    for pin in package.get("pip", []) + package.get("npm", []):
        found, _, number = pin.replace("@", "==").partition("==")
        if found == name:
            return number
    if "cargo" in package:
        lock = tomllib.loads((HERE / package["cargo"] / "Cargo.lock").read_text())
        return next(entry["version"] for entry in lock["package"] if entry["name"] == name)
    return subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package["debian"]], capture_output=True, text=True).stdout


def probe(options, file, claims, command, folder):
    """What `probe` prints, by law."""
    words = [options.command, "probe", "--format", "json", "--timeout", "120", "--system", file, *claims, "--", *command]
    run = subprocess.run(words, cwd=folder, capture_output=True, text=True)
    if run.returncode not in (0, 1, 3):
        raise RuntimeError(run.stderr)
    lines = [json.loads(line) for line in run.stdout.splitlines()]
    return {line["law"]: line for line in lines if line["schema"] == "probe/1"}


def judge(options, command, order, tolerance, system, seed, index):
    """One case: the orders of momentum and attitude, and what holds (None: not judged)."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "body.toml"
        file.write_text(systems.system_file(system, seed, index))
        common = ["--tolerance", str(tolerance)] if tolerance else []
        free = system != systems.TORQUE
        laws = "order,reversib,equivar" + (",conserves" if free else "")
        claims = ["--order", str(order + 1), "--reversible", *(["--conserves", "casimirs,energy"] if free else [])]
        found = probe(options, file, ["--laws", laws, *claims, *common], command, folder)
        orders, notes, failure = {}, set(), found["method-order"].get("failure")
        if failure and not failure["varied"]:
            orders = {slope["quantity"]: slope["order"] for slope in failure["slopes"]}
            notes |= {f"{slope['quantity']}: {slope['why']}" for slope in failure["slopes"] if slope["order"] is None}
        elif not found["method-order"]["failed"]:
            # The claim is not refuted.
            line = probe(options, file, ["--laws", "order", *common], command, folder)["method-order"]
            orders = {part["quantity"]: part["least"] for part in line["orders"]}
        for line in found.values():
            notes |= {f"{line['law']}: {why}" for key in ("inconclusive", "not_applicable") for why in line[key]}
            if line["failed"]:
                notes.add(f"{line['law']}: the program failed")
        verdicts = {}
        for key, law in LAWS.items():
            line = found.get(law)
            judged = line and line["held"] + line["broken"] > 0
            verdicts[key] = line["held"] > 0 if judged else None
        return {"orders": orders, "verdicts": verdicts, "notes": notes}


def summary(cases):
    row, judged = {"cases": len(cases)}, 0
    for part in ("momentum", "attitude"):
        values = [case["orders"].get(part) for case in cases]
        values = [x for x in values if x is not None]
        judged = max(judged, len(values))
        row[part + "_least"] = f"{min(values):.2f}" if values else ""
        row[part + "_median"] = f"{statistics.median(values):.2f}" if values else ""
    row["judged"] = judged
    for key in LAWS:
        asked = [case["verdicts"][key] for case in cases if case["verdicts"][key] is not None]
        row[key] = f"{sum(asked)}/{len(asked)}" if asked else ""
    row["notes"] = "; ".join(sorted(set().union(*(case["notes"] for case in cases))))
    return row


def verdict(row):
    """What must be the same for every seed: orders to the next integer, and what held always, sometimes or never."""
    def word(fraction):
        held, _, asked = fraction.partition("/")
        return "" if not asked else "yes" if held == asked else "no" if held == "0" else "some"
    orders = [round(float(row[f"{part}_median"])) if row[f"{part}_median"] else None for part in ("momentum", "attitude")]
    return (*orders, *(word(row[key]) for key in LAWS))


def markdown(rows):
    """One line for each integrator, or more where systems differ; what is not the same for every seed is shown with a stroke."""
    lines = ["| package | integrator | system | order: momentum | attitude | Casimirs | energy | reversible | equivariant | cases |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    table = {}
    for row in rows:
        table.setdefault((row["package"] + " " + row["version"], row["integrator"]), {}).setdefault(row["system"], []).append(row)
    for (package, integrator), by_system in table.items():
        merged = []  # systems, cells, judged, asked
        for system, same in by_system.items():
            words = [[str("" if x is None else x) for x in verdict(row)] for row in same]
            cells = [" / ".join(x for x in dict.fromkeys(column) if x) for column in zip(*words)]
            count = [sum(int(row[key]) for row in same) for key in ("judged", "cases")]
            for line in merged:
                if all(x == y or not x or not y for x, y in zip(line[1], cells)):
                    line[0].append(LABELS[system])
                    line[1] = [x or y for x, y in zip(line[1], cells)]
                    line[2] = [x + y for x, y in zip(line[2], count)]
                    break
            else:
                merged.append([[LABELS[system]], cells, count])
        for names, cells, (judged, asked) in merged:
            lines.append("| " + " | ".join([package, integrator, ", ".join(names), *cells, f"{judged}/{asked}"]) + " |")
    return "\n".join(lines) + "\n"


def write(rows, output):
    with open(output, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    output.with_suffix(".md").write_text(markdown(rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", action="append", help="a package of packages.toml; may be repeated; other rows of the output stay")
    parser.add_argument("--cases", type=int, default=3, help="bodies for each row and seed")
    parser.add_argument("--seed", type=int, action="append", help="may be repeated; default: 1 and 2")
    parser.add_argument("--command", default=shutil.which("euler-poincare") or str(ROOT / "target/release/euler-poincare"))
    parser.add_argument("--environments", type=pathlib.Path, default=ROOT / "target/released")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "snapshots/released.csv", help="the table; beside it the same as .md")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    options.command, options.environments = str(pathlib.Path(options.command).resolve()), options.environments.resolve()
    packages = tomllib.loads((HERE / "packages.toml").read_text())
    # JAX compiles the same programs in every process.
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(options.environments / "jax-cache"))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.2")
    rows, seeds, different = [], options.seed or [1, 2], 0
    if options.only and options.output.exists():
        with open(options.output, newline="") as file:
            rows = list(csv.DictReader(file))
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for name, package in packages.items():
            if options.only and name not in options.only:
                continue
            try:
                command = environment(name, package, options.environments)
            except (subprocess.CalledProcessError, OSError) as error:
                hint = f" (apt-get install {package['debian']} pkg-config g++)" if "debian" in package else ""
                print(f"{name}: not installed: {error}{hint}", file=sys.stderr)
                continue
            rows = [row for row in rows if row["package"] != name]
            tolerance, number = 1e-6 if package.get("bits") == 32 else 0, version(name, package)
            for entry in package["rows"]:
                for system in package.get("systems", ["so3", "se3"]):
                    asked = [(seed, index) for seed in seeds for index in range(options.cases)]
                    found = list(pool.map(lambda which: judge(
                        options, command + entry["arguments"], entry["order"], tolerance, system, *which), asked))
                    same = []
                    for seed in seeds:
                        cases = [case for (of, _), case in zip(asked, found) if of == seed]
                        row = {"package": name, "version": number, "integrator": entry["integrator"], "system": system, "seed": seed}
                        same.append(row | summary(cases))
                    rows += same
                    # An order that is too near to round-off to be measured says nothing.
                    parts = zip(*(verdict(row) for row in same))
                    differs = any(len(set(part) - {None, ""}) > 1 for part in parts)
                    different += differs
                    print(name, entry["integrator"], system, *map(verdict, same), "DIFFERENT" if differs else "", flush=True)
            rows.sort(key=lambda row: list(packages).index(row["package"]))
            write(rows, options.output)
    print(f"{len(rows)} rows in {options.output}; verdicts that differ between seeds: {different}")


if __name__ == "__main__":
    main()
