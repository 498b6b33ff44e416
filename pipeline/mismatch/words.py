"""The verdict in one sentence, plain words first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..model import is_nameless
from ..tuning import table
from .find import Found
from .setting import PARTIAL

SURE = 0.8
LEFT_OVER = 1.5
"""So many times the noise floor the held-out paths of a true model are not off: 1.5 and more were 3
of 236 concealed studies by our laws, one named wrong, and 10 of 62 by others' laws, four of them.
"""


def sentence(
    found: Found, told: Sequence[Mapping[str, Any]], others: Sequence[Mapping[str, Any]]
) -> str:
    """One sentence of verdict, plain words first."""
    before, after = (1000 * found.errors[k]["path_rmse_m"] for k in ("baseline", "extended"))
    way = "falls" if after < before else "goes"
    spared = set(found.held_out) < {f.name for f in found.forces}
    trials = "on trials not fitted" if spared else "on the fitted trials (none could be held out)"
    change = f"{way} from {before:.1f} to {after:.1f} mm"
    if found.verdict == "none":
        change = f"is {before:.1f} mm"
    proof = f"{trials} the path error {change}"
    if found.verdict == "none" and not _determined(found):
        return (
            "These trials determine hardly any coefficient, so that nothing can be said of what "
            "the model lacks: film turns to both sides at two head angles and two powers."
        )
    if found.verdict == "none":
        if off := left_over(found):
            return f"Nothing beyond the noise can be named, yet {proof}{off}."
        return "Nothing beyond the noise: the model as it stands explains these recordings."
    beside = " and ".join(_called(found, c) for c in told if c["name"] != "unexplained")
    if found.verdict == "unexplained" and not unnamed_terms(found):
        chosen = found.choice.chosen
        spread = chosen.astray if chosen.effects else chosen.inflation
        far = f"{spread:.0f} times more than their errors" if np.isfinite(spread) else "at will"
        return (
            f"The model{' with ' + beside if beside else ''} does not describe these trials, and "
            f"they do not tell what it lacks{' besides' if beside else ''}: its numbers differ "
            f"from trial to trial {far}; film more trials, at other angles and powers."
        )
    if found.verdict == "unexplained":
        first = f"{blame_of(told)}: {beside}; and something else" if beside else "Something"
        return (f"{first} is missing that no known cause explains; modelled as a residual, {proof}"
                f"{left_over(found)}.")  # fmt: skip
    names = " and ".join(_called(found, c) for c in told)
    doubt = [r for r in others if r["weight"] > 0.2]
    if doubt:
        names += " (or " + ", ".join(sorted({str(r["name"]) for r in doubt})) + ", not told apart)"
    blame = "The measurement is at fault" if found.verdict == "measurement" else "Physics left out"
    return f"{blame}: {names}; {proof}{left_over(found)}."


def blame_of(told: Sequence[Mapping[str, Any]]) -> str:
    """First words on the causes that have a name, by the kind of the foremost."""
    kind = next((c["kind"] for c in told if c["name"] != "unexplained"), "")
    return "The measurement is at fault" if kind == "measurement" else "Physics left out"


def left_over(found: Found) -> str:
    """What to add where the held-out paths of the extended model are far off the noise floor."""
    after, floor = found.errors["extended"]["path_rmse_m"], found.floor_m
    if not after > LEFT_OVER * floor > 0:
        return ""
    return (f", {after / floor:.1f} times what noise explains: a law has another form than the "
            "model's, or more is missing that these trials do not name")  # fmt: skip


def _called(found: Found, cause: Mapping[str, Any]) -> str:
    """Its name, with how many trials it is in where these are a part, and its weight where low."""
    name, weight = str(cause["name"]), float(cause["weight"])
    if found.part and name in PARTIAL:
        name += f" (in {len(found.part.trials)} trials, unlike the others)"
    return name + (f" (weight {weight:.2f}: not sure)" if weight < SURE else "")


def _determined(found: Found) -> bool:
    """Whether the baseline's fit determines at least half of its coefficients."""
    rows = table(found.baseline).values()
    return 2 * sum(bool(row["determined"]) for row in rows) >= len(rows)


def unnamed_terms(found: Found) -> list[str]:
    """Labels of the nameless terms in the extended model."""
    return [f.name for f in found.extended.fit.free if is_nameless(f.name)]
