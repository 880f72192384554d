"""Scenes from dicts and starts from arrays: bits, sizes, kinds, messages."""

import unittest
import warnings
from pathlib import Path

import numpy as np

import diptych
from diptych import scenes

TEXT = """
[domain]
size = ["4 mm", "4 mm", "4 mm"]
periodic = ["x", "z"]
[[particles]]
diameter = "200 um"
density = "2500 kg/m^3"
count = 30
velocity_fluctuation = "0.2 m/s"
[[walls]]
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
restitution = 0.9
friction = 0
[[walls]]
plane = { point = ["0 m", "4 mm", "0 m"], normal = [0, -1, 0] }
restitution = 0.9
friction = 0
[contact]
restitution = 0.9
friction = 0
[run]
duration = "10 ms"
"""
WALLS = [{"plane": {"point": [0, y, 0], "normal": [0, sign, 0]}, "restitution": 0.9, "friction": 0} for y, sign in ((0, 1), (4e-3, -1))]
SCENE = {
    "domain": {"size": ["4 mm", 4e-3, np.float64(4e-3)], "periodic": ("x", "z")},
    "particles": [{"diameter": 2e-4, "density": 2500, "count": np.int64(30), "velocity_fluctuation": "0.2 m/s"}],
    "walls": WALLS,
    "contact": {"restitution": 0.9, "friction": 0},
    "gravity": None,
    "run": {"duration": 0.01},
}
PLACES = np.array([[1e-3, 1e-3, 1e-3], [2e-3, 1e-3, 1e-3], [1e-3, 3e-3, 1 / 3 * 1e-3]])
SPEEDS = np.array([[0.1, 0, 0], [0, np.pi / 10, 0], [0, 0, -0.3]])


def with_particles(*kinds):
    return {**SCENE, "particles": list(kinds)}


class Dicts(unittest.TestCase):
    def test_a_dict_has_the_bits_of_its_case(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            made = diptych.Simulation(SCENE, model="hard")
        read = diptych.Simulation(text=TEXT, model="hard")
        changed = diptych.Simulation(SCENE, model="hard", set={"contact.restitution": 0.5})
        for simulation in (made, read, changed):
            simulation.run_until(simulation.duration)
        self.assertGreater(made.wall_impacts, 10)
        self.assertTrue(made.state().equals(read.state()))
        self.assertFalse(made.state().equals(changed.state()))

    def test_errors_name_the_key(self):
        for change, words in (
            ({"run": {"duration": "2 parsec"}}, "`run.duration`"),
            ({"run": {"duration": 1, "windw": 1}}, "did you mean `window`"),
            ({"contact": {"restitution": 2}}, "`contact.restitution` = 2"),
            ({"particles": [{**SCENE["particles"][0], "density": object()}]}, "`particles[0].density` = <object"),
            ({"domain": {"size": [1, 1, float("nan")]}}, "`domain.size[2]` = nan"),
        ):
            with self.assertRaises(diptych.InputError) as raised:
                diptych.Simulation({**SCENE, **change}, model="hard")
            self.assertIn(words, str(raised.exception))

    def test_texts_survive(self):
        name = "a \"b\" \n\\ \u00e9"
        simulation = diptych.Simulation(with_particles({**SCENE["particles"][0], "name": name}), model="hard")
        self.assertEqual(simulation.species_names, [name])


class Starts(unittest.TestCase):
    def test_arrays_are_the_start_with_all_their_bits(self):
        simulation = diptych.Simulation(SCENE, model="hard", positions=PLACES, velocities=SPEEDS)
        order = np.argsort(simulation.ids)
        self.assertTrue((simulation.positions[order] == PLACES).all())
        self.assertTrue((simulation.velocities[order] == SPEEDS).all())
        self.assertTrue((simulation.radii == 1e-4).all())
        # arrays also replace the start that a case gives
        of_text = diptych.Simulation(text=TEXT, model="hard", positions=PLACES, velocities=SPEEDS)
        self.assertTrue(of_text.state().equals(simulation.state()))
        region = 'in.box = { center = ["2 mm", "2 mm", "2 mm"], half_extents = ["1 mm", "1 mm", "1 mm"] }'
        of_region = diptych.Simulation(
            text=TEXT.replace("count = 30", "count = 30\n" + region), model="hard", positions=PLACES, velocities=SPEEDS
        )
        self.assertTrue(of_region.state().equals(simulation.state()))
        at_rest = diptych.Simulation(SCENE, model="soft", set={"soft.linear_spring_dashpot.stiffness": "1 kN/m"}, positions=PLACES)
        self.assertEqual(at_rest.kinetic_energy, 0.0)

    def test_radii_are_the_sizes_of_a_kind_without_any(self):
        kind = {"density": 2500}
        for radii in ([1e-4, 1e-4, 1e-4], [1e-4, 1.5e-4, 1.25e-4]):
            simulation = diptych.Simulation(with_particles(kind), model="hard", positions=PLACES, radii=radii)
            self.assertTrue((simulation.radii[np.argsort(simulation.ids)] == radii).all())
        with self.assertRaises(diptych.InputError) as raised:
            diptych.Simulation(SCENE, model="hard", positions=PLACES, radii=[1e-4, 1e-4, 2e-4])
        self.assertIn("`diameter` = 4e-4 m", str(raised.exception))

    def test_kinds_are_named_or_numbered(self):
        kinds = [{"name": "small", "density": 2500}, {"name": "large", "density": 1000}]
        radii = [1e-4, 2e-4, 1e-4]
        for species in (["small", "large", "small"], [0, 1, 0]):
            simulation = diptych.Simulation(with_particles(*kinds), model="hard", positions=PLACES, radii=radii, species=species)
            state = simulation.state()
            self.assertEqual(state["radius_m"].tolist(), [1e-4, 1e-4, 2e-4])
            self.assertEqual(state["species"].tolist(), [0, 0, 1])
        with self.assertRaises(diptych.InputError) as raised:
            diptych.Simulation(with_particles(*kinds), model="hard", positions=PLACES, radii=radii)
        self.assertIn("`species` is not given", str(raised.exception))
        with self.assertRaises(diptych.InputError) as raised:
            diptych.Simulation(with_particles(*kinds), model="hard", positions=PLACES, radii=radii, species=["small", "large", "lrge"])
        self.assertIn("did you mean `large`", str(raised.exception))

    def test_what_is_wrong_in_an_array_is_refused(self):
        for arrays, words in (
            ({"positions": PLACES[:, :2]}, "`positions` has the shape (3, 2)"),
            ({"positions": PLACES, "velocities": SPEEDS[:2]}, "`velocities` has the shape (2, 3)"),
            ({"positions": PLACES, "species": [0]}, "`species` has 1 entries for 3"),
            ({"positions": "here"}, "`positions` is no array"),
            ({"positions": PLACES * [1, 1, np.nan]}, "`z` = \"nan\" is not a finite number"),
            ({"positions": PLACES + [0, 2e-3, 0]}, "outside the domain"),
            ({"positions": PLACES * [0.01, 1, 1]}, "particle 1"),
        ):
            with self.assertRaises(diptych.InputError) as raised:
                diptych.Simulation(SCENE, model="hard", **arrays)
            self.assertIn(words, str(raised.exception))
        with self.assertRaises(TypeError):
            diptych.Simulation(SCENE, model="hard", place=PLACES)

    def test_the_text_is_toml(self):
        self.assertEqual(scenes.case_text({"a b": {"c": [True, 1, 2.5, "d"]}}), '"a b" = {c = [true, 1, 2.5, "d"]}\n')


if __name__ == "__main__":
    unittest.main()
