"""Functions of the benchmark scripts: they build the program, run it on chosen cores, and compute rates and ratios. Needs Linux, cargo, python3 >= 3.9."""
import csv
import datetime
import functools
import json
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "target" / "peers"
# The environment variable DIPTYCH names a program that is measured in place of the one that is built here
BINARY = Path(os.environ.get("DIPTYCH", ROOT / "target" / "release" / "diptych"))


def build():
    if "DIPTYCH" not in os.environ:
        subprocess.run(["cargo", "build", "--release", "--locked", "--quiet"], cwd=ROOT, check=True)
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"load average at the start: {os.getloadavg()[0]:.2f} on {os.cpu_count()} processors", flush=True)


def settings(pairs):
    return [word for key, value in pairs.items() for word in ("--set", f"{key}={value}")]


def execute(command, cores="0"):
    """Runs a command on the given cores. Returns its largest resident memory [byte], and its processor time divided by its wall time [-]."""
    began = time.monotonic()
    process = subprocess.Popen(["taskset", "-c", cores, *map(str, command)], cwd=WORK, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"failed with {process.returncode}: {' '.join(map(str, command))}")
    share = (usage.ru_utime + usage.ru_stime) / (time.monotonic() - began)
    return usage.ru_maxrss * 1024, share  # Linux counts kibibytes


def diptych(case, out, model, keys, threads=1, options=()):
    """Runs a case. Returns its entry in `variants` of summary.json, with two more keys: `peak_memory` [byte], and
    `share` [-], the processor time over the wall time."""
    out = WORK / out
    cores = ",".join(map(str, range(threads)))
    command = [BINARY, "run", case, "--model", model, "--threads", threads, "--quiet", "--overwrite", "--out", out]
    memory, share = execute([*command, *options, *settings(keys)], cores)
    variant = json.loads((out / "summary.json").read_text())["variants"][0]
    return {**variant, "peak_memory": memory, "share": share}


def from_a_file(case, model, keys, settle="0 s"):
    """Path of a copy of `case` that starts from a file, so that several runs have the same random start, which takes long to make. The start is
    the state after the simulated time `settle`."""
    diptych(case, "placed-start", model, {**keys, "run.duration": settle}, 1, ["--save-state"])
    random = ("count", "volume_fraction", "velocity_mean", "velocity_fluctuation")
    lines = [line for line in case.read_text().splitlines() if not line.startswith(random)]
    at = next(k for k, line in enumerate(lines) if line.startswith("use = \"particles/")) + 1
    placed = WORK / "placed.toml"
    placed.write_text("\n".join([*lines[:at], 'file = "placed-start/state.csv"', *lines[at:]]) + "\n")
    return placed


shares = []


def rate(variant):
    """[-] simulated seconds per second of the loop over windows, without reading, placing and writing, on one thread. The wall time is
    multiplied by the share of the core that the process got (1 on a quiet machine), so that the time of other processes does not count."""
    shares.append(min(variant["share"], 1.0))
    return variant["simulated_seconds"] / (variant["wall_seconds"] * shares[-1])


def loop_time(log, share):
    """[s] wall time of the last loop in a log of LAMMPS or LIGGGHTS, times the share of the core that the process got. LAMMPS states this
    share for the loop; without it, `share` of the whole process is taken."""
    text = Path(log).read_text()
    stated = re.findall(r"([0-9.]+)% CPU use", text)
    shares.append(min(float(stated[-1]) / 100 if stated else share, 1.0))
    return float(re.findall(r"Loop time of ([0-9.eE+-]+)", text)[-1]) * shares[-1]


def in_turn(runs, contestants):
    """Runs each contestant once per round, so that slow changes of the machine affect all of them alike. Returns a list of results per name."""
    rates = {name: [] for name in contestants}
    for _ in range(runs):
        for name, run in contestants.items():
            rates[name].append(run())
    return rates


def spread(values, form=".3g"):
    return f"{statistics.median(values):{form}} [{min(values):{form}} - {max(values):{form}}]"


RESULTS = WORK / "results.csv"
HEADER = ["date", "processor", "versions", "load", "scene", "run", "quantity", "unit", "rounds", "median", "least", "greatest"]


@functools.cache
def processor():
    """Name of the processor as the system states it, and the number of processors."""
    names = re.findall(r"^(?:model name|cpu family|model)\s*: (.*)$", Path("/proc/cpuinfo").read_text(), re.M)[:3]
    return f"{' / '.join(names) or platform.machine()} x {os.cpu_count()}"


@functools.cache
def versions():
    """Versions of the programs that are compared."""
    ours = subprocess.run([BINARY, "--version"], capture_output=True, text=True).stdout.strip()
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    found = [f"{ours} {commit}"]
    if shutil.which("lmp"):
        told = subprocess.run(["lmp", "-h"], capture_output=True, text=True).stdout
        found += re.findall(r"Large-scale Atomic/Molecular Massively Parallel Simulator - (.*)", told)[:1]
    if os.environ.get("EDMD"):
        told = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=os.environ["EDMD"], capture_output=True, text=True)
        found.append(f"EDMD {told.stdout.strip()}")
    return "; ".join(found)


def save(scene, run, quantity, unit, values):
    """Adds the median and the range of the values of all rounds to results.csv, from which `benches/page.py` makes tables."""
    new = not RESULTS.exists()
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    middle = [f"{number:.6g}" for number in (statistics.median(values), min(values), max(values))]
    with open(RESULTS, "a", newline="") as file:
        table = csv.writer(file)
        if new:
            table.writerow(HEADER)
        date = datetime.date.today().isoformat()
        table.writerow([date, processor(), versions(), f"{os.getloadavg()[0]:.1f}", scene, run, quantity, unit, len(values), *middle])


def ratios(title, rates, base):
    """Prints the rates of each contestant, divided by those of `base` in the same round, as rows of a table: median [least - greatest]."""
    print(f"\n{title}: simulated time per wall time over {base}, {len(rates[base])} rounds; ", end="")
    print(f"least share of the core {min(shares, default=1.0):.2f}, load {os.getloadavg()[0]:.1f}")
    print("| run | ratio, median [range] | wall seconds per simulated second, median [range] |\n|---|---|---|")
    for name, values in rates.items():
        ratio = [value / reference for value, reference in zip(values, rates[base])]
        print(f"| {name} | {spread(ratio)} | {spread([1 / value for value in values], '.4g')} |", flush=True)
        save(title, name, f"simulated time per wall time over {base}", "-", ratio)
        save(title, name, "wall time per simulated time", "-", [1 / value for value in values])
