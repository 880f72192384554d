#!/usr/bin/env python3
"""Counts instructions, and bytes that move between caches and memory, per particle and window of the benchmark scenes.

    apt-get install valgrind python3
    benches/traffic.py [SCENE ...]

Scenes are s1, d, f, dense and crowd; all of them unless some are named. Callgrind executes the program on a simulated processor, so that
neither the machine nor its load matters. A count is that of a long run minus that of a short one, so that the start and the first window do not count.
Writes target/peers/traffic.csv and, for each row, the functions with most instructions.
"""
import csv
import json
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "peers"))
import crowds
import measure
import scenes
from measure import WORK

LINE = 64  # [byte] size of a cache line
# Data caches of the first and second level of a core, as AMD states them for the EPYC of docs/results/speed.md: 48 KiB, 12 ways; 1 MiB, 16 ways.
CACHES = ["--D1=49152,12,64", "--LL=1048576,16,64"]
# [byte] position and velocity of a particle, three numbers of 8 bytes each, read once and written once
ONCE = 2 * 2 * 3 * 8
EVENTS = ("Ir", "Dr", "Dw", "D1mr", "D1mw", "DLmr", "DLmw")


def count(case, model, keys, out):
    """Counts of a run within the loop over windows, and the entry of the run in `variants` of summary.json."""
    command = ["valgrind", "--tool=callgrind", "--cache-sim=yes", *CACHES, f"--callgrind-out-file={WORK / out}.callgrind"]
    command += ["--toggle-collect=*Simulation::run_while*", measure.BINARY, "run", case, "--model", model, "--threads", "1"]
    command += ["--quiet", "--overwrite", "--out", WORK / out, *measure.settings(keys)]
    run = subprocess.run(list(map(str, command)), cwd=WORK, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"failed with {run.returncode}: {' '.join(map(str, command))}\n{run.stderr[-2000:]}")
    text = (WORK / f"{out}.callgrind").read_text()
    names = re.search(r"^events: (.*)$", text, re.M).group(1).split()
    values = map(int, re.search(r"^(?:totals|summary): (.*)$", text, re.M).group(1).split())
    counts = dict(zip(names, values))
    return {name: counts.get(name, 0) for name in EVENTS}, json.loads((WORK / out / "summary.json").read_text())["variants"][0]


def row(name, unit, case, model, keys, spans, units):
    """Differences of the counts of two runs, whose durations [s] are `spans`, per unit of work. The function `units` returns the units of a run."""
    runs = [count(case, model, {**keys, "run.duration": f"{span} s"}, "traffic") for span in spans]
    work = units(runs[1][1]) - units(runs[0][1])
    if work <= 0:
        sys.exit(f"{name}: the longer run has no more {unit} than the shorter one")
    per = {event: (runs[1][0][event] - runs[0][0][event]) / work for event in EVENTS}
    near = LINE * (per["D1mr"] + per["D1mw"])
    far = LINE * (per["DLmr"] + per["DLmw"])
    print(f"| {name} | {unit} | {per['Ir']:.0f} | {per['Dr'] + per['Dw']:.0f} | {near:.0f} | {far:.0f} |", flush=True)
    return {"scene": name, "unit": unit, **per, "bytes_to_first_level": near, "bytes_to_second_level": far}


def particle_windows(variant):
    return variant["particles"] * variant["windows"]


def particle_steps(step):
    return lambda variant: variant["particles"] * variant["simulated_seconds"] / step


def collisions(variant):
    return variant["pair_impacts"]


def rows_of(scene):
    """Arguments of `row` for each row of a scene: name, unit, case, model, keys, the two durations [s], and the function that counts units."""
    per_window = ("particle and window", particle_windows)
    if scene == "s1":
        for model in ("hard", "soft"):
            keys = {"soft.stepping": "local", "soft.steps_per_contact": 20}
            yield f"S1, {model}", per_window[0], HERE / "peers" / "s1.toml", model, keys, (1.5e-3, 4.5e-3), per_window[1]
    if scene in ("d", "f"):
        case, span = (scenes.settled(scenes.D), (1e-3, 2e-3)) if scene == "d" else (scenes.settled(scenes.F), (20e-3, 60e-3))
        for model in ("hard", "soft"):
            yield f"{scene.upper()}, {model}", per_window[0], case, model, {"soft.stepping": "local"}, span, per_window[1]
    if scene == "dense":
        step = scenes_step()
        case = measure.from_a_file(HERE / "peers" / "dense.toml", "soft", {})
        keys = {"run.window": f"{20 * step} s", "statistics.sample_interval": f"{20 * step} s"}
        yield "dense, soft", "particle and step", case, "soft", keys, (20 * step, 120 * step), particle_steps(step)
    if scene == "crowd":
        for fraction in (0.5, 0.01):
            for number in (10_000, 100_000):
                size = {f"domain.size[{axis}]": f"{crowds.edge(number, fraction)} m" for axis in range(3)}
                # time with one collision per particle; the long run is three times as long
                span = number / crowds.collisions(number, fraction) * crowds.DIAMETER / crowds.SPEED / 2
                case = measure.from_a_file(HERE / "peers" / "hard.toml", "hard", {**size, "particles[0].volume_fraction": fraction})
                keys = {**size, "run.window": f"{span} s", "statistics.sample_interval": f"{span} s"}
                name = f"hard spheres, φ = {fraction}, {number}"
                yield name, "collision", case, "hard", keys, (span, 3 * span), collisions


def scenes_step():
    """[s] time step of dense.toml."""
    return float(re.search(r'time_step = "([0-9.e-]+) s"', (HERE / "peers" / "dense.toml").read_text()).group(1))


def main():
    wanted = sys.argv[1:] or ["s1", "d", "f", "dense", "crowd"]
    unknown = [scene for scene in wanted if scene not in ("s1", "d", "f", "dense", "crowd")]
    if unknown:
        sys.exit(f"usage: benches/traffic.py [s1] [d] [f] [dense] [crowd]; not understood: {' '.join(unknown)}")
    measure.build()
    print(f"position and velocity of a particle, read and written once: {ONCE} bytes")
    print("| scene | unit | instructions | accesses of data | bytes to the first level | bytes to the second level |\n|---|---|---|---|---|---|")
    rows = [row(*arguments) for scene in wanted for arguments in rows_of(scene)]
    with open(WORK / "traffic.csv", "w", newline="") as file:
        table = csv.DictWriter(file, rows[0].keys())
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
