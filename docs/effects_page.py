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

The axes are surge forward, sway to the left and yaw counter-clockwise. In the formulas, `u` and `v`
are the velocity along and across the core (the rigid body behind the head), `V` the speed, `r` the
yaw rate, `rho` the density of the water, `A` the area of the head plate, `T` the thrust, `f` the
flapping frequency, `phi` the head angle, `alpha` the angle of attack of the head plate, and `X`,
`Y`, `N` are forces in surge and sway and the yaw moment. In the moments `q C_...` of the head, `q`
is the force 1/2 rho A V^2, the dynamic pressure times the area `A`. The coefficients `C_...` are
those of the paper ([The model](paper.md)). All other letters are defined for one candidate at a
time, in its text or in the second column of its table.

In the tables, "start" is the value from which a fit starts, and "from" and "to" are the bounds of a
parameter. Many formulas contain "the part w" or a similar share: 0 gives the simple form of the
effect, and 1 replaces it by the other form.

Starts, bounds, and the numbers with a unit in the formulas are those of the published robot (mass
0.68 kg, length of the body 0.331 m). Those of a robot of mass m and length l follow by similarity:
masses are multiplied by m / 0.68 kg, lengths by l / 0.331 m, times by the square root of l / 0.331
m, and other quantities by what results from their units. A robot of 1 m and 18 kg has 0.52 m/s in
the place of 0.3 m/s, and 265 N in the place of 10 N. The key `robot_units` of mismatch.json states
the three factors.

Below a table, "Forms" lists variants of the effect: published formulas, or other values of a length
or of a time, such as a short lag. In brackets are the values of the shape parameters that give the
form; shape parameters that are not mentioned have their start values. The finder tries each form.
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
        yield f"| `{one.name}` | {one.argument} | {one.unit} | {span} | {one.meaning} |"
    if forms := getattr(module, "FUNCTIONAL_FORMS", {}):
        symbols = {one.name: one.argument for one in module.EFFECT_PARAMETERS}
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
