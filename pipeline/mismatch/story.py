"""mismatch.json and its details, told from what the search found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..fitting import Series, trial_values
from ..integrate import Effect, compiled
from ..model import plates, residual_channels
from ..study import Study
from ..tuning import Tuned
from ..tuning.joint import BAND
from .find import Found, astray_by
from .judge import Trialled
from .jumps import EFFECT as KNOCK
from .nameless import HUMP, PULSE, SWING, shares_in_place
from .select import Choice
from .setting import CHANNELS, PARTIAL, best_next_trial
from .swinging import only_of_time, swings
from .weighing import reliability
from .words import sentence, unnamed_terms

RIVAL_WEIGHT = 0.02
MOST_POINTS = 400


def mismatch_json(found: Found, study: Study, series: Sequence[Series]) -> dict[str, Any]:
    """Content of mismatch.json as the contract lists it."""
    told = causes(found)
    others = rivals(found)
    return {
        "verdict": found.verdict,
        "sentence": sentence(found, told, others),
        "causes": told,
        "rivals": others,
        "where": where(found),
        "held_out": {
            "trials": list(found.held_out),
            "baseline": dict(found.errors["baseline"]),
            "extended": dict(found.errors["extended"]),
            "noise_floor_path_rmse_m": found.floor_m,
            "stretch_s": found.horizon_s,
        },
        "next_trial": next_trial(found, study, series),
    }


def causes(found: Found) -> list[dict[str, Any]]:
    """The chosen effects, the one whose loss costs most first, and what is left unexplained."""
    chosen = found.choice.chosen
    loss = {name: chosen.total - model.total for name, model in found.choice.without.items()}
    told = [_cause(found, name, loss[name]) for name in sorted(loss, key=lambda n: -loss[n])]
    return [*told, _unexplained(found)] if found.verdict == "unexplained" else told


def _cause(found: Found, name: str, loss: float) -> dict[str, Any]:
    effect = plates().effect(name)
    return {
        "name": name,
        "kind": effect.kind,
        "channels": list(effect.channels),
        "regime": _regime(found, effect),
        "parameters": _parameters(found, name),
        "weight": weights_in_place(found, name)[name],
        "held_out_gain": loss,
        "sentence": effect.statement,
    }


def _regime(found: Found, effect: Effect) -> str:
    """Where an effect is felt; of a knocked camera, from when on in which trials; of another fault
    of measuring that is in a part of them alone, in which.
    """
    if found.part and effect.name in PARTIAL:
        have = {f.name for f in found.forces}
        told = ", ".join(name for name in found.part.trials if name in have)
        return f"in {told} unlike the other trials: {effect.regime}"
    if effect.name != KNOCK or not found.knocks:
        return effect.regime
    moments = (f"{k.time_s:.1f} s after the start of {k.trial}" for k in found.knocks)
    return f"from {', '.join(moments)} on"


def weights_in_place(found: Found, name: str) -> dict[str, float]:
    """`shares_in_place`; a model that is astray in the end names nothing surely."""
    told = shares_in_place(found.choice, name, beside=not unnamed_terms(found))
    return {other: weight / astray_by(found.choice.chosen) for other, weight in told.items()}


def _parameters(found: Found, name: str) -> dict[str, dict[str, Any]]:
    """A named cause's numbers; std such that value +- 1.96 std is their 95 % interval."""
    tuned = found.extended
    units = {p.name: p.unit for p in plates().parameters}
    return {
        f.name.split(".", 1)[1]: {"value": float(v), "std": s, "unit": units[f.name]}
        for f, v, s in zip(tuned.fit.free, tuned.fit.values, as_normal(tuned), strict=True)
        if f.name.startswith(name + ".")
    }


def _unnamed_parameters(found: Found) -> dict[str, dict[str, Any]]:
    """The numbers of all terms without a name; a name that two of them have bears its effect's."""
    told: dict[str, dict[str, Any]] = {}
    for effect in ("residual", SWING, PULSE, HUMP):
        told |= {name if name not in told else f"{effect}.{name}": cell
                 for name, cell in _parameters(found, effect).items()}  # fmt: skip
    return told


def as_normal(tuned: Tuned) -> list[float]:
    """Deviations (p,) of normal distributions with the 95 % intervals of a tuned model."""
    return [float(std) for std in 0.5 * np.diff(tuned.interval_95, axis=1)[:, 0] / BAND]


def _unexplained(found: Found) -> dict[str, Any]:
    terms = unnamed_terms(found)
    channels = sorted({c for t in terms for c in _channels(t)}, key=CHANNELS.index)
    told = [d for d in found.dependences if CHANNELS[d.channel] in channels] or found.dependences
    first = told[0]
    return {
        "name": "unexplained",
        "kind": "physics",
        "channels": channels,
        "regime": f"depends on {first.variable}",
        "parameters": _unnamed_parameters(found),
        "weight": reliability(found.nameless_gain),
        "held_out_gain": found.nameless_gain * found.residual.inflation,
        "sentence": "A force is missing that none of the named causes explains well; "
        + _modelled_by(found)
        + f" depends most on {first.variable}.",
    }


def _channels(term: str) -> tuple[str, ...]:
    effect, number = term.split(".", 1)
    return residual_channels(number) if effect == "residual" else plates().effect(effect).channels


def _modelled_by(found: Found) -> str:
    """How what has no name is modelled, up to the words on what it depends on."""
    if not unnamed_terms(found):
        return "what is lacking"
    free = found.extended.fit.free
    if only_of_time(free):
        what = "water that swings to and fro" if swings(free) else "thrust that comes and goes"
        return f"it is modelled as {what} and"
    return "it is modelled by a fitted residual term and"


def rivals(found: Found) -> list[dict[str, Any]]:
    """Candidates that would have done nearly as well in place of a chosen one."""
    out = [
        {"name": other, "in_place_of": name, "weight": weight,
         "how_to_tell_apart": _apart(name, other)}
        for name in found.choice.chosen.effects
        for other, weight in weights_in_place(found, name).items()
        if other != name and weight >= RIVAL_WEIGHT
    ]  # fmt: skip
    return sorted(out, key=lambda r: -r["weight"])


def _apart(name: str, other: str) -> str:
    if other == "unexplained":
        regime = plates().effect(name).regime or "all trials"
        return (
            f"a force without a name describes these trials about as well as {name}: film where "
            f"{name} should be strongest ({regime}) and where it should vanish"
        )
    first, second = plates().effect(name), plates().effect(other)
    return (
        f"{name} acts in {first.regime or 'all trials'}, "
        f"{other} in {second.regime or 'all trials'}: film where only one of them should act"
    )


def where(found: Found) -> list[dict[str, Any]]:
    """Channels and variables that foretell the missing force, the largest share first; a further
    variable of a channel with the share that it adds.
    """
    strong = sorted((d for d in found.dependences if d.adds > 0), key=lambda d: -d.adds)
    if found.verdict == "none":
        return []
    return [
        {
            "channel": CHANNELS[d.channel],
            "variable": d.variable,
            "share": d.adds,
            "trials": list(d.trials),
        }
        for d in strong
    ]


def next_trial(found: Found, study: Study, series: Sequence[Series]) -> dict[str, Any]:
    """The trial that would separate the verdict from its nearest rival best."""
    kernel = compiled(plates())
    first, second, names = _two_models(found)
    flap = {g: float(np.mean([s.inputs[0, 1] for s in series if s.group == g]))
            for g in sorted({s.group for s in series}, key=float)}  # fmt: skip
    base = found.baseline.base
    values = [trial_values(kernel, base, m.fit.free, m.fit.values, "") for m in (first, second)]
    best = best_next_trial(study, kernel, values[0], values[1], flap)
    why = f"here {names[0]} and {names[1]} part most: {best['apart_mm']:.0f} mm rms of path in 4 s"
    return best | {"why": why}


def _best_rival(choice: Choice, name: str) -> float:
    """Held-out log likelihood of the best rival for the place of a chosen effect."""
    return max((t.total for t in choice.places[name].tried
                if t.effects[-1] not in choice.chosen.effects), default=-np.inf)  # fmt: skip


def _two_models(found: Found) -> tuple[Trialled, Trialled, tuple[str, str]]:
    chosen = found.choice.chosen
    if not chosen.effects:
        last = found.choice.rounds[-1].tried
        other = last[0] if last else found.residual
        return chosen, other, ("the baseline", (other.effects or ("a residual",))[-1])
    first = max(chosen.effects, key=lambda e: _best_rival(found.choice, e))
    options = [t for t in found.choice.places[first].tried if t.effects[-1] not in chosen.effects]
    other = options[0] if options else found.choice.bare
    return chosen, other, (" and ".join(chosen.effects), (other.effects or ("the baseline",))[-1])
