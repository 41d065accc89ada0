"""Public names of roughsim and their modules: for type checkers, and read by `roughsim/__init__.py`."""

from roughsim.comparison.compare import Comparison as Comparison
from roughsim.comparison.several import Comparisons as Comparisons
from roughsim.comparison.theory import Theory as Theory
from roughsim.comparison.theory import theory as theory
from roughsim.contact import Contact as Contact
from roughsim.contact import Solid as Solid
from roughsim.contact.active_set import solve_contact as solve_contact
from roughsim.contact.patches import contact_patches as contact_patches
from roughsim.contact.patches import corrected_area as corrected_area
from roughsim.contact.patches import corrected_fractions as corrected_fractions
from roughsim.contact.plasticity import follow_loads as follow_loads
from roughsim.contact.plasticity import plastic_deformation as plastic_deformation
from roughsim.ensemble.press import press as press
from roughsim.ensemble.run import run as run
from roughsim.error_over_cost import bench as bench
from roughsim.errors import ConvergenceError as ConvergenceError
from roughsim.errors import RecordError as RecordError
from roughsim.errors import ResolutionError as ResolutionError
from roughsim.errors import RoughsimError as RoughsimError
from roughsim.fourier import set_threads as set_threads
from roughsim.grid import Grid as Grid
from roughsim.heat.body import Body as Body
from roughsim.heat.half_space import half_space_temperature as half_space_temperature
from roughsim.heat.partition import partition_heat as partition_heat
from roughsim.heat.periodic import sliding_temperature as sliding_temperature
from roughsim.heat.skin import Skin as Skin
from roughsim.observables.moments import HeatSource as HeatSource
from roughsim.observables.moments import Moments as Moments
from roughsim.observables.moments import measure as measure
from roughsim.outputs.compare import compare as compare
from roughsim.outputs.export import export as export
from roughsim.outputs.plot import plot as plot
from roughsim.outputs.report import report as report
from roughsim.outputs.status import status as status
from roughsim.planning.plan import plan as plan
from roughsim.planning.realization import realize as realize
from roughsim.results.folder import open_run as open_run
from roughsim.results.run import Run as Run
from roughsim.scene import Scene as Scene
from roughsim.scene import load_scene as load_scene
from roughsim.scene import new as new
from roughsim.scene.numerics import Level as Level
from roughsim.scene.numerics import Numerics as Numerics
from roughsim.show.text import SceneWarning as SceneWarning
from roughsim.sliding.slide import Slide as Slide
from roughsim.sliding.slide import slide as slide
from roughsim.studies.study import Study as Study
from roughsim.studies.study import open_study as open_study
from roughsim.studies.work import study as study
from roughsim.surface.power_laws import SelfAffineSpectrum as SelfAffineSpectrum
from roughsim.surface.power_laws import TabulatedSpectrum as TabulatedSpectrum
from roughsim.surface.synthesis import synthesize as synthesize
from roughsim.table import Estimate as Estimate

__version__: str

def __dir__() -> list[str]: ...
