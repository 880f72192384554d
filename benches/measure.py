"""What the benchmark scripts share: building, pinned runs, rates, ratios. Needs Linux, cargo and python3 3.9 or newer."""
import json
import os
import re
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "target" / "peers"
BINARY = ROOT / "target" / "release" / "diptych"


def build():
    subprocess.run(["cargo", "build", "--release", "--locked", "--quiet"], cwd=ROOT, check=True)
    WORK.mkdir(parents=True, exist_ok=True)
    print(f"load average at the start: {os.getloadavg()[0]:.2f} on {os.cpu_count()} processors", flush=True)


def settings(pairs):
    return [word for key, value in pairs.items() for word in ("--set", f"{key}={value}")]


def execute(command, cores="0"):
    """Runs a command on the given cores; returns its greatest resident memory [byte] and processor time over wall time."""
    began = time.monotonic()
    process = subprocess.Popen(["taskset", "-c", cores, *map(str, command)], cwd=WORK, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"failed with {process.returncode}: {' '.join(map(str, command))}")
    share = (usage.ru_utime + usage.ru_stime) / (time.monotonic() - began)
    return usage.ru_maxrss * 1024, share  # Linux counts kibibytes


def diptych(case, out, model, keys, threads=1, options=()):
    """Runs a case; returns its variant of summary.json, with `peak_memory` [byte] and
    `share` (processor time over wall time) added."""
    out = WORK / out
    cores = ",".join(map(str, range(threads)))
    command = [BINARY, "run", case, "--model", model, "--threads", threads, "--quiet", "--overwrite", "--out", out]
    memory, share = execute([*command, *options, *settings(keys)], cores)
    variant = json.loads((out / "summary.json").read_text())["variants"][0]
    return {**variant, "peak_memory": memory, "share": share}


shares = []


def rate(variant):
    """[-] simulated seconds per second of the loop: reading, placing and writing are not in it. One thread. Wall time is
    multiplied by the share of the core that the process got: 1 on a quiet machine, and other processes' time is not ours."""
    shares.append(min(variant["share"], 1.0))
    return variant["simulated_seconds"] / (variant["wall_seconds"] * shares[-1])


def loop_time(log, share):
    """[s] the last loop of a LAMMPS or LIGGGHTS log, likewise times the share of the core: the one that LAMMPS states of the
    loop, or else `share`, that of the whole process."""
    text = Path(log).read_text()
    stated = re.findall(r"([0-9.]+)% CPU use", text)
    shares.append(min(float(stated[-1]) / 100 if stated else share, 1.0))
    return float(re.findall(r"Loop time of ([0-9.eE+-]+)", text)[-1]) * shares[-1]


def in_turn(runs, contestants):
    """Each contestant once per round: slow changes of the machine meet all of them alike. Returns a list per name."""
    rates = {name: [] for name in contestants}
    for _ in range(runs):
        for name, run in contestants.items():
            rates[name].append(run())
    return rates


def spread(values, form=".3g"):
    return f"{statistics.median(values):{form}} [{min(values):{form}} - {max(values):{form}}]"


def ratios(title, rates, base):
    """Prints the rates over those of `base` in the same round, as rows of a table: median [least - greatest]."""
    print(f"\n{title}: simulated time per wall time over {base}, {len(rates[base])} rounds; ", end="")
    print(f"least share of the core {min(shares, default=1.0):.2f}, load {os.getloadavg()[0]:.1f}")
    print("| run | ratio, median [range] | wall seconds per simulated second, median [range] |\n|---|---|---|")
    for name, values in rates.items():
        ratio = [value / reference for value, reference in zip(values, rates[base])]
        print(f"| {name} | {spread(ratio)} | {spread([1 / value for value in values], '.4g')} |", flush=True)
