"""A drag law in Python: order of the error in the window, balances of energy and momentum, bits, exceptions, messages."""

import gc
import math
import unittest
import weakref
from pathlib import Path

import numpy as np

import diptych

CASES = Path(__file__).resolve().parents[2] / "cases"
DENSITY, VISCOSITY, PARTICLE, DIAMETER = 1.2, 1.5e-5, 1000.0, 1e-4  # kg/m^3, m^2/s, kg/m^3, m
TAU = PARTICLE * DIAMETER**2 / (18 * DENSITY * VISCOSITY)  # s, Stokes
WIND = np.array([0.0, 0.0, 3.0])  # m/s
SCENE = {
    "domain": {"size": [0.1, 0.1, 0.1], "periodic": ["x", "y", "z"]},
    "fluid": {"density": DENSITY, "kinematic_viscosity": VISCOSITY, "profile": {"uniform": {"velocity": WIND[2]}}},
    "particles": [{"name": "bead", "diameter": DIAMETER, "density": PARTICLE}],
    "contact": {"restitution": 0.9, "friction": 0},
}


def stokes(now):
    return (WIND - now.velocities) / TAU


def beads(windows: int, drag=None, positions=((0.05, 0.05, 0.05),), velocities=((1.0, -2.0, 0.0),), **options):
    """Simulation of beads in a wind that lasts one response time, in `windows` windows."""
    scene = {**SCENE, "run": {"duration": TAU, "window": TAU / windows}, **({"drag": {"stokes": {}}} if drag is None else {})}
    simulation = diptych.Simulation(scene, model="hard", positions=positions, velocities=velocities, **options)
    simulation.drag = drag
    return simulation


def gas(drag, **options):
    simulation = diptych.Simulation("cooling-gas", model="hard", set={"run.duration": "1 ms", "run.window": "50 us"}, **options)
    simulation.drag = drag
    return simulation


class Scheme(unittest.TestCase):
    def test_the_error_is_the_derived_one_of_second_order(self):
        exact = beads(20)
        exact.run_until(TAU)
        slip = exact.velocities - WIND
        # the drag of the case is exact for a constant gas, whatever the windows are
        self.assertTrue(np.allclose(slip, math.exp(-1) * (np.array([1.0, -2.0, 0.0]) - WIND), rtol=1e-12))
        for windows in (10, 20, 40):
            found = beads(windows, stokes)
            found.run_until(TAU)
            error = (found.velocities - WIND) / slip - 1
            # With z = h/tau the accelerations obey a[n+1] = (1 - 3z/2) a[n] + z/2 a[n-1], the recurrence of the second scheme of
            # Adams and Bashforth, whose error per window is 5/12 z^3. Terms of the next order are below 0.5 % of it at z = 0.1.
            self.assertTrue(np.allclose(error, 5 / 12 / windows**2, rtol=0.05 / windows), (windows, error))

    def test_the_end_of_a_run_may_divide_a_window(self):
        found = beads(40, stokes)
        for time in (0.31 * TAU, 0.3101 * TAU, 0.777 * TAU, TAU):
            found.run_until(time)
        error = (found.velocities - WIND) / ((np.array([1.0, -2.0, 0.0]) - WIND) * math.exp(-1)) - 1
        # shorter windows have smaller errors, and a change of length adds at most z^2/2 of one window
        self.assertLess(abs(error).max(), (5 / 12 + 3 / 2) / 40**2)

    def test_beads_that_meet_have_the_paths_of_the_built_in_law(self):
        pair = {"positions": [[0.05, 0.05, 0.0495], [0.05, 0.05, 0.0505]], "velocities": [[0, 0, 4.0], [0, 0, -1.0]]}
        exact = beads(640, **pair)
        exact.run_until(TAU)
        self.assertEqual(exact.pair_impacts, 1)
        errors = []
        for windows in (40, 160):
            found = beads(windows, stokes, **pair)
            found.run_until(TAU)
            self.assertEqual(found.pair_impacts, 1)
            errors.append(abs(found.velocities - exact.velocities).max())
        # four times as many windows: the error of second order is a sixteenth; twice as much is allowed, as an impact is anywhere in a window
        self.assertLess(errors[1], errors[0] / 8)


class Books(unittest.TestCase):
    def test_the_ledger_counts_the_work_of_the_law(self):
        simulation = gas(lambda now: -200.0 * now.velocities)
        simulation.run_until(simulation.duration)
        ledger = simulation.ledger
        self.assertGreater(simulation.pair_impacts, 100)
        self.assertLess(ledger["drag_work_J"], -0.1 * ledger["energy_at_start_J"])
        self.assertGreater(ledger["dissipated_J"], 0.01 * ledger["energy_at_start_J"])
        change = ledger["energy_J"] - ledger["energy_at_start_J"]
        # each of some thousand terms of the sum is rounded to 1e-16
        self.assertAlmostEqual(change, ledger["drag_work_J"] - ledger["dissipated_J"], delta=1e-12 * ledger["energy_at_start_J"])
        self.assertAlmostEqual(ledger["residual_J"], 0.0, delta=1e-12 * ledger["energy_at_start_J"])

    def test_it_is_called_once_per_window_and_has_the_same_bits_on_any_number_of_threads(self):
        times = []

        def drag(now):
            times.append(now.time)
            return -200.0 * now.velocities

        one, two = gas(drag, threads=1), gas(lambda now: -200.0 * now.velocities, threads=2)
        one.run_until(one.duration)
        two.run_until(two.duration, lambda now: now.state(), every="window")
        self.assertEqual(one.windows, 20)
        self.assertTrue(np.allclose(times, np.linspace(0, one.duration, 21)))
        self.assertTrue(one.state().equals(two.state()))

    def test_no_law_has_the_bits_of_before(self):
        plain, none = gas(None), gas(lambda now: 0 * now.velocities)
        none.drag = None
        self.assertIsNone(none.drag)
        for simulation in (plain, none):
            simulation.run_until(simulation.duration)
        self.assertTrue(plain.state().equals(none.state()))


class Failures(unittest.TestCase):
    def test_after_an_exception_the_run_goes_on_with_the_bits_of_one_without(self):
        calls = []

        def drag(now):
            calls.append(now.time)
            if len(calls) == 4:
                raise KeyError("own")
            return -200.0 * now.velocities

        broken, whole = gas(drag), gas(lambda now: -200.0 * now.velocities)
        with self.assertRaises(KeyError):
            broken.run_until(broken.duration)
        self.assertEqual(broken.windows, 3)
        self.assertAlmostEqual(broken.time, 3 * 50e-6)
        for simulation in (broken, whole):
            simulation.run_until(simulation.duration)
        self.assertEqual(len(calls), 22)
        self.assertTrue(broken.state().equals(whole.state()))

    def test_wrong_answers_are_refused_with_their_shape_and_particle(self):
        def not_finite(now):
            rows = 0 * now.velocities
            rows[5, 1] = math.nan
            return rows

        for drag, words in ((lambda now: 0.0, "[1999, 3]"), (lambda now: now.radii, "[1999, 3]"), (not_finite, "the particle")):
            simulation = gas(drag)
            with self.assertRaises(ValueError) as raised:
                simulation.step()
            self.assertIn(words, str(raised.exception))
        with self.assertRaises(TypeError):
            gas(2.0)

    def test_a_law_cannot_run_or_change_its_simulation(self):
        def runs(now):
            now.step()

        def changes(now):
            now.drag = None

        for drag in (runs, changes):
            simulation = gas(drag)
            with self.assertRaises(RuntimeError) as raised:
                simulation.step()
            self.assertIn("is running", str(raised.exception))

    def test_a_law_that_knows_its_simulation_does_not_keep_it(self):
        class Law:
            def __call__(self, now):
                return 0 * now.velocities

        law = Law()
        law.simulation = gas(law)
        alive = weakref.ref(law)
        del law
        gc.collect()
        self.assertIsNone(alive())


if __name__ == "__main__":
    unittest.main()
