#!/usr/bin/env python3
"""Two threads against one, on case D from its settled start, for each engine: wall times, in turn.

    benches/threads.py [ROUNDS]

The machine must be quiet on both cores. Prints the ratio of wall times in each round; the states at the end must be the same bits.
"""
import statistics
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "peers"))
import measure
import scenes


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    measure.build()
    case = scenes.settled(scenes.D)
    print("| engine | wall time of 1 thread over 2, median [range] | s per simulated second, 2 threads | cores held |")
    print("|---|---|---|---|")
    for model, keys in (("soft", {"soft.stepping": "local"}), ("hard", {})):
        one, two = [], []
        for _ in range(rounds):
            for threads, runs in ((1, one), (2, two)):
                runs.append(measure.diptych(case, f"threads-{model}", model, keys, threads))
        if len({run["final_state_hash"] for run in one + two}) != 1:
            sys.exit(f"{model}: the final state depends on the number of threads")
        ratios = [a["wall_seconds"] / b["wall_seconds"] for a, b in zip(one, two)]
        cost = [run["wall_seconds_per_simulated_second"] for run in two]
        held = statistics.median(run["share"] for run in two)
        print(f"| {model} | {measure.spread(ratios)} | {measure.spread(cost, '.4g')} | {held:.2f} |", flush=True)


if __name__ == "__main__":
    main()
