"""mismatch_detail.json: what the figures of the mismatch are drawn from."""

from __future__ import annotations

from typing import Any

import numpy as np

from .find import Found
from .story import as_normal


def details(found: Found) -> dict[str, Any]:
    """Content of mismatch_detail.json: forces along the paths, dependences, candidates."""
    return {
        "forces": {
            f.name: {
                "time_s": f.times,
                "x_m": f.states[:, 0],
                "y_m": f.states[:, 1],
                "heading_rad": f.states[:, 2],
                "surge_N": f.force[:, 0],
                "sway_N": f.force[:, 1],
                "yaw_Nm": f.force[:, 2],
                "surge_std": f.std[:, 0],
                "sway_std": f.std[:, 1],
                "yaw_std": f.std[:, 2],
            }
            for f in found.forces
        },
        "candidates": [
            {
                "round": i + 1,
                "name": t.effects[-1],
                "beside": list(t.effects[:-1]),
                "held_out_gain": t.total - one.before.total,
                "trials_better": int(np.sum(t.worth > one.before.worth)),
                "trials": len(one.before.worth),
                "p_value": t.p_value[t.effects[-1]],
                "outcome": t.fit.outcome,
                "parameters": {
                    k.split(".", 1)[1]: v
                    for k, v in t.fit.by_label().items()
                    if k.startswith(t.effects[-1] + ".")
                },
            }
            for i, one in enumerate(found.choice.rounds)
            for t in one.tried
        ],
        "foretold": [dict(one.foretold) for one in found.choice.rounds],
        "coefficients": {
            name: {f.label: {"value": float(v), "std": s} for f, v, s in zip(
                tuned.fit.free, tuned.fit.values, as_normal(tuned), strict=True)}
            for name, tuned in (("before", found.baseline), ("after", found.extended))
        },
    }  # fmt: skip
