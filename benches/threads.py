#!/usr/bin/env python3
"""Two threads against one, for each engine: wall times, in turn.

    benches/threads.py [ROUNDS] [SCENE ...]

Scenes are s1, d (from its settled start), dense, and crowd-0.5 and crowd-0.3 (100,000 hard spheres at these volume fractions, settled for about
one d/sqrt(T)); all of them unless some are named. Nothing else should run on the two cores. Prints the ratio of wall times of each
round, and the time that a memory word takes to the other core and back, which tells if the two cores share a cache. The final states must have
equal bits.
"""
import re
import statistics
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "peers"))
import crowds
import measure
import scenes

CROWD = 100_000
ENGINES = {"hard": {}, "soft": {"soft.stepping": "local"}, "hybrid": {}}
DENSE = {"soft": {}}


def word_there_and_back():
    """[ns] time until another core has answered to a change of a memory word, as the median of many."""
    command = ["cargo", "bench", "--quiet", "--locked", "--bench", "kernels", "--", "thousand_words"]
    told = subprocess.run(command, cwd=measure.ROOT, check=True, capture_output=True, text=True).stdout
    row = next(line for line in told.splitlines() if "thousand_words" in line)
    # the benchmark gives the time of a thousand round trips
    unit = {"ns": 1e-3, "µs": 1, "ms": 1e3}
    _, _, median, _ = [float(number) * unit[name] for number, name in re.findall(r"([0-9.]+) (ns|µs|ms)", row)]
    return median


def compare(scene, case, model, keys, rounds):
    """Runs a scene on one thread and on two, in turn. Prints and saves the ratio of the wall times."""
    one, two, words = [], [], []
    for _ in range(rounds):
        words.append(word_there_and_back())
        for threads, runs in ((1, one), (2, two)):
            runs.append(measure.diptych(case, f"threads-{scene}-{model}", model, keys, threads))
    if len({run["final_state_hash"] for run in one + two}) != 1:
        sys.exit(f"{scene}, {model}: the final state depends on the number of threads")
    ratios = [a["wall_seconds"] / b["wall_seconds"] for a, b in zip(one, two)]
    held = statistics.median(run["share"] for run in two)
    times = measure.spread([run["wall_seconds"] for run in two])
    measure.save(scene, model, "wall time of one thread over two", "-", ratios)
    measure.save(scene, model, "time of a memory word to the other core and back", "ns", words)
    print(f"| {scene}, {model} | {measure.spread(ratios)} | {times} | {held:.2f} | {measure.spread(words)} |", flush=True)


def crowd(fraction):
    """Function that makes the case of settled hard spheres at a volume fraction, and returns its path."""
    keys = {**crowds.size(CROWD, fraction), "particles[0].volume_fraction": fraction}
    return lambda: measure.from_a_file(HERE / "peers" / "hard.toml", "hard", keys, "0.8 ms")


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    measure.build()
    word_there_and_back()
    cases = {
        "s1": (lambda: HERE / "peers" / "s1.toml", {"run.duration": "60 ms"}, ENGINES),
        "d": (lambda: scenes.settled(scenes.D), {}, ENGINES),
        "dense": (lambda: HERE / "peers" / "dense.toml", {}, DENSE),
        **{
            f"crowd-{fraction}": (crowd(fraction), {**crowds.size(CROWD, fraction), "run.duration": f"{time} ms"}, {"hard": {}})
            for fraction, time in ((0.5, 0.8), (0.3, 2.4))
        },
    }
    print("| scene | wall time of 1 thread over 2, median [range] | s, 2 threads | cores held | ns to the other core and back |")
    print("|---|---|---|---|---|")
    for scene in sys.argv[2:] or cases:
        case, keys, engines = cases[scene]
        path = case()
        for model, more in engines.items():
            compare(scene, path, model, {**keys, **more}, rounds)


if __name__ == "__main__":
    main()
