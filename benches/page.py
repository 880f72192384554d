#!/usr/bin/env python3
"""Tables in Markdown from the results of the benchmark scripts: one table per quantity, a row per scene and run.

    benches/page.py [FILE]

FILE is target/peers/results.csv unless another one is named. If a row was measured more than once, the last one counts.
"""
import csv
import sys
from pathlib import Path

import measure


def number(text):
    return f"{float(text):.3g}"


def main():
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else measure.RESULTS
    if not path.exists():
        sys.exit(f"{path} is not there: run benches/peers/run.py first")
    with open(path, newline="") as file:
        rows = {(row["quantity"], row["scene"], row["run"]): row for row in csv.DictReader(file)}
    for heading in dict.fromkeys((row["quantity"], row["unit"]) for row in rows.values()):
        quantity, unit = heading
        print(f"\n{quantity} [{unit}], median (least – greatest)\n")
        print("| scene | run | value | rounds | date | load |\n|---|---|---|---|---|---|")
        for row in (row for row in rows.values() if (row["quantity"], row["unit"]) == heading):
            value = f"{number(row['median'])} ({number(row['least'])} – {number(row['greatest'])})"
            print(f"| {row['scene']} | {row['run']} | {value} | {row['rounds']} | {row['date']} | {row['load']} |")
    for told in dict.fromkeys((row["processor"], row["versions"]) for row in rows.values()):
        print(f"\nMeasured on {told[0]} with {told[1]}.")


if __name__ == "__main__":
    main()
