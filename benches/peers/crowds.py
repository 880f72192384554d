"""Speed of hard spheres, dense and dilute, compared with EDMD, and the cost per particle with few and with many particles. `run.py` calls it.

EDMD is the event-driven code of Smallenburg (2022, Eur. Phys. J. E 45, 22). Its settings are in its source, so it is built here for every
run, from a clone that the environment variable EDMD names:

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
DIAMETER = 406e-6  # [m] diameter of the spheres in hard.toml
SPEED = 0.5  # [m/s] standard deviation of the velocities in hard.toml, the square root of the temperature T
# Volume fraction, number of particles, best shell of EDMD (reach of its neighbour lists, in diameters d), and measured time [d/sqrt(T)]. This time
# has two to four million collisions (a seventh of a million in the dilute gas) and takes seconds, long compared with the scatter of the time to start
SCENES = [
    (0.5, 10_000, 1.3, 20.0), (0.5, 100_000, 1.5, 2.0), (0.3, 10_000, 1.5, 40.0), (0.3, 100_000, 1.4, 4.0), (0.01, 10_000, 2.0, 200.0),
    (0.01, 100_000, 2.6, 20.0),
]


def collisions(count, fraction):
    """[sqrt(T)/d] collision rate of all particles together, by Enskog's theory with the contact value of Carnahan and Starling."""
    return 0.5 * count * 24 * fraction * (1 - fraction / 2) / (1 - fraction) ** 3 / math.sqrt(math.pi)


def edge(count, fraction):
    """[m] edge of a cube that contains `count` spheres at the volume fraction `fraction`."""
    return DIAMETER * (count * math.pi / 6 / fraction) ** (1 / 3)


def processor_time(command, folder, variables=None):
    """[s] processor time of a command on core 0, without the time of the operating system, and its largest resident memory [byte]."""
    environment = {**os.environ, **(variables or {})}
    process = subprocess.Popen(["taskset", "-c", "0", *map(str, command)], cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"failed with {process.returncode}: {' '.join(map(str, command))}")
    return usage.ru_utime, usage.ru_maxrss * 1024


def size(count, fraction):
    """Keys of a case for a cube that contains `count` spheres at the volume fraction `fraction`."""
    return {f"domain.size[{axis}]": f"{edge(count, fraction)} m" for axis in range(3)}


def ours(case, count, fraction, time, keys=(), variables=None):
    """Processor time [s] and memory [byte] of a run of `time` [s]. The case has a random start, or is one of `measure.from_a_file`."""
    words = ["run", HERE / case, "--threads", 1, "--quiet", "--overwrite", "--out", WORK / "crowd", *measure.settings(size(count, fraction))]
    if HERE in (HERE / case).parents:
        words += ["--set", f"particles[0].volume_fraction={fraction}"]
    return processor_time([measure.BINARY, *words, "--set", f"run.duration={time} s", *keys], WORK, variables)


def positions(count, fraction):
    """Positions of the spheres in a random start of our program [diameters]."""
    ours("hard.toml", count, fraction, 0, ["--save-state"])
    with open(WORK / "crowd" / "state.csv") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return [[float(row[axis]) / DIAMETER for axis in "xyz"] for row in rows]


def edmd(count, fraction, shell, time):
    """Folder in which EDMD was built such that it runs for `time` [d/sqrt(T)] from a start of our program."""
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
    """Prints and saves collisions per second of both programs. The processor time of a run of a fifth of the length is subtracted, so that the time to
    start does not count."""
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


# With this environment variable, the allocator of glibc (2.35 or newer) asks the system for memory pages of 2 MB.
LARGE_PAGES = {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}


def growth(rounds, counts, window, fractions=(0.3, 0.5), models=("hard", "soft")):
    """Prints and saves the processor time and the memory per particle for each number of particles in `counts`, with memory pages of usual size and of
    2 MB. Windows have the length `window` [d/sqrt(T)]. Times are those of a long run minus a short one; the short one has one window, the long one has
    at least four more, and more of them if there are fewer particles."""
    print("| model | volume fraction | particles | µs of processor time per particle and d/sqrt(T), median [range] | over the smallest "
          "| with pages of 2 MB | over pages of usual size | bytes per particle |")
    print("|---|---|---|---|---|---|---|---|")
    unit = DIAMETER / SPEED
    for model in models:
        case = {"hard": "hard.toml", "soft": "dense.toml"}[model]
        for fraction in fractions:
            smallest = None
            for count in counts:
                # restitution 1, because a cooling gas costs less and less; one length of windows for all, because each window ends with a sample
                start = {**size(count, fraction), "particles[0].volume_fraction": fraction}
                placed = measure.from_a_file(HERE / case, model, start)
                keys = ["--model", model, "--set", "contact.restitution=1", "--set", f"run.window={window * unit} s"]
                keys += ["--set", f"statistics.sample_interval={window * unit} s"]
                # memory in runs from a random start, without the memory for reading a file
                few, many = [ours(case, number, fraction, window * unit, keys)[1] for number in (1000, count)]

                # four windows with few particles take a tenth of a second, less than the scatter of the time to start
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
