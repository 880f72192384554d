"""Engines in Python: bits, shared memory, observers, threads, signals, messages, stubs."""

import ast
import inspect
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request
import warnings
from pathlib import Path

import numpy as np

import diptych
from diptych import _engine

CASES = Path(__file__).resolve().parents[2] / "cases"
SHORT = {"run.duration": "20 ms", "run.average_from": "0 s", "particles[0].volume_fraction": "2e-3"}
#: Keys with which a gas runs for minutes in short windows, unless the run is stopped.
LONG = {"run.duration": "1 s", "run.window": "10 us"}


def short(model="hard", **options):
    return diptych.Simulation(CASES / "quick.toml", model=model, set=SHORT, **options)


def address(array) -> int:
    return array.__array_interface__["data"][0]


def long(**options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return diptych.Simulation(CASES / "dense-gas.toml", model="hard", set=LONG, **options)


class Bits(unittest.TestCase):
    def test_a_run_has_the_bits_of_the_program(self):
        sampled = {**SHORT, "statistics.sample_interval": "4 ms"}
        for model in ("soft", "hard"):
            with tempfile.TemporaryDirectory() as folder:
                out = Path(folder) / "out"
                arguments = ["--save-state"]
                found = diptych.run(CASES / "quick.toml", out, command="run", model=model, set=sampled, arguments=arguments).state
            simulation = diptych.Simulation(CASES / "quick.toml", model=model, set=sampled)
            seen = []
            simulation.run_until(simulation.duration, lambda now: seen.append(now.positions))
            state = simulation.state()
            self.assertEqual(len(state), len(found))
            for column in ("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s"):
                self.assertTrue((state[column].to_numpy() == found[column].to_numpy()).all(), (model, column))
            self.assertTrue((2 * state["radius_m"].to_numpy() == found["diameter_m"].to_numpy()).all())
            self.assertEqual(len(seen), 5)

    def test_windows_at_which_nothing_looks_change_no_bit(self):
        stepped, whole = short(), short()
        while stepped.time < 0.999 * stepped.duration:
            stepped.step()
        whole.run_until(whole.duration)
        self.assertEqual(stepped.windows, whole.windows)
        self.assertGreater(whole.windows, 10)
        self.assertTrue(stepped.state().equals(whole.state()))

    def test_a_setting_may_be_true_or_false(self):
        with_weight = diptych.Simulation(CASES / "quick.toml", model="hard", set={**SHORT, "fluid.buoyancy": False})
        self.assertGreater(len(with_weight.positions), 0)

    def test_threads_and_a_text_change_no_bit(self):
        one = short(threads=1)
        two = short(threads=2)
        text = diptych.Simulation(text=(CASES / "cooling-gas.toml").read_text(), set={"run.duration": "1 ms"}, model="hard")
        file = diptych.Simulation(CASES / "cooling-gas.toml", set={"run.duration": "1 ms"}, model="hard")
        for pair in ((one, two), (text, file)):
            for simulation in pair:
                simulation.run_until(simulation.duration)
            self.assertTrue(pair[0].state().equals(pair[1].state()))
        other = short(seed=7)
        self.assertFalse((other.positions == short().positions).all())


class Arrays(unittest.TestCase):
    def test_arrays_share_the_memory_of_the_engine(self):
        simulation = short()
        count = len(simulation.ids)
        self.assertEqual(simulation.positions.shape, (count, 3))
        self.assertEqual(simulation.velocities.shape, (count, 3))
        self.assertEqual((simulation.radii.shape, simulation.species.dtype, simulation.ids.dtype), ((count,), np.uint16, np.uint32))
        self.assertIsNone(simulation.spins)
        for name in ("positions", "velocities", "radii", "masses", "species", "ids"):
            self.assertTrue(np.shares_memory(getattr(simulation, name), getattr(simulation, name)), name)
        energy = 0.5 * np.sum(simulation.masses[:, None] * simulation.velocities**2)
        # each term of a sum of some hundred terms is rounded
        self.assertAlmostEqual(energy / simulation.kinetic_energy, 1.0, delta=1e-12)

    def test_nothing_is_copied_when_no_array_is_left(self):
        simulation = short(threads=1)
        places = set()
        for _ in range(5):
            places.add(address(simulation.radii))
            simulation.step()
        # an engine may exchange its particle store for another one of equal size, but needs no third one
        self.assertLessEqual(len(places), 2)

    def test_an_array_that_is_kept_shows_its_instant(self):
        simulation = short()
        before = simulation.positions
        copy = before.copy()
        simulation.step(3)
        after = simulation.positions
        self.assertTrue((before == copy).all())
        self.assertFalse(np.shares_memory(before, after))
        self.assertFalse((before == after).all())
        kept = simulation.velocities
        copy = kept.copy()
        del simulation, after
        # the memory of an array outlives the simulation
        filler = [np.ones_like(copy) for _ in range(50)]
        self.assertTrue((kept == copy).all() and len(filler) == 50)

    def test_arrays_cannot_be_written(self):
        positions = short().positions
        with self.assertRaises(ValueError):
            positions[0, 0] = 1.0
        with self.assertRaises(ValueError):
            positions.flags.writeable = True

    def test_spins_of_spheres_that_rotate(self):
        simulation = diptych.Simulation(CASES / "rotation" / "slide-to-roll.toml", model="soft")
        simulation.step()
        self.assertEqual(simulation.spins.shape, (len(simulation.ids), 3))
        self.assertIn("wx_rad_s", simulation.state().columns)


class Observers(unittest.TestCase):
    def test_observers_are_called_at_samples_windows_and_times(self):
        seen = []
        see = lambda now: seen.append((now.time, now.windows, now.velocities[:, 2].mean()))
        simulation = short()
        simulation.run_until(simulation.duration, see)
        samples = [row[0] for row in seen]
        self.assertTrue(np.allclose(np.diff(samples), samples[0]))
        self.assertAlmostEqual(samples[-1], simulation.duration)
        seen.clear()
        simulation = short()
        simulation.run_until(10 * samples[0], see, every="window")
        self.assertEqual([row[1] for row in seen], list(range(1, simulation.windows + 1)))
        seen.clear()
        simulation = short()
        simulation.run_until(0.01, see, every=0.004)
        self.assertTrue(np.allclose([row[0] for row in seen], [0.004, 0.008, 0.01]))
        simulation.run_until(0.01, see)
        self.assertEqual(len(seen), 3)

    def test_an_error_of_an_observer_is_passed_on(self):
        def fail(now):
            raise KeyError("own")

        simulation = short()
        with self.assertRaises(KeyError):
            simulation.run_until(1.0, fail)
        self.assertGreater(simulation.time, 0.0)
        with self.assertRaises(ValueError):
            simulation.run_until(1.0, print, every="week")
        with self.assertRaises(ValueError):
            simulation.run_until(float("nan"))


class ThreadsAndSignals(unittest.TestCase):
    def test_two_simulations_run_at_once_and_python_goes_on(self):
        alone = long(threads=1)
        alone.run_until(0.02)
        both = [long(threads=1), long(threads=1)]
        workers = [threading.Thread(target=simulation.run_until, args=(0.02,)) for simulation in both]
        for worker in workers:
            worker.start()
        steps = 0
        while any(worker.is_alive() for worker in workers):
            time.sleep(1e-3)
            steps += 1
        self.assertGreater(steps, 10)
        for simulation in both:
            self.assertTrue(simulation.state().equals(alone.state()))

    def test_a_simulation_that_runs_is_refused_to_others(self):
        simulation = long(threads=1)
        kept = simulation.positions
        worker = threading.Thread(target=simulation.run_until, args=(0.05,))
        worker.start()
        said = ""
        while worker.is_alive() and not said:
            try:
                _ = simulation.positions
            except RuntimeError as why:
                said = str(why)
        # while the engine runs, it does not change an array that was made before
        self.assertTrue(np.isfinite(kept).all())
        worker.join()
        self.assertIn("another thread", said)
        self.assertEqual(simulation.positions.shape, kept.shape)

    def test_ctrl_c_stops_a_run_that_can_go_on(self):
        # a program that a shell starts in the background ignores Ctrl-C, and Python then installs no handler
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        simulation = long()
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            simulation.run_until(1.0)
        reached = simulation.time
        self.assertGreater(reached, 0.0)
        simulation.step()
        self.assertGreater(simulation.time, reached)

    def test_ctrl_c_stops_the_command(self):
        with tempfile.TemporaryDirectory() as folder:
            sets = [word for key, value in LONG.items() for word in ("--set", f"{key}={value}")]
            line = [sys.executable, "-m", "diptych", "run", str(CASES / "dense-gas.toml"), "--model", "hard", "--out", folder, "--overwrite", *sets]
            process = subprocess.Popen(line, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            # the folder has a file as soon as the program listens to signals and begins the run
            while not any(Path(folder).iterdir()) and process.poll() is None:
                time.sleep(0.05)
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130, said)
            self.assertNotIn("Traceback", said)


class LiveView(unittest.TestCase):
    def test_a_page_shows_the_simulation_and_changes_no_bit(self):
        simulation, plain = long(), long()
        url = simulation.show().url
        self.assertRegex(url, r"^http://127\.0\.0\.1:\d+/[0-9a-f]{32}/$")
        self.assertEqual(simulation.show().url, url)
        self.assertIn(url, simulation.show()._repr_html_())
        for one in (simulation, plain):
            one.run_until(0.005)
        with urllib.request.urlopen(url) as answer:
            self.assertIn("Diptych run", answer.read().decode())
            # a notebook of this machine may contain the page, and no other site
            self.assertIn("frame-ancestors http://127.0.0.1:* http://localhost:*", answer.headers["Content-Security-Policy"])
        self.assertTrue(simulation.state().equals(plain.state()))
        # another token, and none
        for wrong in (url[:-2] + "/", url.rsplit("/", 2)[0] + "/"):
            with self.assertRaises(urllib.error.HTTPError):
                urllib.request.urlopen(wrong)


class Messages(unittest.TestCase):
    def test_errors_carry_the_message_of_the_program(self):
        with self.assertRaises(diptych.InputError) as raised:
            diptych.Simulation(CASES / "impact.toml", set={"contact.restitution": 2})
        self.assertIn("--set contact.restitution=2", str(raised.exception))
        with self.assertRaises(diptych.InputError) as raised:
            diptych.Simulation(text="[domain]\nsise = 1\n")
        self.assertIn("case.toml:2", str(raised.exception))
        with self.assertRaises(ValueError) as raised:
            diptych.Simulation("quick", model="rigid")
        self.assertIn("soft, hard, hybrid, dsmc", str(raised.exception))
        for case in ({}, {"case": "quick", "text": ""}):
            with self.assertRaises(ValueError):
                diptych.Simulation(**case)

    def test_an_engine_that_cannot_go_on_says_why(self):
        simulation = diptych.Simulation(CASES / "column.toml", model="hard")
        with self.assertRaises(diptych.RunError) as raised:
            simulation.run_until(simulation.duration)
        self.assertIn("collapse", str(raised.exception))
        self.assertIsNone(raised.exception.results)

    def test_the_command_is_the_program(self):
        said = subprocess.run([sys.executable, "-m", "diptych", "--version"], capture_output=True, text=True, check=True).stdout
        self.assertRegex(said, r"^diptych \d+\.\d+\.\d+\n$")
        wrong = subprocess.run([sys.executable, "-m", "diptych", "run", "none.toml"], capture_output=True, text=True, check=False)
        self.assertEqual(wrong.returncode, 2)


class Stubs(unittest.TestCase):
    def test_stubs_list_all_with_their_parameters_and_words(self):
        stub = ast.parse((Path(diptych.__file__).parent / "_engine.pyi").read_text(encoding="utf-8"))
        (described,) = [node for node in stub.body if isinstance(node, ast.ClassDef)]
        setters = [node for node in described.body if any(isinstance(of, ast.Attribute) for of in getattr(node, "decorator_list", ()))]
        members = {node.name: node for node in described.body if isinstance(node, ast.FunctionDef) and node not in setters}
        public = {name for name in vars(_engine.Simulation) if not name.startswith("_")}
        self.assertEqual(public, set(members) - {"__init__"})
        for name, node in members.items():
            self.assertTrue(ast.get_docstring(node), name)
            found = getattr(_engine.Simulation, name)
            if callable(found) and name != "__init__":
                parameters = [argument.arg for argument in node.args.args + node.args.kwonlyargs]
                self.assertEqual(list(inspect.signature(found).parameters), parameters, name)
        own = {name for name in diptych.__all__ if getattr(diptych, name)}
        listed = {name.asname for node in ast.parse((Path(diptych.__file__).parent / "__init__.pyi").read_text()).body for name in node.names}
        self.assertEqual(own, listed)


if __name__ == "__main__":
    unittest.main()
