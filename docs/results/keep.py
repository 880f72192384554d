#!/usr/bin/env python3
"""Stores what pages cite of a comparison: keep.py FOLDER_OF_RESULTS FOLDER_HERE.

Of summary.json the sentences, the judged differences and a few numbers of each variant are kept, and the picture of the
differences, on white so that it can be seen on dark pages.
"""

import json
import re
import sys
from pathlib import Path

source, target = map(Path, sys.argv[1:])
target.mkdir(parents=True, exist_ok=True)
summary = json.loads((source / "summary.json").read_text())
of_variant = ["name", "model", "status", "particles", "pair_impacts", "wall_impacts", "simulated_seconds", "wall_seconds",
              "granular_temperature", "momentum_balance", "set"]
kept = {key: summary[key] for key in ["title", "case", "command", "status", "versions", "verdict", "verdicts", "seed"]}
kept["variants"] = [{key: variant[key] for key in of_variant} for variant in summary["variants"]]
kept["comparisons"] = [{key: one[key] for key in ["variant", "reference", "verdict", "sentence", "comparison"]}
                       for one in summary["comparisons"]]
(target / "summary.json").write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n")
picture = (source / "figures" / "differences-in-per-cent.svg").read_text()
white = '<rect width="100%" height="100%" fill="#ffffff"></rect>'
(target / "differences-in-per-cent.svg").write_text(re.sub(r"(<svg[^>]*>)", r"\1" + white, picture, count=1) + "\n")
