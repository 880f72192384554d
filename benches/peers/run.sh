#!/usr/bin/env bash
# Soft spheres beside LAMMPS on the same start, one thread each on one core, in turn; prints ratios, never bare times.
# Needs the Debian packages lammps and python3:  apt-get install lammps python3
#   benches/peers/run.sh [RUNS]
set -euo pipefail
cd "$(dirname "$0")/../.."
runs=${1:-5}
command -v lmp >/dev/null || { echo "lmp is not here: apt-get install lammps" >&2; exit 2; }
cargo build --release --locked --quiet
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
bin=target/release/diptych
case=benches/peers/s1.toml
one() { taskset -c 0 "$@"; }

# the common start: our initial state, as a data file
"$bin" run "$case" --set run.duration="0 s" --save-state --quiet --out "$work/start"
python3 - "$work/start/state.csv" "$work/start.data" <<'PY'
import csv, sys
rows = list(csv.DictReader(open(sys.argv[1])))
with open(sys.argv[2], "w") as f:
    f.write(f"start\n\n{len(rows)} atoms\n1 atom types\n\n0 0.12 xlo xhi\n0 0.04 ylo yhi\n0 0.064 zlo zhi\n\nAtoms\n\n")
    for k, r in enumerate(rows, 1):
        f.write(f"{k} 1 {r['diameter']} 1038 {r['x']} {r['y']} {r['z']}\n")
    f.write("\nVelocities\n\n")
    for k, r in enumerate(rows, 1):
        f.write(f"{k} {r['vx']} {r['vy']} {r['vz']} 0 0 0\n")
PY

# simulated seconds per wall second of each
ours() { # name, settings...
    one "$bin" run "$case" --threads 1 --quiet --overwrite --out "$work/$1" "${@:2}"
    python3 -c "import json; v = json.load(open('$work/$1/summary.json'))['variants'][0]; print(v['simulated_seconds'] / v['wall_seconds'])" >> "$work/$1.rates"
}
steps=4000
theirs() {
    one lmp -in benches/peers/soft.lmp -var data "$work/start.data" -var steps $steps -log "$work/lammps.log" -screen none
    python3 -c "import re; t = re.findall(r'Loop time of ([0-9.e+-]+)', open('$work/lammps.log').read()); print($steps * 7.5e-7 / float(t[-1]))" >> "$work/lammps.rates"
}
for _ in $(seq "$runs"); do
    theirs
    ours uniform --set soft.time_step="7.5e-7 s" --set soft.stepping=uniform
    ours local --set soft.steps_per_contact=20 --set soft.stepping=local
    ours hard --model hard
done
python3 - "$work" "$(lmp -h | grep -m1 -o 'Simulator - .*')" <<'PY'
import statistics, sys
rates = lambda name: [float(x) for x in open(f"{sys.argv[1]}/{name}.rates")]
lammps = rates("lammps")
print(f"simulated time per wall time over that of LAMMPS ({sys.argv[2]}), one thread each, {len(lammps)} runs in turn:")
for name in ["uniform", "local", "hard"]:
    ratio = sorted(a / b for a, b in zip(rates(name), lammps))
    print(f"  {name:8} median {statistics.median(ratio):6.2f}   [{ratio[0]:.2f} - {ratio[-1]:.2f}]")
PY
