#!/usr/bin/env python3
"""Does the cost grow linearly? Scenes of the density and agitation of S1 at 11 thousand to 5.6 million particles, one thread.

    benches/scaling.py [ROUNDS] [LARGEST]

The box of peers/s1.toml is scaled along its periodic sides: eight times the particles, sides longer by the square root of
eight. Prints, per engine and size, the cost per particle and simulated second, and the peak memory per particle: first of the
whole process, then only of the memory that grows with the number of particles. Sizes above LARGEST are left out.
"""
import math
import statistics
import sys
from pathlib import Path

import measure

CASE = Path(__file__).resolve().parent / "peers" / "s1.toml"
SMALLEST, FACTOR, SIZES = 10_958, 8, 4  # numbers of particles: an eighth of S1, then three times eight times as many
BOX = (0.120, 0.064)  # [m] edges of the box of S1 along x and z
COUNT = 87_668  # number of particles of S1
WINDOWS = 10  # the first window allocates memory, and takes longer than any other


def run(model, count):
    scale = math.sqrt(count / COUNT)
    # every size has the window of S1, so that the work per particle is the same
    window = 7.5e-4
    keys = {
        "domain.size[0]": f"{BOX[0] * scale!r} m", "domain.size[2]": f"{BOX[1] * scale!r} m", "particles[0].count": count,
        "run.window": f"{window} s", "run.duration": f"{WINDOWS * window} s", "statistics.sample_interval": f"{WINDOWS * window} s",
    }
    variant = measure.diptych(CASE, f"scaling-{model}", model, keys)
    return 1 / measure.rate(variant) / count, variant["peak_memory"], variant["counters"]


def main():
    numbers = [int(word) for word in sys.argv[1:]]
    rounds = numbers[0] if numbers else 3
    largest = numbers[1] if len(numbers) > 1 else SMALLEST * FACTOR ** (SIZES - 1)
    counts = [count for count in (SMALLEST * FACTOR**k for k in range(SIZES)) if count <= largest]
    measure.build()
    for model in ("soft", "hard"):
        print(f"\n{model}: seconds of one core per particle and simulated second, {rounds} rounds")
        print("| particles | s/(particle s), median [range] | over the smallest | bytes per particle | of them growing | pair checks per particle |")
        print("|---|---|---|---|---|---|", flush=True)
        first = None
        before = None
        for count in counts:
            results = [run(model, count) for _ in range(rounds)]
            costs = [cost for cost, _, _ in results]
            memory = max(memory for _, memory, _ in results)
            checks = results[0][2]["pair_checks"] / count
            first = first or statistics.median(costs)
            growing = f"{(memory - before[1]) / (count - before[0]):.0f}" if before else "-"
            before = (count, memory)
            print(f"| {count} | {measure.spread(costs)} | {statistics.median(costs) / first:.2f} "
                  f"| {memory / count:.0f} | {growing} | {checks:.1f} |", flush=True)


if __name__ == "__main__":
    main()
