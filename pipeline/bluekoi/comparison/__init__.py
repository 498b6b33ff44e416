"""Two runs side by side: coefficients, causes, errors, settings, inputs and versions.

differences    what differs, from the files of two results folders
picture        figure of the numbers that do
"""

from .differences import Difference, Run, compare, read_run
from .picture import comparison_figure

__all__ = ["Difference", "Run", "compare", "comparison_figure", "read_run"]
