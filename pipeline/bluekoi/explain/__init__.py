"""Which causes a model of any system leaves out, from its recordings.

A model (`Model`) is a chain of short functions with units and candidate causes (`Cause`); a
recording (`Trial`) is a set of named arrays. `explain` returns which causes act with which
probability, their numbers, and how well the model predicts conditions left out of its fit;
`predict` simulates recordings made elsewhere. `bluekoi explain` does the same from files.

    >>> from bluekoi.explain import Trial, explain
    >>> import numpy as np
    >>> Trial("run 1", np.arange(3.0), {"position": np.zeros(3)}).role
    'fit'
"""

from ..integrate import Parameter, Stage
from .cause_search import CauseSearchResult, explain
from .folder import read_trials
from .model import Cause, Constant, Input, Model, Observation, State
from .model_file import load_model
from .prediction import PredictedTrials, predict, predict_left_out
from .results_json import explanation_json, prediction_json
from .text import prediction_text, summary
from .trials import Trial

__all__ = [
    "Cause",
    "CauseSearchResult",
    "Constant",
    "Input",
    "Model",
    "Observation",
    "Parameter",
    "PredictedTrials",
    "Stage",
    "State",
    "Trial",
    "explain",
    "explanation_json",
    "load_model",
    "predict",
    "predict_left_out",
    "prediction_json",
    "prediction_text",
    "read_trials",
    "summary",
]
