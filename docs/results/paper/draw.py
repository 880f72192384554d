#!/usr/bin/env python3
"""Draws the pictures of docs/paper.md that no single run holds, from the tables of collect.py.

    docs/results/paper/draw.py FOLDER

FOLDER holds verdicts.csv and stiffness.csv. Writes margins.svg (margin reached by each observable of each case) and stiffness.svg (case D, soft less hard over
kappa_n, beside the law) next to it. Only the standard library is needed.
"""

import csv
import math
import pathlib
import sys

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]
CASES = ["B", "C", "D", "E", "F", "G"]


class Panel:
    """A picture with two linear or logarithmic axes."""

    def __init__(self, x, y, labels, log=(False, False), size=(640, 380)):
        self.range, self.log, self.size, self.parts = (x, y), log, size, []
        self.left, self.right, self.top, self.bottom = 70, size[0] - 16, 12, size[1] - 92
        self.axes(labels)

    def at(self, which, value):
        low, high = self.range[which]
        if self.log[which]:
            low, high, value = math.log(low), math.log(high), math.log(value)
        share = (value - low) / (high - low)
        return self.left + share * (self.right - self.left) if which == 0 else self.bottom - share * (self.bottom - self.top)

    def ticks(self, which):
        low, high = self.range[which]
        if self.log[which]:
            decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
            return [m * 10.0**k for k in decades for m in (1, 2, 5) if low <= m * 10.0**k <= high * 1.0001]
        raw = (high - low) / 6
        unit = 10 ** math.floor(math.log10(raw))
        step = next(m * unit for m in (1, 2, 5, 10) if m * unit >= raw)
        return [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]

    def axes(self, labels):
        for which in (0, 1):
            for tick in self.ticks(which):
                place, name = self.at(which, tick), f"{tick:.6g}".replace("-", "−")
                if which == 0:
                    self.line((place, self.top), (place, self.bottom), "#e6e6e6", 1)
                    self.text(place, self.bottom + 17, name, "middle")
                else:
                    self.line((self.left, place), (self.right, place), "#e6e6e6", 1)
                    self.text(self.left - 6, place + 4, name, "end")
        self.line((self.left, self.bottom), (self.right, self.bottom), "#333", 1)
        self.line((self.left, self.top), (self.left, self.bottom), "#333", 1)
        self.text((self.left + self.right) / 2, self.bottom + 38, labels[0], "middle", 15)
        middle = (self.top + self.bottom) / 2
        turn = f' transform="rotate(-90 18 {middle:.0f})"'
        self.text(18, middle, labels[1], "middle", 15, turn)

    def line(self, start, end, colour, width, dash=""):
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        ends = f'x1="{start[0]:.1f}" y1="{start[1]:.1f}" x2="{end[0]:.1f}" y2="{end[1]:.1f}"'
        self.parts.append(f'<line {ends} stroke="{colour}" stroke-width="{width}"{dash}/>')

    def text(self, x, y, words, anchor, size=13, more=""):
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}"{more}>{words}</text>')

    def curve(self, points, colour, dash=""):
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        path = " ".join(f"{self.at(0, x):.1f},{self.at(1, y):.1f}" for x, y in points)
        self.parts.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6"{dash}/>')

    def mark(self, x, y, colour, error=None, square=False):
        px, py = self.at(0, x), self.at(1, y)
        if error:
            self.line((px, self.at(1, y - error)), (px, self.at(1, y + error)), colour, 1.4)
        if square:
            self.parts.append(f'<rect x="{px - 3:.1f}" y="{py - 3:.1f}" width="6" height="6" fill="{colour}"/>')
        else:
            self.parts.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" r="3" fill="{colour}"/>')

    def legend(self, entries):
        width = (self.right - self.left) / 3
        for k, (words, colour, kind) in enumerate(entries):
            x, y = self.left + width * (k % 3), self.bottom + 58 + 18 * (k // 3)
            if kind == "line":
                self.line((x, y - 4), (x + 16, y - 4), colour, 2)
            elif kind == "dash":
                self.line((x, y - 4), (x + 16, y - 4), colour, 2, "5 3")
            elif kind == "square":
                self.parts.append(f'<rect x="{x + 5:.1f}" y="{y - 7:.1f}" width="6" height="6" fill="{colour}"/>')
            else:
                self.parts.append(f'<circle cx="{x + 8:.1f}" cy="{y - 4:.1f}" r="3.5" fill="{colour}"/>')
            self.text(x + 22, y, words, "start")

    def write(self, path):
        width, height = self.size
        head = f'<svg viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        head += 'font-family="Helvetica, Arial, sans-serif"><rect width="100%" height="100%" fill="white"/>'
        pathlib.Path(path).write_text(head + "".join(self.parts) + "</svg>\n")
        print(path)


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def margins(folder):
    """The margin reached by every observable of the six cases."""
    names = ["number_density_ratio", "U", "uu", "vv", "ww", "uv", "granular temperature", "pair impacts per time", "wall impacts per time"]
    short = ["n", "U", "uu", "vv", "ww", "uv", "T", "pairs", "walls"]
    rows = table(folder / "verdicts.csv")
    panel = Panel((0, 9), (0.01, 5), ("averages; pairs, walls: impacts per time", "margin reached  [% of the scale]"), (False, True))
    panel.parts = [part for part in panel.parts if not (part.startswith("<text") and f'y="{panel.bottom + 17:.1f}"' in part)]
    panel.curve([(0, 1), (9, 1)], "#333", "6 4")
    for k, name in enumerate(names):
        panel.text(panel.at(0, k + 0.5), panel.bottom + 17, short[k], "middle")
        for place, case in enumerate(CASES):
            found = [r for r in rows if r["run"] == f"case-{case.lower()}" and r["observable"] == name]
            for row in found:
                panel.mark(k + 0.2 + 0.12 * place, 100 * float(row["margin_reached"]), COLOURS[place])
    known = {row["run"] for row in rows}
    named = [(f"case {case}", COLOURS[place], "dot") for place, case in enumerate(CASES) if f"case-{case.lower()}" in known]
    panel.legend(named)
    panel.write(folder / "margins.svg")


def turned(impact, depth):
    """sin² of the angle by which two soft spheres of diameter 1 turn, at an impact parameter and depth a = u sqrt(M/k)."""
    root = lambda r: 1 - impact**2 / r**2 - (1 - r) ** 2 / depth**2
    low, high = max(1 - depth, 1e-9), 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if root(middle) > 0 else (middle, high)
    turning, steps, angle = high, 200, 0.0
    for k in range(steps):
        s = (k + 0.5) / steps
        r = turning + (1 - turning) * s * s
        angle += impact / (r * r * math.sqrt(max(root(r), 1e-15))) * 2 * (1 - turning) * s / steps
    return math.sin(math.pi - 2 * math.asin(impact) - 2 * angle) ** 2


def omega(kappa):
    """The collision integral of a linear spring over that of hard spheres (docs/theory/softness.md)."""
    softness, total = kappa * math.sqrt(math.pi / 2), 0.0
    for i in range(40):
        gamma = (i + 0.5) / 10
        depth = math.sqrt(2) * gamma * softness
        section = sum(turned(b, depth) * b for b in ((k + 0.5) / 60 for k in range(60))) / 60
        total += gamma**7 * math.exp(-gamma * gamma) * section / 10
    return total


def stiffness(folder):
    """Case D: normal stresses of soft spheres less those of hard ones over kappa_n, and the law that follows from the collision integral."""
    rows = table(folder / "stiffness.csv")
    panel = Panel((0.002, 0.06), (-3, 4), ("κ_n  [–]", "soft less hard  [% of the stress]"), (True, False))
    # of hard spheres [m²/s²]
    hard = {"uu": 0.2084, "vv": 0.1539, "ww": 0.1578}
    anisotropy = hard["uu"] - 0.5 * (hard["vv"] + hard["ww"])
    kappas = [0.002 * 30 ** (k / 14) for k in range(15)]
    more = [(kappa, anisotropy * (1 / omega(kappa) - 1)) for kappa in kappas]
    for place, (name, share) in enumerate([("uu", 2 / 3), ("vv", -1 / 3), ("ww", -1 / 3)]):
        panel.curve([(kappa, 100 * share * extra / hard[name]) for kappa, extra in more], COLOURS[place])
        for row in rows:
            kappa = float(row["kappa_n"]) * (1 + 0.02 * (place - 1))
            panel.mark(kappa, float(row[name + "_percent"]), COLOURS[place], float(row[name + "_se"]))
    names = [(name, COLOURS[place], "dot") for place, name in enumerate(["uu, measured", "vv", "ww"])]
    panel.legend(names + [("lines: by Ω, the same T", "#333", "line")])
    panel.write(folder / "stiffness.svg")


def main():
    folder = pathlib.Path(sys.argv[1])
    margins(folder)
    stiffness(folder)


if __name__ == "__main__":
    main()
