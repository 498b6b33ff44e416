"""Names of a model, each of which stands for one quantity."""

from __future__ import annotations

from collections import Counter

from ..errors import InputIssue
from ..integrate.row_layout import reserved_integrator_names
from .model import OBSERVE_STAGE, RATES_STAGE, Model


def check_unique_names(model: Model) -> list[InputIssue]:
    """Names that no variable may have, that two quantities have, or that the integration uses."""
    names = [x.name for x in (*model.variables, *model.constants, *model.coefficients)]
    names += [
        o for s in model.stages if s.name not in (RATES_STAGE, OBSERVE_STAGE) for o in s.outputs
    ]
    own = [s for c in model.causes for s in c.states]
    used = reserved_integrator_names(
        [*(s.name for s in model.states), *own], [o.name for o in model.observations]
    )
    found = []
    for name, count in Counter([*names, *own]).items():
        if not name.isidentifier():
            found.append((f"'{name}'", "letters, digits and _"))
        elif count > 1:
            found.append((f"'{name}' stands for two things", "a name for each"))
        elif name in used:
            found.append((f"'{name}', which the integration uses for {used[name]}", "another name"))
    return [InputIssue(f"model '{model.name}'", "names", *one) for one in found]
