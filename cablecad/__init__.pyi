# What `__init__` loads when it is first used, for those who check types.

from cablecad.centreline import Arc as Arc
from cablecad.centreline import Centreline as Centreline
from cablecad.centreline import Frames as Frames
from cablecad.centreline import Line as Line
from cablecad.centreline import Placement as Placement
from cablecad.errors import CablecadError as CablecadError
from cablecad.errors import ExchangeError as ExchangeError
from cablecad.errors import GeometryError as GeometryError
from cablecad.errors import InfeasibleError as InfeasibleError
from cablecad.errors import InvalidTubeError as InvalidTubeError
from cablecad.errors import MissingDependencyError as MissingDependencyError
from cablecad.errors import Mistake as Mistake
from cablecad.errors import NotPlanarError as NotPlanarError
from cablecad.errors import RuleError as RuleError
from cablecad.errors import SceneError as SceneError
from cablecad.errors import SolveError as SolveError
from cablecad.errors import UsageError as UsageError
from cablecad.model import Cable as Cable
from cablecad.model import Clamp as Clamp
from cablecad.model import EquilibriumKey as EquilibriumKey
from cablecad.model import Material as Material
from cablecad.model import NamedPort as NamedPort
from cablecad.model import Part as Part
from cablecad.model import PartPort as PartPort
from cablecad.model import Pin as Pin
from cablecad.model import Port as Port
from cablecad.model import Rotation as Rotation
from cablecad.model import Scene as Scene
from cablecad.model import Section as Section
from cablecad.model import Toward as Toward
from cablecad.picture.render import render_scene as render_scene
from cablecad.pipeline import Built as Built
from cablecad.pipeline import build as build
from cablecad.pipeline import build_scene as build_scene
from cablecad.pipeline import solve as solve
from cablecad.pipeline import solve_many as solve_many
from cablecad.pipeline import write_step as write_step
from cablecad.rod.solution import EndState as EndState
from cablecad.rod.solution import Equilibrium as Equilibrium
from cablecad.rod.solution import RodSolution as RodSolution
from cablecad.scene import load_scene as load_scene

__version__: str
