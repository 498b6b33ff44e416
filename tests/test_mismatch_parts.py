"""Faults of measuring in a part of the trials: which part and which fault; nothing is invented."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from measured import Measured, measured
from pipeline.files import plain
from pipeline.fitting import Series
from pipeline.integrate import compiled
from pipeline.mismatch import Bench, Trialled, find_mismatch, trialled
from pipeline.mismatch.find import KINDS
from pipeline.mismatch.parts import LEAST, Part, part_of_trials, parts_of, with_part
from pipeline.mismatch.setting import PART_FLAG, steady_errors
from pipeline.mismatch.story import mismatch_json
from pipeline.model import plates
from pipeline.study import Study
from pipeline.synthetic.design import bare_design
from pipeline.tuning import Tuned, thin, tune

KERNEL = compiled(plates())


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Measured:
    return measured(bare_design(seed=31), tmp_path_factory.mktemp("bare"))


def test_a_scale_that_is_wrong_at_one_frame_rate_is_told_with_its_trials(bare: Measured) -> None:
    """Every other trial filmed with other settings, in which all lengths come out 6 % too long."""
    odd = {s.name for s in bare.series[::2]}
    study = _two_rates(bare, odd)
    seen = [_stretched(s, 1.06) if s.name in odd else s for s in bare.series]
    found = find_mismatch(study, seen, bare.steady, progress=lambda _: None)
    told = plain(mismatch_json(found, study, seen))
    assert [c["name"] for c in told["causes"]] == ["scale_error"]
    assert told["sentence"].startswith("The measurement is at fault: scale_error (in 6 trials")
    cause, size = told["causes"][0], told["causes"][0]["parameters"]["k"]
    named = {s.name for s in seen if s.name in cause["regime"]}
    assert named in (odd, {s.name for s in seen} - odd)
    assert size["value"] == pytest.approx(0.06 if named == odd else -0.057, abs=0.008)
    after, before = (told["held_out"][k]["path_rmse_m"] for k in ("extended", "baseline"))
    assert after < 0.5 * before


def test_no_part_is_foretold_much_where_nothing_is_wrong(bare: Measured) -> None:
    part = part_of_trials(*_fitted(bare, thin(bare.series)))
    assert part is None or part.ahead < 0.5 * LEAST


def test_the_part_that_is_foretold_most_is_the_one(bare: Measured) -> None:
    few = thin(bare.series)
    seen = [_stretched(s, 1.04) if k >= 4 else s for k, s in enumerate(few)]
    part = part_of_trials(*_fitted(bare, seen))
    assert part is not None
    assert part.ahead > LEAST
    assert {*part.trials} in ({s.name for s in few[4:]}, {s.name for s in few[:4]})
    assert part.cause in {"scale_error", "uncorrected_refraction"}


def test_parts_are_beginnings_ends_and_frame_rates(bare: Measured) -> None:
    names = [t.trial_id for t in bare.study.trials]
    odd = {*names[::2]}
    study = _two_rates(bare, odd)
    parts = set(parts_of(study, bare.series))
    assert frozenset(odd) in parts
    assert frozenset({*names} - odd) in parts
    assert frozenset(names[:3]) in parts
    assert frozenset(names[3:]) in parts


def test_a_trial_not_fitted_at_the_border_of_a_part_is_left_open(bare: Measured) -> None:
    names = [t.trial_id for t in bare.study.trials]
    fitted = [s for s in bare.series if s.name not in {names[4], names[9]}]
    study = _two_rates(bare, set())
    sure, doubtful = parts_of(study, fitted)[frozenset(names[:4])]
    assert sure == frozenset(names[:4])
    assert doubtful == frozenset({names[4]})


def test_no_part_has_fewer_trials_than_three(bare: Measured) -> None:
    parts = parts_of(_two_rates(bare, set()), bare.series)
    assert min(map(len, parts)) == 3


def test_outside_the_part_no_fault_acts_and_nothing_is_told_of_one(bare: Measured) -> None:
    told = [
        replace(s, evidence={"scale": (0.0, 0.01), "clock_ratio": (0.0, 0.01)}) for s in bare.series
    ]
    names = tuple(s.name for s in told[:3])
    out = with_part(KERNEL, told, Part("scale_error", names, 99.0))
    slot = KERNEL.system.constants.index(PART_FLAG)
    assert [s.constants[slot] for s in out] == [1.0] * 3 + [0.0] * (len(out) - 3)
    assert [{*s.evidence} for s in out] == [{"clock_ratio"}] * 3 + [set()] * (len(out) - 3)


def test_steady_errors_outside_a_part_are_those_without_the_fault(bare: Measured) -> None:
    tuned = tune(thin(bare.series))
    base = tuned.base.copy()
    base[KERNEL.system.slot["clock_error.k"]] = 0.3
    wrong = replace(tuned, base=base)

    def speed_error(model: Tuned, series: Sequence[Series]) -> float:
        errors = steady_errors(bare.study, KERNEL, model, series, bare.steady)
        return errors["speed_error_pct"]

    outside = with_part(KERNEL, bare.series, Part("clock_error", (), 99.0))
    assert speed_error(wrong, outside) == pytest.approx(speed_error(tuned, bare.series))
    assert speed_error(wrong, bare.series) > 2 * speed_error(tuned, bare.series)


def _two_rates(bare: Measured, odd: set[str]) -> Study:
    trials = [t.model_copy(update={"fps": 60.0 if t.trial_id in odd else 30.0})
              for t in bare.study.trials]  # fmt: skip
    return bare.study.model_copy(update={"trials": tuple(trials)})


def _fitted(bare: Measured, few: list[Series]) -> tuple[Bench, Study, Trialled]:
    """What `part_of_trials` takes, around the model without effects."""
    tuned = tune(few)
    names = tuple(e.name for e in plates().effects if e.kind in KINDS)
    bench = Bench(KERNEL, few, tuned.base, names, tuned.fit.free, lambda _: None)
    return bench, bare.study, trialled(KERNEL, (), tuned.fit, tuned.noise, few)


def _stretched(one: Series, by: float) -> Series:
    """Everything seen `by` times as far from the middle of the pool."""
    seen = one.seen.copy()
    names = KERNEL.system.constants
    middle = 0.5 * one.constants[[names.index("L_pool"), names.index("W_pool")]]
    seen[:, :2] = middle + by * (seen[:, :2] - middle)
    return replace(one, seen=seen)
