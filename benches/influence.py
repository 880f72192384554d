#!/usr/bin/env python3
"""Share of the events of dense hard spheres that may depend on both halves of a box, after a short time without exchange.

    benches/influence.py FOLDER

FOLDER holds the results of `diptych run ... --save-state` of equal spheres in a periodic box. The section "Why it has one thread" of
docs/design/hard.md says what is computed: the halves meet at two cuts across x, and influence passes from sphere to sphere through gaps, at twice the
largest speed.
"""
import csv
import heapq
import json
import sys
from pathlib import Path

# [d] gaps up to this one are looked at, more than influence crosses in the longest time below
GAP = 0.3
# [d] spheres up to this distance from a cut are looked at
DEPTH = 4.0
# [d/sqrt(T)]
TIMES = (0.0005, 0.001, 0.002, 0.004)
# [sqrt(T)] largest speed
SPEED = 6.5


def state(folder):
    """Positions and edges of the box, in diameters."""
    lines = [line for line in (folder / "state.csv").read_text().splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    diameter = float(rows[0]["diameter"])
    edges = json.loads((folder / "summary.json").read_text())["variants"][0]["parameters"]["domain"]["size"]
    return [[float(row[axis]) / diameter for axis in "xyz"] for row in rows], [edge / diameter for edge in edges]


def gaps(positions, edges, near):
    """Neighbours of each sphere of `near` with their gaps, by cells."""
    counts = [int(edge / (1 + GAP)) for edge in edges]
    cells = {}
    for i in near:
        cells.setdefault(tuple(int(x / edge * n) % n for x, edge, n in zip(positions[i], edges, counts)), []).append(i)
    around = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
    found = {i: {} for i in near}
    for cell, members in cells.items():
        beside = {tuple((c + s) % n for c, s, n in zip(cell, shift, counts)) for shift in around}
        for j in (j for other in beside for j in cells.get(other, ())):
            for i in members:
                apart = [abs(a - b) for a, b in zip(positions[i], positions[j])]
                gap = sum(min(a, edge - a) ** 2 for a, edge in zip(apart, edges)) ** 0.5 - 1
                if i != j and gap < GAP:
                    found[i][j] = max(gap, 0)
    return found


def influenced(found, half, time):
    """[d/sqrt(T)] time from which the other half may influence each sphere, of those before `time`."""
    first = {}
    for i, neighbours in found.items():
        across = [gap / (2 * SPEED) for j, gap in neighbours.items() if half(i) != half(j)]
        if across and min(across) < time:
            first[i] = min(across)
    queue = [(since, i) for i, since in first.items()]
    heapq.heapify(queue)
    while queue:
        since, i = heapq.heappop(queue)
        for j, gap in found[i].items():
            later = since + gap / (2 * SPEED)
            if since <= first[i] and half(i) == half(j) and later < min(time, first.get(j, time)):
                first[j] = later
                heapq.heappush(queue, (later, j))
    return first


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    positions, edges = state(Path(sys.argv[1]))
    half = lambda i: positions[i][0] > edges[0] / 2
    from_cut = lambda x: min(x, edges[0] - x, abs(x - edges[0] / 2))
    found = gaps(positions, edges, [i for i, (x, _, _) in enumerate(positions) if from_cut(x) < DEPTH])
    print("| time [d/sqrt(T)] | share of the events | bound on the gain from two threads |")
    print("|---|---|---|")
    for time in TIMES:
        first = influenced(found, half, time)
        share = sum(time - since for since in first.values()) / time / len(positions)
        print(f"| {time} | {share:.4f} | {1 / (share + (1 - share) / 2):.2f} |")


if __name__ == "__main__":
    main()
