"""What is public; all else may change."""

from fsipetsc.api import run as run
from fsipetsc.blocks.block import Block as Block
from fsipetsc.blocks.block_problem import BlockProblem as BlockProblem
from fsipetsc.blocks.layers import Layer as Layer
from fsipetsc.blocks.layers import layers as layers
from fsipetsc.boundaries import Dirichlet as Dirichlet
from fsipetsc.boundaries import Open as Open
from fsipetsc.boundaries import SolidEnd as SolidEnd
from fsipetsc.boundaries import Wall as Wall
from fsipetsc.boundaries import absorbing as absorbing
from fsipetsc.boundaries import clamped as clamped
from fsipetsc.boundaries import free as free
from fsipetsc.equations.piecewise import Piecewise as Piecewise
from fsipetsc.errors import ComputationError as ComputationError
from fsipetsc.errors import FileError as FileError
from fsipetsc.errors import FsiError as FsiError
from fsipetsc.errors import InputError as InputError
from fsipetsc.materials.fluid import Fluid as Fluid
from fsipetsc.materials.solid import ElasticSolid as ElasticSolid
from fsipetsc.materials.solid import Solid as Solid
from fsipetsc.options import REQUIRED as REQUIRED
from fsipetsc.options import Option as Option
from fsipetsc.output.differences import compare as compare
from fsipetsc.output.reader import Run as Run
from fsipetsc.output.reader import open_run as open_run
from fsipetsc.problem import FluidLayer as FluidLayer
from fsipetsc.problem import Problem as Problem
from fsipetsc.problem import SolidLayer as SolidLayer

__version__: str
