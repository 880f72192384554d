from ._engine import Simulation as Simulation
from .errors import InputError as InputError, RunError as RunError
from .results import Results as Results, load as load
from .running import compare as compare, judge as judge, run as run, sweep as sweep
