"""docs/effects.md from the files of the effects and of the measurement errors.

    python docs/effects_page.py

Each file is one physical statement. A test checks that the page is current.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).resolve().parent
PACKAGE = HERE.parent / "pipeline/bluekoi"
FOLDERS = {"effects": "Physics", "measurement": "Measurement errors"}
HEAD = """# Candidate causes

A candidate is a physical effect that may be missing from the published model of the robot, or a
possible error of the measurement. The finder (search for missing causes) fits each candidate
together with the coefficients of the model.

The axes are surge forward, sway to the left and yaw counter-clockwise. The core is the rigid body
behind the head. The formulas use these symbols:

- `u`, `v`: velocity along and across the core; `V`: speed; `r`: yaw rate;
- `rho`: density of the water; `A`: area of the head plate;
- `T`: thrust; `f`: flapping frequency;
- `phi`: head angle; `alpha`: angle of attack of the head plate;
- `X`, `Y`, `N`: forces in surge and sway, and yaw moment;
- `C_...`: coefficients of the paper ([The model](paper.md)). In the moment `q C_Ma sin 2 alpha` of
  the head, `q` is the force 1/2 rho A V^2, the dynamic pressure times the area `A`.

All other letters are defined for one candidate at a time, in its text or in the second column of
its table.

In the tables, "start" is the value from which a fit starts, and "from" and "to" are the bounds of a
parameter. The first parameter, or the first few, are the strengths of the candidate: if they are 0,
the candidate has no effect. All others are shape parameters, which determine the form of the
effect.

Many shape parameters are weights, which interpolate linearly between two forms of an effect. For
example, "w: weight of a form that grows as t^2" means: the effect is 1 - w times its basic form,
plus w times a form that is proportional to t^2. With w = 0, only the basic form acts; with w = 1,
only the other.

Starts, bounds, and the numbers with a unit in the formulas are those of the published robot (mass
0.68 kg, length of the body 0.331 m). Those of a robot of mass m and length l follow by similarity:
masses are multiplied by m / 0.68 kg, lengths by l / 0.331 m, times by the square root of l / 0.331
m, and other quantities by the factor that follows from their units. For example, for a robot of 1 m
and 18 kg, a speed of 0.3 m/s becomes 0.52 m/s, and a force of 10 N becomes 265 N. The key
`robot_units` of mismatch.json states the three factors.

Below a table, "Forms" lists variants of the effect: published formulas, or other values of a length
or of a time, such as a short lag. In brackets are the values of the shape parameters that give the
form. Shape parameters that are not mentioned have their start values. The finder tries each form.
"""


def page() -> str:
    """Text of docs/effects.md."""
    return "\n".join([HEAD, *(line for folder in FOLDERS for line in _part(folder))])


def _part(folder: str) -> Iterator[str]:
    yield f"## {FOLDERS[folder]}\n"
    for path in sorted((PACKAGE / folder).glob("*.py")):
        if not path.stem.startswith("_"):
            yield from _entry(path.stem, import_module(f"bluekoi.{folder}.{path.stem}"))


def _entry(name: str, module: ModuleType) -> Iterator[str]:
    yield f"### `{name}`\n"
    yield f"{module.EFFECT_DESCRIPTION}\n"
    yield _as_markdown(module.__doc__ or "")
    yield f"Acts in {', '.join(module.AFFECTED_CHANNELS)}. Visible in: {module.MOST_VISIBLE_WHERE}."
    if module.CONFUSED_WITH:
        others = ", ".join(f"`{other}`" for other in module.CONFUSED_WITH)
        yield f"Similar candidates, easily confused with it: {others}."
    yield "\n| parameter | symbol | unit | start | from | to | meaning |"
    yield "|---|---|---|---|---|---|---|"
    for one in module.EFFECT_PARAMETERS:
        span = f"{one.start:g} | {one.lower:g} | {one.upper:g}"
        yield f"| `{one.name}` | {one.argument_name} | {one.unit} | {span} | {one.meaning} |"
    if forms := getattr(module, "FUNCTIONAL_FORMS", {}):
        symbols = {one.name: one.argument_name for one in module.EFFECT_PARAMETERS}
        yield f"\nForms: {'; '.join(_form(n, values, symbols) for n, values in forms.items())}."
    yield ""


def _form(name: str, values: Mapping[str, float], symbols: Mapping[str, str]) -> str:
    """A form and the values of its shape parameters."""
    given = ", ".join(f"{symbols[key]} = {value:g}" for key, value in values.items())
    return f"{name} ({given})" if given else name


def _as_markdown(text: str) -> str:
    """A docstring without its heading; indented lines stay formulas."""
    body = text.strip().split("\n", 1)[1:]
    return body[0].strip("\n") + "\n" if body else ""


if __name__ == "__main__":
    (HERE / "effects.md").write_text(page(), encoding="utf-8")
