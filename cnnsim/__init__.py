"""The cellular wave machine: planes, templates and programs of a cellular neural network.

from cnnsim import read_picture, run, write_picture
picture = read_picture("square.png")
result = run("edge", picture)
write_picture(result.y, "edge.png")
"""

__version__ = "0.1.0"

__all__ = [
    "PERIODIC",
    "ZERO_FLUX",
    "Boundary",
    "Cell",
    "Frames",
    "InputError",
    "LayeredTemplate",
    "NotSettledError",
    "Program",
    "Result",
    "Sides",
    "Stage",
    "Table",
    "Template",
    "Term",
    "Training",
    "TrainingTask",
    "Trajectory",
    "UniversalMachine",
    "__version__",
    "accuracy",
    "design",
    "devices",
    "explain",
    "fixed",
    "from_gray",
    "gradient",
    "library",
    "load_program",
    "plot",
    "read_picture",
    "read_pictures",
    "robust",
    "run",
    "run_program",
    "run_transient",
    "to_planes",
    "trace",
    "train",
    "trajectory",
    "write_picture",
]

TYPE_CHECKING = False  # not from typing, which takes longer to import than this file
if TYPE_CHECKING:  # at run time `cnnsim.lazy` imports a name from here when it is first used
    from cnnsim import library, plot
    from cnnsim.backends.opencl.device.devices import devices
    from cnnsim.convergence import NotSettledError
    from cnnsim.learning.gradient import gradient
    from cnnsim.learning.stage import Stage
    from cnnsim.learning.train import Training, train
    from cnnsim.learning.training_task import TrainingTask
    from cnnsim.library.catalogue import run
    from cnnsim.network import (
        PERIODIC,
        ZERO_FLUX,
        Boundary,
        Cell,
        Frames,
        LayeredTemplate,
        Sides,
        Table,
        Template,
        Term,
        fixed,
    )
    from cnnsim.program.explain import explain
    from cnnsim.program.file import load_program
    from cnnsim.program.machine import UniversalMachine, run_program
    from cnnsim.program.program import Program
    from cnnsim.prototyping.functions import accuracy, design, robust, trace
    from cnnsim.result import Result
    from cnnsim.support import InputError
    from cnnsim.support.pictures.picture import write_picture
    from cnnsim.support.pictures.read import read_picture, read_pictures
    from cnnsim.support.values import from_gray, to_planes
    from cnnsim.trajectories import Trajectory
    from cnnsim.transient import run_transient, trajectory
else:
    from cnnsim.lazy import importer

    __getattr__ = importer(__name__)

    def __dir__() -> list[str]:
        return __all__
