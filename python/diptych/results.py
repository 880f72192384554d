"""Loads a folder that diptych has written."""

import json
import re
from functools import cached_property
from io import StringIO
from pathlib import Path

import numpy as np
import pandas as pd

#: Units of the columns whose names in the files are symbols. The names of all other columns end with their units.
UNITS = {
    "m": ["x", "y", "z", "diameter", "radius", "overlap"],
    "m_s": ["vx", "vy", "vz", "U", "V", "W"],
    "m2_s2": ["uu", "vv", "ww", "uv", "uw", "vw", "granular_temperature", "rotational_temperature", "Rxx", "Ryy", "Rzz"],
    "m3_s3": ["uuu", "uuv", "uuw", "uvv", "uvw", "uww", "vvv", "vvw", "vww", "www"],
    "rad_s": ["mean_spin_x", "mean_spin_y", "mean_spin_z"],
    "s": ["Time", "t"],
}
UNIT_OF = {name: unit for unit, names in UNITS.items() for name in names}

#: Units in summary.json and impacts.csv, and the same units as they are written in column names.
IN_NAMES = {"m/s": "m_s", "m²/s²": "m2_s2", "1/s": "per_s", "rad/s": "rad_s", "1": "", "": ""}

#: Columns of the components of a vector of a trajectory, by its name in extended XYZ or VTK.
VECTORS = {"pos": ["x", "y", "z"], "Points": ["x", "y", "z"], "velo": ["vx", "vy", "vz"], "velocity": ["vx", "vy", "vz"], "vel": ["vx", "vy", "vz"]}


def with_unit(name: str) -> str:
    """Name of a column with its unit: U -> U_m_s, uu_se -> uu_se_m2_s2. Names that are not in `UNITS` are unchanged."""
    quantity = name.removesuffix("_se")
    return f"{name}_{UNIT_OF[quantity]}" if quantity in UNIT_OF else name


def table(path: Path) -> pd.DataFrame:
    """Table of a CSV file. The values in lines `# key: value` above the table are in `attrs`."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    above = 0
    while above < len(lines) and lines[above].startswith("#"):
        above += 1
    # pandas 3 reads every digit of a number by default, older versions only with this option
    exact = {"float_precision": "round_trip"} if int(pd.__version__.split(".")[0]) < 3 else {}
    read = pd.read_csv(StringIO("\n".join(lines[above:])), **exact)
    read.columns = [with_unit(re.sub(r"\s*\[.*\]$", "", str(name))) for name in read.columns]
    pairs = (line.lstrip("# ").split(":", 1) for line in lines[:above])
    read.attrs = {pair[0].strip(): pair[1].strip() for pair in pairs if len(pair) == 2}
    return read


#: Types of numbers: names in VTK, and in numpy.
NUMBERS = {"Float64": "<f8", "Int32": "<i4", "UInt32": "<u4", "UInt16": "<u2", "UInt8": "u1"}


def vtk_points(path: Path) -> pd.DataFrame:
    """Table of the points of a VTK file that diptych has written (arrays of raw bytes behind a header), with all bits of the numbers."""
    data = path.read_bytes()
    end = data.index(b'<AppendedData encoding="raw">')
    header, begin = data[:end].decode("utf-8"), data.index(b"_", end) + 1
    columns = {"t_s": float(re.search(r'Name="TimeValue"[^>]*>([^<]*)<', header)[1])}
    array = r'<DataArray type="(\w+)" Name="(\w+)" NumberOfComponents="(\d+)" format="appended" offset="(\d+)"/>'
    for kind, name, width, offset in re.findall(array, header):
        if name in ("connectivity", "offsets"):
            continue
        start, number = begin + int(offset), np.dtype(NUMBERS[kind])
        count = int.from_bytes(data[start : start + 8], "little") // number.itemsize
        values = np.frombuffer(data, number, count, start + 8).reshape(-1, int(width))
        for part, values in zip(VECTORS.get(name, [name]), values.T):
            columns[with_unit(part)] = values
    return pd.DataFrame(columns)


def extended_xyz(path: Path) -> pd.DataFrame:
    """Table of a trajectory in extended XYZ, with all frames one after the other. Column `frame` numbers the frames, `t_s` has their times."""
    frames = []
    with path.open(encoding="utf-8") as lines:
        for number, count in enumerate(lines):
            about = dict(re.findall(r'(\w+)=("[^"]*"|\S+)', next(lines)))
            rows = [next(lines).split() for _ in range(int(count))]
            columns = {"frame": np.full(len(rows), number), "t_s": np.full(len(rows), _time(about))}
            properties = about["Properties"].strip('"').split(":")
            place = 0
            for name, kind, width in zip(properties[::3], properties[1::3], map(int, properties[2::3])):
                names = VECTORS.get(name, [name] if width == 1 else [f"{name}_{k}" for k in range(width)])
                for offset, part in enumerate(names):
                    cells = [row[place + offset] for row in rows]
                    columns[with_unit(part)] = cells if kind == "S" else np.array(cells, dtype=int if kind == "I" else float)
                place += width
            frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True)


def _time(about: dict) -> float:
    found = next((value for name, value in about.items() if name.lower() in ("time", "t_s", "time_s")), "nan")
    return float(found.strip('"').split()[0])


class Results:
    """Results that a command has written to a folder. A table is read when its attribute is used. If its file does not exist,
    FileNotFoundError is raised with a hint."""

    def __init__(self, folder):
        self.folder = Path(folder)
        if not (self.folder / "summary.json").is_file():
            raise FileNotFoundError(f"{self.folder} holds no results: there is no summary.json")

    def _table(self, name: str, hint: str) -> pd.DataFrame:
        path = self.folder / name
        if not path.is_file():
            raise FileNotFoundError(f"{path} is not there: {hint}")
        return table(path)

    @cached_property
    def summary(self) -> dict:
        """Contents of summary.json. Its keys end with units."""
        return json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))

    @property
    def verdicts(self) -> list[str]:
        """Sentences that the command has printed at its end."""
        return self.summary["verdicts"]

    @cached_property
    def variants(self) -> pd.DataFrame:
        """Table with one row per variant (experiment of a case). Column names are keys of summary.json; nested keys are joined by a dot."""
        return pd.json_normalize(self.summary["variants"]).set_index("name")

    @cached_property
    def profiles(self) -> pd.DataFrame:
        """Averages over slices of the box across y, and their standard errors (columns with `_se_`)."""
        return self._table("profiles.csv", "`diptych run` and `compare` write it")

    @cached_property
    def overlaps(self) -> pd.DataFrame:
        """Overlaps of the variants with soft spheres, and the overlap number kappa_n."""
        return self._table("overlaps.csv", "`diptych run` and `compare` write it")

    def impacts(self, quantity: str) -> pd.DataFrame:
        """Histogram of the impacts of all variants; `quantity` is "normal_speed", "maximum_overlap", "first_overlap", "restitution" or "duration"."""
        everything = self._table("impacts.csv", "`diptych run` and `compare` write it")
        chosen = everything[everything["quantity"] == quantity]
        if chosen.empty:
            raise KeyError(f"no {quantity!r} in impacts.csv; there are {sorted(everything['quantity'].unique())}")
        unit = str(chosen["unit"].iloc[0])
        unit = IN_NAMES.get(unit, unit)
        end, per = (f"_{unit}", f"_per_{unit}") if unit else ("", "")
        names = {"bin_lower": f"bin_lower{end}", "bin_upper": f"bin_upper{end}", "probability_density": f"probability_density{per}"}
        return chosen.drop(columns=["quantity", "unit"]).rename(columns=names).reset_index(drop=True)

    @cached_property
    def series(self) -> pd.DataFrame:
        """Averages over all particles as functions of time, of every variant."""
        return self._table("series.csv", "this version or this command does not write it")

    @cached_property
    def paths(self) -> pd.DataFrame:
        """Positions and velocities of each particle as functions of time, in scenes of up to 50 particles."""
        return self._table("paths.csv", "it is written for scenes of up to 50 particles")

    @cached_property
    def judged(self) -> pd.DataFrame:
        """Means, errors and correlation times of both sides of a comparison by `diptych judge`."""
        return self._table("judge.csv", "`diptych judge` writes it")

    @cached_property
    def state(self) -> pd.DataFrame:
        """Particles at the end of the run."""
        return self._table("state.csv", "run with arguments=['--save-state']")

    @cached_property
    def trajectory(self) -> pd.DataFrame:
        """Particles of all variants at every time for which the table [output] of the case asks. `frame` numbers these times."""
        for pattern, read in (("*/*.vtp", vtk_points), ("*/*.xyz", extended_xyz)):
            files = sorted((self.folder / "trajectory").glob(pattern))
            if files:
                return pd.concat([_frame(path, read(path)) for path in files], ignore_index=True)
        raise FileNotFoundError(f"no trajectory in {self.folder}: run with arguments=['--every', '1 ms']")


def _frame(path: Path, read: pd.DataFrame) -> pd.DataFrame:
    """Frame of either format, with columns for its variant and number. Extended XYZ numbers species from 1, this table from 0."""
    if "type" in read.columns:
        read["species"] = read.pop("type") - 1
    first = ["variant", "frame", "t_s", "id"]
    read = read.assign(variant=path.parent.name, frame=int(path.stem))
    return read[first + [name for name in read.columns if name not in first]]


def load(folder) -> Results:
    """Results that a command has written to a folder."""
    return Results(folder)
