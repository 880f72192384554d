#!/usr/bin/env python3
"""Gathers what docs/paper.md cites from the folders that `diptych compare` wrote.

    docs/results/paper/collect.py OUT RUN...

RUN: a folder of results (summary.json, profiles.csv); its name becomes the first column. Writes into the folder OUT

* runs.csv: one row per variant: temperature, rates, overlaps, balance of forces, all with standard errors;
* verdicts.csv: one row per comparison and observable: difference, error, answer, margin reached;
* profiles.csv: n, U and the second moments by slice, with standard errors, to six digits.

Only the standard library is needed.
"""

import csv
import json
import pathlib
import sys

PROFILES = ["number_density_ratio", "U", "uu", "vv", "ww", "uv"]


def six(value):
    """A number to six digits; what is not known stays empty."""
    return "" if value is None or value == "" else f"{float(value):.6g}"


def inside(tree, *path):
    """A value in nested objects, or nothing."""
    for key in path:
        tree = tree.get(key) if isinstance(tree, dict) else None
    return tree


def run_rows(name, summary):
    for variant in summary["variants"]:
        row = {"run": name, "variant": variant["name"], "particles": variant["particles"]}
        averaging = variant["averaging"]
        row |= {"from_s": six(averaging["from"]), "until_s": six(averaging["until"])}
        row["steady"] = averaging["steadiness"]["steady"]
        known = {
            "T": inside(variant, "granular_temperature"),
            "pair_impacts_per_s": inside(variant, "impacts_per_second", "pairs"),
            "wall_impacts_per_s": inside(variant, "impacts_per_second", "walls"),
            "force_sum_N": inside(variant, "momentum_balance", "residual"),
            "wall_force_N": inside(variant, "momentum_balance", "wall"),
        }
        for key, found in known.items():
            row |= {key: six(inside(found, "value")), key + "_se": six(inside(found, "standard_error"))}
        row["weight_N"] = six(inside(variant, "momentum_balance", "weight"))
        for kind in ["pairs", "walls"]:
            for key in ["mean_normal_speed", "mean_maximum_overlap", "p99_maximum_overlap", "largest_overlap"]:
                row[f"{kind}_{key}"] = six(inside(variant, "impacts", kind, key))
        row["final_state_hash"] = variant["final_state_hash"]
        yield row


def verdict_rows(name, summary):
    for one in summary["comparisons"]:
        for judged in (one["comparison"] or {"judged": []})["judged"]:
            row = {"run": name, "variant": one["variant"], "reference": one["reference"], "verdict": one["verdict"]}
            row |= {"observable": judged["name"], "unit": judged["unit"], "scale": six(judged["scale"])}
            for which in ["mean", "largest"]:
                found = judged[which]
                row |= {f"{which}_difference": six(inside(found, "difference")), f"{which}_se": six(inside(found, "error"))}
            row["largest_y_m"] = six(inside(judged["largest"], "place"))
            row |= {"found": judged["detected"], "answer": judged["answer"], "margin_reached": six(judged["reached"])}
            row["smallest_detectable"] = six(judged["detectable"])
            yield row


def profile_rows(name, folder):
    with open(folder / "profiles.csv", newline="") as file:
        for row in csv.DictReader(file):
            kept = {"run": name, "variant": row["variant"], "slice": row["slice"], "y_m": six(row["y_m"])}
            for column in PROFILES:
                kept |= {column: six(row[column]), column + "_se": six(row[column + "_se"])}
            yield kept


def write(path, rows):
    rows = list(rows)
    with open(path, "w", newline="") as file:
        table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    print(path, len(rows), "rows")


def main():
    out, folders = pathlib.Path(sys.argv[1]), [pathlib.Path(name) for name in sys.argv[2:]]
    out.mkdir(parents=True, exist_ok=True)
    summaries = [(folder, json.loads((folder / "summary.json").read_text())) for folder in folders]
    write(out / "runs.csv", (row for folder, one in summaries for row in run_rows(folder.name, one)))
    write(out / "verdicts.csv", (row for folder, one in summaries for row in verdict_rows(folder.name, one)))
    write(out / "profiles.csv", (row for folder, _ in summaries for row in profile_rows(folder.name, folder)))


if __name__ == "__main__":
    main()
