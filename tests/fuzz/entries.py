"""Every entry point, with a function that draws its arguments: name -> function of a `Draw` that returns
(callable, arguments).

Arguments that are named in the dictionary by a number are positional.
"""

from .charts import CHART
from .functions import FUNCTIONS
from .grassmann import GRASSMANN
from .manifold import MANIFOLD
from .rotations import ROTATIONS
from .trajectories import TRAJECTORIES

CALLS = {**FUNCTIONS, **MANIFOLD, **GRASSMANN, **CHART, **TRAJECTORIES, **ROTATIONS}
