"""Two runs side by side: coefficients, causes, errors, settings, inputs and versions.

differences    what differs, from the files of two results folders
figure         figure of the numbers that differ
"""

from .figure import comparison_figure
from .run_differences import Difference, RunResults, list_run_differences, read_run

__all__ = ["Difference", "RunResults", "comparison_figure", "list_run_differences", "read_run"]
