"""Runs the program and reads all files that it writes. The environment variable DIPTYCH names the program; `python/check` sets everything up."""

import importlib.util
import tempfile
import unittest
from pathlib import Path

import numpy as np
import pandas as pd

import diptych
from diptych import second_opinion
from diptych.results import extended_xyz, table

CASES = Path(__file__).resolve().parents[2] / "cases"
SHORT = {"run.duration": "20 ms", "run.average_from": "0 s", "particles[0].volume_fraction": "2e-3"}


class Everything(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name) / "out"

    def tearDown(self):
        self.temporary.cleanup()

    def test_comparison(self):
        found = diptych.run(CASES / "quick.toml", self.folder, set=SHORT)
        self.assertEqual(list(found.variants.index), ["soft", "hard", "stepped hard"])
        self.assertTrue(found.verdicts)
        profiles = found.profiles
        self.assertEqual(len(profiles), 3 * 15)
        self.assertTrue({"y_m", "U_m_s", "U_se_m_s", "uu_m2_s2", "www_m3_s3", "number_density_ratio"} <= set(profiles.columns))
        # the particles start at 9.5 m/s and the gas is faster
        self.assertTrue(profiles["U_m_s"].dropna().between(9.0, 18.0).all())
        speeds = found.impacts("normal_speed")
        self.assertIn("bin_lower_m_s", speeds.columns)
        self.assertEqual(set(speeds["kind"]) - {"pair", "wall"}, set())
        self.assertIn("granular_temperature_m2_s2", found.overlaps.columns)
        with self.assertRaises(KeyError):
            found.impacts("colour")
        with self.assertRaises(FileNotFoundError):
            _ = found.state

    def test_state_and_impact(self):
        found = diptych.run(CASES / "impact.toml", self.folder, command="run", model="hard", arguments=["--save-state"])
        self.assertEqual(len(found.state), 2)
        self.assertTrue({"x_m", "vz_m_s", "diameter_m", "species"} <= set(found.state.columns))
        # two spheres of 406 um
        self.assertTrue((found.state["diameter_m"] == 4.06e-4).all())
        self.assertEqual(len(diptych.load(self.folder).state), 2)

    @unittest.skipUnless(importlib.util.find_spec("pymbar"), "pymbar is not installed")
    def test_judge_and_a_second_opinion(self):
        # two series of unit variance with an integral correlation time of 10 samples, with the means 5 and 6
        random = np.random.default_rng(1)
        files, series = [], []
        for mean in (5.0, 6.0):
            kicks = random.normal(size=20_000)
            rho = np.exp(-1 / 10)
            values = np.empty_like(kicks)
            values[0] = kicks[0]
            for k in range(1, len(kicks)):
                values[k] = rho * values[k - 1] + np.sqrt(1 - rho**2) * kicks[k]
            file = Path(self.temporary.name) / f"{mean}.csv"
            pd.DataFrame({"t_s": 0.5 * np.arange(len(kicks)), "x": mean + values}).to_csv(file, index=False)
            files.append(file)
            series.append(mean + values)
        found = diptych.judge(files[1], files[0], self.folder, margin="2 %")
        self.assertIn("different", found.verdicts[0])
        for row, values in zip(found.judged.itertuples(), reversed(series)):
            other = second_opinion.average(values, 0.5)
            self.assertAlmostEqual(row.mean, other.mean, delta=0.3 * other.standard_error)
            # an error from 20 to 39 blocks of time is itself known to 12 to 16 %; pymbar's time is known to some 10 %
            self.assertAlmostEqual(row.mean_se / other.standard_error, 1.0, delta=0.5)
            self.assertAlmostEqual(row.correlation_time / other.correlation_time, 1.0, delta=0.8)
            self.assertAlmostEqual(other.correlation_time / 5.0, 1.0, delta=0.3)
        with self.assertRaises(diptych.InputError):
            diptych.judge(files[0], "none.csv", self.folder / "other")

    def test_over_time(self):
        every = ["--every", "5 ms", "--save-state"]
        short = {"run.duration": "20 ms", "output.format": "both"}
        found = diptych.run(CASES / "beads-in-air.toml", self.folder, command="run", set=short, arguments=every)
        series = found.series
        self.assertTrue({"variant", "t_s", "granular_temperature_m2_s2", "kinetic_energy_J", "pair_impacts"} <= set(series.columns))
        self.assertEqual(series["t_s"].iloc[0], 0.0)
        self.assertAlmostEqual(series["t_s"].iloc[-1], 0.02)
        with self.assertRaises(FileNotFoundError):
            _ = found.paths
        # all bits of both formats, and of the state at the end
        both = found.trajectory
        columns = ["x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "radius_m", "overlap_m", "species", "contacts", "solver", "id"]
        texts = pd.concat([extended_xyz(path) for path in sorted(self.folder.glob("trajectory/*/*.xyz"))], ignore_index=True)
        texts["species"] = texts["type"] - 1
        self.assertEqual((len(both), sorted(both["frame"].unique())), (5 * 200, [0, 1, 2, 3, 4]))
        self.assertTrue((both[columns] == texts[columns]).all(axis=None))
        last = both[both["frame"] == 4].reset_index(drop=True)
        shared = ["x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s"]
        self.assertTrue((last[shared] == found.state[shared]).all(axis=None))
        self.assertTrue((2 * last["radius_m"] == found.state["diameter_m"]).all())
        # alone they are read as well
        for path in self.folder.glob("trajectory/*/*.vtp"):
            path.unlink()
        again = diptych.load(self.folder).trajectory
        self.assertTrue((again[columns] == both[columns]).all(axis=None))

    def test_paths_of_a_few(self):
        found = diptych.run(CASES / "impact.toml", self.folder, arguments=["--every", "1 us"])
        self.assertTrue({"variant", "t_s", "id", "x_m", "vz_m_s", "overlap_m"} <= set(found.paths.columns))
        variants = found.variants.index
        self.assertEqual(set(found.paths["variant"]), set(variants))
        # variants have the same times
        self.assertEqual(found.trajectory["variant"].nunique(), len(variants))
        self.assertEqual(found.trajectory.groupby("variant")["frame"].nunique().nunique(), 1)

    def test_what_is_wrong_is_said(self):
        with self.assertRaises(diptych.InputError) as raised:
            diptych.run(CASES / "impact.toml", self.folder, set={"contact.restitution": 2})
        self.assertIn("restitution", str(raised.exception))
        with self.assertRaises(FileNotFoundError):
            diptych.load(self.folder)
        # a column that stands on the floor is nothing for hard spheres
        with self.assertRaises(diptych.RunError) as raised:
            diptych.run(CASES / "column.toml", self.folder, command="run", model="hard")
        self.assertIn("collapse", str(raised.exception))
        self.assertEqual(raised.exception.results.variants["status"].iloc[0], "failed")

    def test_files_of_others(self):
        self.folder.mkdir()
        state = self.folder / "state.csv"
        state.write_text("# time: 0.5 s\n# count: 1\nid,x,vx,t_s\n0,1e-3,0.1,2\n")
        read = table(state)
        self.assertEqual((read.attrs["time"], list(read.columns)), ("0.5 s", ["id", "x_m", "vx_m_s", "t_s"]))
        path = self.folder / "t.xyz"
        frame = '1\nLattice="1 0 0 0 1 0 0 0 1" Properties=species:S:1:pos:R:3:velo:R:3:id:I:1 Time={}\nglass 1 2 3 4 5 6 7\n'
        path.write_text(frame.format(0.0) + frame.format(0.5))
        read = extended_xyz(path)
        self.assertEqual(list(read["t_s"]), [0.0, 0.5])
        self.assertEqual(read[["x_m", "vz_m_s", "id"]].iloc[1].tolist(), [1.0, 6.0, 7.0])


if __name__ == "__main__":
    unittest.main()
