#!/usr/bin/env python3
"""Collisions by chance (model dsmc) against hard spheres in the channel: wall times, in turn.

    benches/chance.py [ROUNDS] [CASE ...]

Cases are b, c, d; all of them unless some are named. Each runs for 80 ms on one thread. Prints the wall time of hard spheres over that of dsmc, for the whole loop
and for the engine alone (without drag and statistics): the median with the range over the rounds. Times are multiplied by the share of the core that a process got.
"""
import sys

import measure

KEYS = {"run.duration": "80 ms", "run.average_from": "20 ms"}


def times(case, model):
    """[s] wall time of the loop over windows of a run, and that of its engine, both times the share of the core that the process got."""
    path = measure.ROOT / "cases" / f"channel-{case}.toml"
    run = measure.diptych(path, f"chance-{case}-{model}", model, KEYS)
    share = min(run["share"], 1.0)
    return [share * run["wall_seconds"], share * run["timing"]["engine"]]


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    measure.build()
    print("| case | loop of the run | engine |")
    print("|---|---|---|")
    for case in sys.argv[2:] or ["b", "c", "d"]:
        runs = [[times(case, model) for model in ("hard", "dsmc")] for _ in range(rounds)]
        loop, engine = ([hard[k] / chance[k] for hard, chance in runs] for k in range(2))
        print(f"| {case.upper()} | {measure.spread(loop)} | {measure.spread(engine)} |", flush=True)


if __name__ == "__main__":
    main()
