"""Hard spheres, dense and dilute, beside EDMD, and what a particle costs in small and in large crowds. `run.py` calls it.

EDMD is event-driven code of Smallenburg (2022, Eur. Phys. J. E 45, 22). It has its settings in its source, so that it is built here for every
run, from a clone that the variable EDMD names:

    git clone https://github.com/FSmallenburg/EDMD
    EDMD=$PWD/EDMD benches/peers/run.py 5 hard
"""
import csv
import math
import os
import re
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

import measure
from measure import WORK

HERE = Path(__file__).resolve().parent
DIAMETER = 406e-6  # [m] of hard.toml
SPEED = 0.5  # [m/s] of hard.toml, the square root of the temperature
# Volume fraction, particles, the shell of EDMD [diameters] that is best there, and the time [d/sqrt(T)] that is measured: two to four million
# collisions, in the dilute gas a seventh of one, which take seconds, so that the scatter of the start, which is taken off, is small beside them
SCENES = [
    (0.5, 10_000, 1.3, 20.0), (0.5, 100_000, 1.5, 2.0), (0.3, 10_000, 1.5, 40.0), (0.3, 100_000, 1.4, 4.0), (0.01, 10_000, 2.0, 200.0),
    (0.01, 100_000, 2.6, 20.0),
]


def collisions(count, fraction):
    """[sqrt(T)/d] of all, by Enskog's theory with the contact value of Carnahan and Starling."""
    return 0.5 * count * 24 * fraction * (1 - fraction / 2) / (1 - fraction) ** 3 / math.sqrt(math.pi)


def edge(count, fraction):
    """[m] of a cube with so many spheres."""
    return DIAMETER * (count * math.pi / 6 / fraction) ** (1 / 3)


def processor_time(command, folder, variables=None):
    """[s] of a command on core 0, without what the system does for it, and its greatest resident memory [byte]."""
    environment = {**os.environ, **(variables or {})}
    process = subprocess.Popen(["taskset", "-c", "0", *map(str, command)], cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"failed with {process.returncode}: {' '.join(map(str, command))}")
    return usage.ru_utime, usage.ru_maxrss * 1024


def size(count, fraction):
    """Settings of a cube with so many spheres."""
    return {f"domain.size[{axis}]": f"{edge(count, fraction)} m" for axis in range(3)}


def ours(case, count, fraction, time, keys=(), variables=None):
    """Processor time [s] and memory [byte] of a run of `time` [s]. The case has a random start, or is one of `measure.from_a_file`."""
    words = ["run", HERE / case, "--threads", 1, "--quiet", "--overwrite", "--out", WORK / "crowd", *measure.settings(size(count, fraction))]
    if HERE in (HERE / case).parents:
        words += ["--set", f"particles[0].volume_fraction={fraction}"]
    return processor_time([measure.BINARY, *words, "--set", f"run.duration={time} s", *keys], WORK, variables)


def positions(count, fraction):
    """A random start of ours [diameters]."""
    ours("hard.toml", count, fraction, 0, ["--save-state"])
    with open(WORK / "crowd" / "state.csv") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return [[float(row[axis]) / DIAMETER for axis in "xyz"] for row in rows]


def edmd(count, fraction, shell, time):
    """A folder with EDMD built to run for `time` [d/sqrt(T)] from our start."""
    folder = WORK / f"edmd-{count}-{fraction}-{time}"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(Path(os.environ["EDMD"]) / "Single", folder)
    source = (folder / "mdSingle.c").read_text()
    settings = {"maxtime": time, "writeinterval": time, "initialconfig": 0, "shellsize": shell, "usethermostat": 0}
    for name, value in settings.items():
        source, found = re.subn(rf"(\b{name}\s*=\s*)[^;]+;", rf"\g<1>{value};", source, count=1)
        if not found:
            sys.exit(f"this EDMD has no setting {name}")
    (folder / "mdSingle.c").write_text(source)
    side = edge(count, fraction) / DIAMETER
    lines = [f"a {x:.15g} {y:.15g} {z:.15g} 0.5" for x, y, z in positions(count, fraction)]
    (folder / "init.sph").write_text("\n".join([str(len(lines)), f"{side:.15g} {side:.15g} {side:.15g}", *lines]) + "\n")
    flags = ["-Ofast", "-funroll-loops", "-march=native"]
    subprocess.run(["gcc", *flags, "mdSingle.c", "-o", "md", "-lm"], cwd=folder, check=True, stderr=subprocess.DEVNULL)
    return folder


def beside_edmd(rounds):
    """Collisions per second, medians and ranges; the processor time of a run less that of one of a fifth of the time, so that starting is not in it."""
    if not os.environ.get("EDMD") or not shutil.which("gcc"):
        print("dense hard spheres: no EDMD (the variable names its clone) or no gcc")
        return
    print("| volume fraction | particles | EDMD, 10⁶ collisions/s | ours | over EDMD |\n|---|---|---|---|---|")
    for fraction, count, shell, time in SCENES:
        short, long = [edmd(count, fraction, shell, factor * time) for factor in (0.25, 1.25)]
        unit = DIAMETER / SPEED

        def theirs():
            return time / (processor_time(["./md"], long)[0] - processor_time(["./md"], short)[0])

        def mine():
            keys = ["--set", f"run.window={0.25 * time * unit} s", "--set", f"statistics.sample_interval={0.25 * time * unit} s"]
            spent = [ours("hard.toml", count, fraction, factor * time * unit, keys)[0] for factor in (0.25, 1.25)]
            return time / (spent[1] - spent[0])

        rates = measure.in_turn(rounds, {"EDMD": theirs, "ours": mine})
        ratio = sorted(a / b for a, b in zip(rates["ours"], rates["EDMD"]))
        columns = [measure.spread([1e-6 * collisions(count, fraction) * rate for rate in rates[name]], ".2f") for name in ("EDMD", "ours")]
        scene = f"{count} hard spheres, volume fraction {fraction}"
        for name in ("EDMD", "ours"):
            measure.save(scene, name, "collisions per processor time", "1/s", [collisions(count, fraction) * rate for rate in rates[name]])
        measure.save(scene, "ours", "collisions per processor time over EDMD", "-", ratio)
        print(f"| {fraction} | {count} | {columns[0]} | {columns[1]} | {measure.spread(ratio, '.2f')} |", flush=True)


# A program that uses the allocator of glibc (2.35 or newer) asks for pages of 2 MB if this variable is set, and the system allows it.
LARGE_PAGES = {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}


def growth(rounds, counts, window, fractions=(0.3, 0.5), models=("hard", "soft")):
    """Cost of a particle in small and in large crowds, with pages of usual size and of 2 MB, and memory. Windows have the length `window`
    [d/sqrt(T)]. The short run has one; the long one has four more, and the more of them the fewer particles there are."""
    print("| model | volume fraction | particles | µs of processor time per particle and d/sqrt(T), median [range] | over the smallest "
          "| with pages of 2 MB | over pages of usual size | bytes per particle |")
    print("|---|---|---|---|---|---|---|---|")
    unit = DIAMETER / SPEED
    for model in models:
        case = {"hard": "hard.toml", "soft": "dense.toml"}[model]
        for fraction in fractions:
            smallest = None
            for count in counts:
                # elastic: a gas that cools costs less the longer it is looked at; windows of one length for all: each ends with a sample
                start = {**size(count, fraction), "particles[0].volume_fraction": fraction}
                placed = measure.from_a_file(HERE / case, model, start)
                keys = ["--model", model, "--set", "contact.restitution=1", "--set", f"run.window={window * unit} s"]
                keys += ["--set", f"statistics.sample_interval={window * unit} s"]
                # memory without that of reading a file
                few, many = [ours(case, number, fraction, window * unit, keys)[1] for number in (1000, count)]

                # four windows of a small crowd are done within a tenth of a second, less than the scatter of the start
                more = 4 * max(1, 1_000_000 // count)

                def cost(variables):
                    short, long = [ours(placed, count, fraction, time * window * unit, keys, variables) for time in (1, 1 + more)]
                    return (long[0] - short[0]) / count / (more * window) * 1e6

                contestants = {"usual": lambda: cost({}), "large": lambda: cost(LARGE_PAGES)}
                costs = measure.in_turn(rounds, contestants)
                median = statistics.median(costs["usual"])
                smallest = smallest or median
                ratio = [large / usual for usual, large in zip(costs["usual"], costs["large"])]
                per = (many - few) / (count - 1000)
                scene = f"{count} {model} spheres, volume fraction {fraction}"
                measure.save(scene, "ours", "processor time per particle and d/sqrt(T)", "us", costs["usual"])
                measure.save(scene, "ours, pages of 2 MB", "processor time per particle and d/sqrt(T)", "us", costs["large"])
                measure.save(scene, "ours, pages of 2 MB", "processor time over that with pages of usual size", "-", ratio)
                measure.save(scene, "ours", "memory per particle", "byte", [per])
                print(f"| {model} | {fraction} | {count} | {measure.spread(costs['usual'])} | {median / smallest:.2f} "
                      f"| {measure.spread(costs['large'])} | {measure.spread(ratio, '.2f')} | {per:.0f} |", flush=True)
