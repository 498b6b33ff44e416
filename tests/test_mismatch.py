"""The search on studies whose truth is known: named right, or nothing found where nothing is."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import beta

from measured import Measured, measured, swung
from pipeline.camera.displacement import lens_strength
from pipeline.data import Flapping
from pipeline.faults import Fault
from pipeline.files import plain
from pipeline.fitting import (
    Fit,
    Free,
    Normal,
    Series,
    filter_all,
    fit_noise,
    smooth,
    spread_over_trials,
)
from pipeline.integrate import Kernel, compiled
from pipeline.mismatch import (
    Bench,
    Found,
    find_mismatch,
    folds,
    forms,
    pays,
    reliability,
    select,
    weights,
)
from pipeline.mismatch.covariance import spread_of
from pipeline.mismatch.details import details
from pipeline.mismatch.direct import with_direct
from pipeline.mismatch.find import KINDS, verdict_of
from pipeline.mismatch.horizon import begun, path_errors, well_seen
from pipeline.mismatch.judge import Trialled, inflation, kept_shapes, p_value_of, step_of_rest
from pipeline.mismatch.jumps import jumps, with_jumps
from pipeline.mismatch.locate import added_force
from pipeline.mismatch.nameless import (
    dropped,
    not_a_crowd,
    tells,
    without_doubtful,
    without_proxies,
)
from pipeline.mismatch.paying import opens
from pipeline.mismatch.rounds import Round, settled
from pipeline.mismatch.search import held_shapes, screened
from pipeline.mismatch.select import _level, _outdone, two_more
from pipeline.mismatch.setting import held_out_trials
from pipeline.mismatch.story import causes, mismatch_json, rivals, weights_in_place
from pipeline.mismatch.weighing import SELDOM
from pipeline.mismatch.words import sentence
from pipeline.model import plates
from pipeline.stages.layout import Layout
from pipeline.stages.mismatch import (
    CLOCK_STD,
    from_the_nose,
    rigid_evidence,
    with_clock,
    with_delay,
    with_rigid_distances,
)
from pipeline.study import Study
from pipeline.synthetic.design import bare_design
from pipeline.tuning import thin, tune
from pipeline.tuning.identify import profiles


def _bench(demo: tuple[Measured, Found]) -> Bench:
    """What the search of the demo shared: the trials it fitted, all candidates."""
    m, found = demo
    few = [s for s in thin(m.series) if s.name not in found.held_out]
    names = tuple(e.name for e in plates().effects if e.kind in KINDS)
    return Bench(compiled(plates()), few, found.baseline.base, names, found.baseline.fit.free,
                 lambda _: None)  # fmt: skip


def test_demo_names_the_fin_and_the_damping_hidden_beside_it(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    told = plain(mismatch_json(found, m.study, m.series))
    assert told["verdict"] == "physics"
    assert {c["name"] for c in told["causes"]} == {"tail_fin_lift", "linear_yaw_damping"}
    damping = next(c for c in told["causes"] if c["name"] == "linear_yaw_damping")
    value, std = (damping["parameters"]["N_r"][k] for k in ("value", "std"))
    assert abs(value - 0.03) < 3 * std
    assert damping["parameters"]["N_r"]["unit"] == "N m s"


def test_demo_predicts_trials_that_were_not_fitted(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    held = plain(mismatch_json(found, m.study, m.series))["held_out"]
    assert held["extended"]["path_rmse_m"] < 0.2 * held["baseline"]["path_rmse_m"]
    assert held["extended"]["radius_error_pct"] < 2
    assert held["extended"]["speed_error_pct"] < 1
    fitted = {s.name for s in m.series} - set(held["trials"])
    assert 0 < len(held["trials"]) <= len(m.series) / 3
    assert len(fitted) + len(held["trials"]) == len(m.series)


def test_demo_tells_where_the_fin_and_the_damping_push(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    where = plain(mismatch_json(found, m.study, m.series))["where"]
    assert {w["channel"] for w in where} <= {"sway", "yaw"}
    assert where[0]["variable"] in {"sway_speed_m_s", "yaw_rate_rad_s", "angle_of_attack_rad"}
    assert where[0]["share"] > 0.4


def test_force_of_an_addition_is_what_its_law_gives(demo: tuple[Measured, Found]) -> None:
    """N = -N_r r of a damping switched on, in yaw alone."""
    m, found = demo
    kernel, few = compiled(plates()), thin(m.series)[:4]
    off = found.baseline.trial_values(kernel, few)
    on = [v.copy() for v in off]
    for v in on:
        v[kernel.system.slot["linear_yaw_damping.N_r"]] = 0.02
    noise = found.baseline.noise
    rates = [smooth(f)[0][:, 5] for f in filter_all(kernel, few, on, noise)]
    for force, r in zip(added_force(kernel, few, on, off, noise), rates, strict=True):
        assert force[:, 2] == pytest.approx(-0.02 * r, abs=2e-5)
        assert np.abs(force[:, :2]).max() < 2e-4


def test_demo_details_are_complete(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    told = plain(details(found))
    assert set(told["forces"]) == {s.name for s in m.series}
    assert {"name", "held_out_gain", "parameters"} <= set(told["candidates"][0])
    assert told["coefficients"]["before"]["C_T"]["value"] > 0
    assert plain(mismatch_json(found, m.study, m.series))["where"][0]["share"] > 0.05


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Measured:
    return measured(bare_design(seed=31), tmp_path_factory.mktemp("bare"))


def test_nothing_hidden_is_none(bare: Measured) -> None:
    m = bare
    found = find_mismatch(m.study, m.series, m.steady, progress=lambda _: None)
    told = plain(mismatch_json(found, m.study, m.series))
    assert told["verdict"] == "none"
    assert told["causes"] == []


def test_a_knocked_camera_is_told_from_one_trial(bare: Measured) -> None:
    """From the middle of one trial on all is seen 9 mm away, as by a camera that was pushed."""
    knocked = [one if k != 3 else _displaced(one, np.array([0.008, -0.004]))
               for k, one in enumerate(bare.series)]  # fmt: skip
    found = find_mismatch(bare.study, knocked, bare.steady, progress=lambda _: None)
    told = plain(mismatch_json(found, bare.study, knocked))
    assert told["verdict"] == "measurement"
    assert [c["name"] for c in told["causes"]] == ["camera_shift"]
    size = told["causes"][0]["parameters"]
    assert size["dx"]["value"] == pytest.approx(0.008, abs=0.0015)
    assert size["dy"]["value"] == pytest.approx(-0.004, abs=0.0015)
    for name, true in (("dx", 0.008), ("dy", -0.004)):
        assert 1e-5 < size[name]["std"] < 0.001
        assert abs(size[name]["value"] - true) < 3 * size[name]["std"]
    assert knocked[3].name not in told["held_out"]["trials"]


def test_knocks_in_several_trials_are_one_camera_s(bare: Measured) -> None:
    """Each its own way: the size told is that of the surest, the others go with it."""
    sizes = {1: (0.006, -0.003), 4: (-0.004, 0.006), 6: (0.001, 0.007)}
    knocked = [_displaced(one, np.array(sizes[k])) if k in sizes else one
               for k, one in enumerate(bare.series)]  # fmt: skip
    found = find_mismatch(bare.study, knocked, bare.steady, progress=lambda _: None)
    told = plain(mismatch_json(found, bare.study, knocked))
    assert [c["name"] for c in told["causes"]] == ["camera_shift"]
    size = told["causes"][0]["parameters"]
    off = [np.hypot(size["dx"]["value"] - x, size["dy"]["value"] - y) for x, y in sizes.values()]
    assert min(off) < 0.0015
    assert all(knocked[k].name in told["causes"][0]["regime"] for k in sizes)
    assert not {knocked[k].name for k in sizes} & set(told["held_out"]["trials"])


def test_jumps_are_found_where_and_when_they_are(bare: Measured) -> None:
    kernel, few = compiled(plates()), thin(bare.series)
    few[2] = _displaced(few[2], np.array([-0.005, 0.006]))
    tuned = tune(few)
    found = jumps(kernel, few, tuned.trial_values(kernel, few), tuned.noise)
    assert [j.trial for j in found] == [few[2].name]
    assert found[0].time_s == pytest.approx(few[2].times[len(few[2].times) // 2], abs=0.11)
    assert found[0].displacement == pytest.approx([-0.005, 0.006], abs=0.002)
    slot = kernel.system.constants.index("t_shift")
    told = [s.constants[slot] < 1e3 for s in with_jumps(kernel, few, found)]
    assert told == [k == 2 for k in range(len(few))]


def _displaced(one: Series, by: np.ndarray) -> Series:
    seen = one.seen.copy()
    seen[len(seen) // 2 :, :2] += by
    return replace(one, seen=seen)


def test_a_lag_begins_each_stretch_where_the_filter_had_it(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    kernel, base = compiled(plates()), found.baseline.base.copy()
    base[kernel.system.slot["lift_lag.k"]] = 0.8
    lagging = replace(found.baseline, base=base)
    turning = next(s for s, t in zip(m.series, m.study.trials, strict=True) if t.head_angle_deg)
    first, second, *_ = begun(kernel, lagging, [turning], 2.0)
    states = [kernel.system.all_states.index(n) for n in kernel.system.effect("lift_lag").states]
    assert np.all(first.mean[states] == turning.mean[states])
    assert np.any(np.abs(second.mean[states]) > 1e-4)


def test_shapes_known_beforehand_are_held_until_freeing_them_pays(
    demo: tuple[Measured, Found],
) -> None:
    _, found = demo
    kernel = compiled(plates())
    tried = next(t for t in found.choice.rounds[0].tried if t.effects == ("tail_fin_lift",))
    assert set(held_shapes(kernel, tried)) == {f"tail_fin_lift.{shape}" for shape in "bpg"}
    free = {f.name for f in tried.fit.free}
    assert {"tail_fin_lift.S", "tail_fin_lift.a"} <= free


def test_held_out_trials_follow_the_roles_of_a_study(demo: tuple[Measured, Found]) -> None:
    m, _ = demo
    given = [t.model_copy(update={"role": "held_out" if t.trial_id == "T05" else "fit"})
             for t in m.study.trials]  # fmt: skip
    study = m.study.model_copy(update={"trials": tuple(given)})
    assert held_out_trials(study, [t.trial_id for t in given]) == ["T05"]


def test_folds_never_part_a_condition(demo: tuple[Measured, Found]) -> None:
    m, _ = demo
    parts = folds(m.series)
    where = {c: {k for k, part in enumerate(parts) for i in part if m.series[i].condition == c}
             for c in {s.condition for s in m.series}}  # fmt: skip
    assert sum(len(p) for p in parts) == len(m.series)
    assert all(len(k) == 1 for k in where.values())


def test_one_trial_alone_foretells_nothing_and_breaks_nothing(demo: tuple[Measured, Found]) -> None:
    m, _ = demo
    one = next(t for t in m.study.trials if t.head_angle_deg)
    series = [s for s in m.series if s.name == one.trial_id]
    study = m.study.model_copy(update={"trials": (one,)})
    found = find_mismatch(study, series, m.steady, progress=lambda _: None)
    told = plain(mismatch_json(found, study, series))
    assert told["verdict"] in {"none", "physics", "measurement", "unexplained"}
    assert told["where"] == []
    assert told["causes"] == [] or told["verdict"] != "none"


def test_weights_follow_the_worth_over_the_inflation(demo: tuple[Measured, Found]) -> None:
    _, found = demo
    best = found.choice.chosen
    lower = best.total - best.inflation
    told = weights({"a": best.total, "b": best.total, "c": lower}, best.inflation)
    assert told["a"] == told["b"] == pytest.approx(1 / (2 + np.exp(-1)))
    assert sum(told.values()) == pytest.approx(1)


@pytest.mark.parametrize(
    ("low", "high", "true", "of"),
    [(10, 20, 2, 5), (20, 40, 9, 11), (40, 80, 13, 14), (80, 1000, 94, 94)],
)
def test_reliability_is_what_96_concealed_studies_showed(
    low: float, high: float, true: int, of: int
) -> None:
    """Within what chance allows (95 %, Clopper and Pearson) at the middle of each range."""
    told = reliability(np.sqrt(low * high))
    assert beta.ppf(0.025, true, of - true + 1) < told
    assert told < (1.0 if true == of else beta.ppf(0.975, true + 1, of - true))


def test_a_held_shape_widens_what_is_said_of_a_strength(demo: tuple[Measured, Found]) -> None:
    """A fin whose spread along the body is held: its area could be another, C_T could not."""
    _, found = demo
    bench = _bench(demo)
    model = bench.settled(bench.refit(found.choice.chosen.effects, found.choice.bare))
    assert set(held_shapes(bench.kernel, model)) == {f"tail_fin_lift.{k}" for k in "bpg"}
    names = [f.name for f in model.fit.free]
    wide = np.diag(spread_of(bench, model).cov)
    narrow = np.diag(spread_over_trials(model.fit.normal).cov)
    ratio = dict(zip(names, np.sqrt(wide / narrow), strict=True))
    assert all(r >= 1.0 for r in ratio.values())
    assert ratio["tail_fin_lift.S"] > 1.1
    assert ratio["C_T"] < 1.1


def _one_number(own: np.ndarray, information: np.ndarray) -> Fit:
    """A fit of one strength to trials that each say `own` with `information`."""
    value = float(np.sum(own * information) / np.sum(information))
    normal = Normal(information[:, None, None], (information * (own - value))[:, None],
                    np.zeros(len(own)))  # fmt: skip
    return Fit((Free("linear_yaw_damping.N_r"),), np.array([value]), normal, "converged", 1)


def _chance(kernel: Kernel, found: Fit) -> float:
    return p_value_of(kernel, found, "linear_yaw_damping", inflation(kernel, found))


def test_one_trial_alone_makes_nothing_sure() -> None:
    kernel = compiled(plates())
    own = np.r_[0.03, np.zeros(17)]
    one = _one_number(own, 1e6 * np.r_[100.0, np.ones(17)])
    assert one.values[0] / np.sqrt(one.naive_cov[0, 0]) > 100
    assert _chance(kernel, one) > 0.1
    shared = 0.03 + 0.003 * np.cos(np.arange(18))
    assert _chance(kernel, _one_number(shared, np.full(18, 1e6))) < 1e-9


def test_missing_trials_are_a_fault(tmp_path: Path) -> None:
    from pipeline.campaign import Campaign
    from pipeline.stages.tuning import campaign_series
    from pipeline.study import load_study
    from pipeline.synthetic.campaign import write_study_files

    write_study_files(bare_design(), tmp_path, source="keypoints/{}.csv", fps=30.0)
    with pytest.raises(Fault, match="no trial with a track"):
        campaign_series(Campaign(load_study(tmp_path)))


def test_scale_of_the_rigid_distances_counts_once(demo: tuple[Measured, Found]) -> None:
    m, _ = demo
    told = with_rigid_distances(
        m.series, {"scale": 1.02, "scale_std": 0.004, "likely": "scale_error"}, m.study.setup
    )
    values = np.array([s.evidence["scale"] for s in told])
    assert values[:, 0] == pytest.approx(0.02)
    assert np.sum(1 / values[:, 1] ** 2) == pytest.approx(1 / (0.004**2 + 0.003**2))
    assert all("clock_ratio" in s.evidence for s in told if "clock_ratio" in m.series[0].evidence)


def test_only_placed_keypoints_are_seen_from_the_nose(
    demo: tuple[Measured, Found], tmp_path: Path
) -> None:
    """Where lengths were placed, the nose is what was seen; files and dots were measured."""
    m, _ = demo
    slots, layout = plates().constants, Layout(tmp_path)
    filmed = m.study.model_copy(update={"trials": tuple(
        t.model_copy(update={"source": f"v/{t.trial_id}.mp4"}) for t in m.study.trials
    )})  # fmt: skip

    def ahead(study: Study, source: str) -> np.ndarray:
        for one in m.series:
            layout.detection(one.name).parent.mkdir(parents=True, exist_ok=True)
            layout.detection(one.name).write_text(json.dumps({"source": source}))
        told = from_the_nose(m.series, study, layout)
        return np.array([s.constants[slots.index("ahead")] for s in told])

    assert not ahead(m.study, "deeplabcut").any()
    assert not ahead(filmed, "markers").any()
    hinge = m.study.setup.robot.hinge_to_com_m
    reach = [s.constants[slots.index("h")] * np.cos(s.inputs[0, 0]) + hinge for s in m.series]
    assert ahead(filmed, "silhouette") == pytest.approx(reach)


@pytest.mark.parametrize(
    "geometry",
    [{}, {"scale": None, "scale_std": None, "likely": "unknown"},
     {"scale": 1.02, "scale_std": 0.004, "likely": "keypoint_bias"}],
)  # fmt: skip
def test_scale_is_not_evidence_where_another_error_bends_it(
    demo: tuple[Measured, Found], geometry: dict[str, object]
) -> None:
    m, _ = demo
    told = with_rigid_distances(m.series, geometry, m.study.setup)
    assert all("scale" not in s.evidence for s in told)


@pytest.mark.parametrize(
    ("likely", "rivals", "told"),
    [("nothing", [], {"scale": 0.014, "lens": 0.0, "bend": 0.0}),
     ("uncorrected_refraction", [], {"scale": 0.014, "lens": 0.0, "bend": -0.014}),
     ("uncorrected_refraction", ["scale_error"], {"scale": 0.014}),
     ("lens_error", ["scale_error"], {})],
)  # fmt: skip
def test_the_pattern_of_rigid_distances_is_evidence(
    demo: tuple[Measured, Found], likely: str, rivals: list[str], told: dict[str, float]
) -> None:
    m, _ = demo
    geometry = {"scale": 1.014, "scale_std": 0.0004, "likely": likely, "rivals": rivals}
    for one in with_rigid_distances(m.series, geometry, m.study.setup):
        found = {k: v for k, (v, _) in one.evidence.items() if k != "clock_ratio"}
        assert found == pytest.approx(told)


def test_profiles_of_a_model_that_lacks_something_have_their_top_at_the_fit(
    demo: tuple[Measured, Found],
) -> None:
    m, found = demo
    few = [s for s in thin(m.series) if s.name not in found.held_out]
    drawn = profiles(few, found.baseline)
    for told, best in zip(drawn, found.baseline.fit.values, strict=True):
        assert np.all(told.lost > -0.05)
        assert np.all(np.diff(told.lost[told.values < best]) < 0)


@pytest.mark.parametrize(("p_value", "sureness"), [(1e-13, 7.44), (0.0, 14.9)])
def test_a_lens_that_the_rigid_distances_find_wrong_is_evidence_as_sure_as_its_chance(
    demo: tuple[Measured, Found], p_value: float, sureness: float
) -> None:
    m, _ = demo
    estimate = {"name": "lens_error", "parameters": ["focal", "k1"], "values": [0.0, -0.05],
                "p_value": p_value}  # fmt: skip
    geometry = {"scale": 1.03, "scale_std": 0.002, "likely": "lens_error", "rivals": [],
                "estimates": [estimate]}  # fmt: skip
    told = rigid_evidence(geometry, m.study.setup)
    assert list(told) == ["lens"]
    strength, std = told["lens"]
    assert strength == pytest.approx(lens_strength(m.study.setup, {"k1": -0.05}))
    assert std == pytest.approx(np.hypot(strength / sureness, 0.0005), rel=0.01)
    estimate["values"] = [-0.9, 0.0]  # no camera has such a lens
    assert rigid_evidence(geometry, m.study.setup) == {}


def test_the_sentence_says_on_which_trials(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    causes = mismatch_json(found, m.study, m.series)["causes"]
    assert "on trials not fitted the path error falls" in sentence(found, causes, [])
    small = replace(found, held_out=[f.name for f in found.forces])
    assert "on the fitted trials (none could be held out)" in sentence(small, causes, [])


def test_what_side_measurements_say_pays_by_itself(demo: tuple[Measured, Found]) -> None:
    """Rigid lengths 1.4 % too long, beside a fin that gains a hundred times as much."""
    _, found = demo
    before = found.choice.chosen
    each = 8.0 / len(before.worth)
    after = replace(before, effects=(*before.effects, "scale_error"), worth=before.worth + each,
                    p_value={**before.p_value, "scale_error": 1e-3})  # fmt: skip
    assert not pays(before, after, found.choice.bare)
    assert pays(before, replace(after, side=before.side + 8.0), found.choice.bare)


@pytest.mark.parametrize(
    ("side", "paths", "paying"),
    [(8.0, -1.0, False), (13.0, -40.0, True), (13.0, -np.inf, False), (-1.5, 300.0, False)],
)  # fmt: skip
def test_what_is_plain_aside_pays_whatever_the_paths_gain_and_nothing_against_it(
    demo: tuple[Measured, Found], side: float, paths: float, paying: bool
) -> None:
    """A lens told by 8 deviations was not named, since one fold of nine trials went astray."""
    _, found = demo
    before = found.choice.chosen
    after = replace(before, effects=(*before.effects, "lens_error"), side=before.side + side,
                    worth=before.worth + paths * before.inflation / len(before.worth),
                    p_value={**before.p_value, "lens_error": 1e-12})  # fmt: skip
    assert pays(before, after, found.choice.bare) == paying


def test_who_does_not_explain_a_side_measurement_is_no_rival_for_its_place(
    demo: tuple[Measured, Found],
) -> None:
    _, found = demo
    bare = found.choice.bare
    told = replace(bare, effects=("scale_error",), side=bare.side + 11.0, worth=bare.worth + 0.1,
                   p_value={"scale_error": 1e-4})  # fmt: skip
    late = replace(bare, effects=("time_offset",), worth=bare.worth + 20.0,
                   p_value={"time_offset": 1e-3})  # fmt: skip
    bent = replace(late, effects=("uncorrected_refraction",), side=told.side,
                   p_value={"uncorrected_refraction": 1e-3})  # fmt: skip
    place = replace(found.choice.rounds[0], before=bare, tried=(late, told))
    assert not _outdone("scale_error", place, told)
    assert _outdone("scale_error", replace(place, tried=(bent, told)), told)
    unsaid = replace(told, side=bare.side)
    assert _outdone("scale_error", replace(place, tried=(late, unsaid)), unsaid)


def test_of_two_that_side_measurements_tell_alike_the_surest_by_the_paths_is_taken(
    demo: tuple[Measured, Found],
) -> None:
    _, found = demo
    bare = found.choice.bare

    def told(name: str, gain: float, p_value: float) -> Trialled:
        return replace(bare, effects=(name,), side=bare.side + 11.0, p_value={name: p_value},
                       worth=bare.worth + gain / len(bare.worth))  # fmt: skip

    refraction, scale = told("uncorrected_refraction", 4.5, 5e-4), told("scale_error", 4.4, 4e-5)
    place = replace(found.choice.rounds[0], before=bare, bare=bare, tried=(refraction, scale))
    assert place.best is scale
    far = told("scale_error", 4.5 - 2.0 * bare.inflation, 4e-5)
    assert replace(place, tried=(refraction, far)).best is refraction


def test_nothing_is_said_where_nothing_is_determined(demo: tuple[Measured, Found]) -> None:
    _, found = demo
    wide = replace(found.baseline, cov=1e6 * found.baseline.cov)
    blind = replace(found, verdict="none", baseline=wide)
    assert "nothing can be said" in sentence(blind, [], [])
    assert "Nothing beyond the noise" in sentence(replace(found, verdict="none"), [], [])


def _late(one: Series, frames: int, rng: np.random.Generator) -> Series:
    """A trial whose film began so many frames before the robot did."""
    still = np.repeat(one.seen[:1], frames, axis=0)
    still += rng.normal(size=still.shape) * np.sqrt(np.einsum("nii->ni", one.noise[:frames]))
    return replace(one, seen=np.concatenate([still, one.seen[:-frames]]))


def test_a_late_start_is_told_with_its_delay(bare: Measured) -> None:
    """0.8 s: far from where a single start of the fit would lead."""
    rng = np.random.default_rng(5)
    late = [_late(one, 24, rng) for one in bare.series]
    found = find_mismatch(bare.study, late, bare.steady, progress=lambda _: None)
    told = plain(mismatch_json(found, bare.study, late))
    assert "time_offset" in {c["name"] for c in told["causes"]}
    assert "motor_spin_up" not in {c["name"] for c in told["causes"]}
    delay = next(c for c in told["causes"] if c["name"] == "time_offset")["parameters"]["d"]
    assert delay["value"] == pytest.approx(0.8, abs=0.03)


def test_a_shape_is_differenced_at_several_places(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    kernel, few = compiled(plates()), thin(m.series)
    before = found.choice.rounds[1].before
    names, base = ["lift_lag", "stall", "battery_sag"], found.baseline.base
    bench = Bench(kernel, few, base, tuple(names), found.baseline.fit.free, lambda _: None)
    predictor = filter_all(kernel, few, bench.points(before), before.noise)
    one = screened(kernel, few, before, base, names, predictor=predictor)
    several = bench.foretold(before, names, predictor)
    assert all(several[name].gain >= one[name].gain for name in one)
    assert several["battery_sag"] == one["battery_sag"]
    assert any(several[name].gain > one[name].gain for name in ("lift_lag", "stall"))


def test_a_model_that_describes_nothing_is_not_called_right(demo: tuple[Measured, Found]) -> None:
    _, found = demo
    wrong = replace(found.choice.bare, inflation=6.0)
    choice = replace(found.choice, chosen=wrong, without={}, places={})
    assert verdict_of(compiled(plates()), choice, wrong) == "unexplained"
    right = replace(wrong, inflation=4.0)
    assert verdict_of(compiled(plates()), replace(choice, chosen=right), right) == "none"
    said = sentence(replace(found, verdict="unexplained", choice=choice, residual=wrong), [], [])
    assert "they do not tell what it lacks" in said
    assert "6 times more than their errors" in said


def test_what_runs_away_has_numbers_that_can_be_read(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    wild = replace(found.choice.bare, inflation=np.inf, worth=np.full_like(found.choice.bare.worth,
                   -np.inf))  # fmt: skip
    choice = replace(found.choice, bare=wild, chosen=wild, without={}, places={})
    told = mismatch_json(replace(found, verdict="unexplained", choice=choice, residual=wild,
                                 extended=found.baseline, nameless_gain=np.nan),
                         m.study, m.series)  # fmt: skip
    assert "differ from trial to trial at will" in told["sentence"]
    assert [c["weight"] for c in told["causes"]] == [pytest.approx(0.0, abs=1e-6)]


def test_a_model_that_runs_away_under_its_own_noise_begins_from_its_first_fit(
    demo: tuple[Measured, Found], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot without a fin and a stall, nine trials: the search had begun from nothing finite."""
    _, found = demo
    bench, first = _bench(demo), found.choice.bare
    wild = replace(first, worth=np.full_like(first.worth, -np.inf))
    monkeypatch.setattr(Bench, "settled", lambda *_: wild)
    monkeypatch.setattr(Bench, "followed", lambda *_: wild)
    assert settled(bench, first, first) is first


@pytest.mark.parametrize(
    ("inflation", "gain", "p_value", "paying"),
    [(6.7, 58.4, 6e-3, True), (31.6, 23.1, 2.6e-2, True), (31.6, 23.1, 6e-2, False),
     (7.4, 6.1, 2.6e-2, False), (4.0, 58.4, 6e-3, False)],
)  # fmt: skip
def test_the_first_effect_beside_a_wrong_model_pays_by_its_gain(
    demo: tuple[Measured, Found], inflation: float, gain: float, p_value: float, paying: bool
) -> None:
    """Fins of nine trials of a made robot: their strength differs by what is missing besides."""
    _, found = demo
    bare = replace(found.choice.bare, inflation=inflation)
    worth = bare.worth + 4.0 * gain / len(bare.worth)
    fin = replace(bare, effects=("tail_fin_lift",), inflation=4.0, worth=worth,
                  p_value={"tail_fin_lift": p_value})  # fmt: skip
    assert pays(bare, fin, bare) is paying


@pytest.mark.parametrize(
    ("inflation", "over", "p_value", "paying"),
    [(1.26, 42.0, 5.6e-3, True), (1.6, 42.0, 5.6e-3, False), (1.26, 30.0, 5.6e-3, False),
     (1.26, 42.0, 2e-2, False)],
)  # fmt: skip
def test_an_addition_that_steadies_the_numbers_pays_where_it_is_not_likely_nothing(
    demo: tuple[Measured, Found], inflation: float, over: float, p_value: float, paying: bool
) -> None:
    """A thrust loss beside a fin and an offset, nine trials of another maker's robot."""
    _, found = demo
    before = replace(found.choice.without["linear_yaw_damping"], inflation=2.72)
    gain = over * inflation
    after = replace(before, effects=(*before.effects, "wave_drag"), inflation=inflation,
                    worth=before.worth + gain / len(before.worth),
                    p_value={**before.p_value, "wave_drag": p_value})  # fmt: skip
    others = 9.0 * gain / len(before.worth)
    bare = replace(before, effects=(), worth=before.worth - others)
    assert pays(before, after, bare) is paying


@pytest.mark.parametrize(("times", "said"), [(1.4, False), (1.6, True)])
@pytest.mark.parametrize("verdict", ["none", "physics", "measurement", "unexplained"])
def test_the_sentence_says_how_much_is_left_over(
    demo: tuple[Measured, Found], verdict: str, times: float, said: bool
) -> None:
    _, found = demo
    after = found.errors["extended"] | {"path_rmse_m": times * found.floor_m}
    left = replace(found, verdict=verdict, errors={**found.errors, "extended": after})
    told = sentence(left, causes(left), [])
    assert ("times what noise explains" in told) == (
        said and (verdict != "unexplained" or "modelled as a residual" in told)
    )
    assert ("explains these recordings" in told) == (verdict == "none" and not said)


def test_both_of_two_beside_a_wrong_model_pay_by_their_gain(demo: tuple[Measured, Found]) -> None:
    """A fin beside a stall, nine trials of a made robot: 25.8 over the inflation, p = 0.015."""
    _, found = demo
    bare = replace(found.choice.bare, inflation=15.8)
    stall = replace(bare, effects=("stall",), inflation=6.8, p_value={"stall": 7e-11},
                    worth=bare.worth + 560.0 / len(bare.worth))  # fmt: skip
    both = replace(stall, effects=("stall", "tail_fin_lift"), inflation=7.3,
                   p_value={"stall": 7e-11, "tail_fin_lift": 1.5e-2},
                   worth=stall.worth + 25.8 * 7.3 / len(bare.worth))  # fmt: skip
    assert opens(stall, both)
    assert not pays(stall, both, bare)
    assert not opens(replace(stall, inflation=4.9), both)


@pytest.mark.parametrize(
    ("over", "chance", "share", "paid"),
    [(45.0, 1.3e-3, 0.24, True), (45.0, 3e-3, 0.24, False), (35.0, 1.3e-3, 0.24, False),
     (45.0, 1.3e-3, 0.15, False), (35.0, 3e-3, 0.35, True)],
)  # fmt: skip
def test_a_cause_that_acts_in_few_trials_pays_by_much_of_all_that_is_gained(
    demo: tuple[Measured, Found], over: float, chance: float, share: float, paid: bool
) -> None:
    _, found = demo
    before = found.choice.without["linear_yaw_damping"]
    gain = over * before.inflation
    after = replace(before, effects=(*before.effects, "wall_effect"),
                    worth=before.worth + gain / len(before.worth),
                    p_value={**before.p_value, "wall_effect": chance})  # fmt: skip
    others = gain * (1.0 / share - 1.0)
    bare = replace(before, effects=(), worth=before.worth - others / len(before.worth))
    assert pays(before, after, bare) == paid


@pytest.mark.parametrize(
    ("inflation", "gain", "freed"),
    [(9.2, 40.0, True), (9.2, 1.0, False), (4.0, 40.0, False)],
)
def test_a_wrong_model_beside_which_nothing_pays_may_take_another_form(
    demo: tuple[Measured, Found], monkeypatch: pytest.MonkeyPatch,
    inflation: float, gain: float, freed: bool,
) -> None:  # fmt: skip
    """An asymmetry in another form than nature's, beside which a trim showed only then."""
    _, found = demo
    bare = found.choice.bare
    held = next(f for f in found.choice.chosen.fit.free if f.name == "tail_fin_lift.S")
    model = replace(bare, effects=("tail_fin_lift",), inflation=inflation,
                    fit=replace(bare.fit, free=(*bare.fit.free, held)))  # fmt: skip
    other = replace(model, inflation=7.0, worth=bare.worth + gain * 7.0 / len(bare.worth))
    asked: list[dict[str, float]] = []
    monkeypatch.setattr(forms, "formed", lambda _b, _m, shapes: asked.append(shapes) or other)
    assert forms.shaped_anyway(_bench(demo), model) is (other if freed else None)
    assert bool(asked) == (inflation > forms.WRONG)
    assert all("tail_fin_lift.p" in shapes for shapes in asked)


def test_noise_is_left_where_the_filter_runs_away(demo: tuple[Measured, Found]) -> None:
    m, found = demo
    kernel, few, baseline = compiled(plates()), thin(m.series)[:3], found.baseline
    wild = [v.copy() for v in baseline.trial_values(kernel, few)]
    for v in wild:
        v[kernel.system.slot["tail_fin_lift.S"]] = 5.0
    assert not all(np.isfinite(f.log_likelihood)
                   for f in filter_all(kernel, few, wild, baseline.noise))  # fmt: skip
    assert fit_noise(kernel, few, wild, baseline.noise) is baseline.noise


def test_a_nameless_term_that_does_as_well_is_told_as_a_rival(
    demo: tuple[Measured, Found],
) -> None:
    _, found = demo
    name = found.choice.chosen.effects[0]
    alone = weights_in_place(found, name)
    level = replace(found, choice=replace(found.choice, ahead={name: SELDOM}))
    shared = weights_in_place(level, name)
    assert shared["unexplained"] == pytest.approx(shared[name])
    assert shared[name] == pytest.approx(alone[name] / (1.0 + alone[name] / sum(alone.values())))
    assert sum(shared.values()) == pytest.approx(sum(alone.values()))
    told = [r for r in rivals(level) if r["name"] == "unexplained"]
    assert len(told) == 1
    assert "without a name" in told[0]["how_to_tell_apart"]


def test_a_rival_close_behind_is_judged_as_the_chosen_was(
    demo: tuple[Measured, Found], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both gain 40 by noise of their own, which must not speak for the chosen one alone."""
    _, found = demo
    bench, chosen = _bench(demo), replace(found.choice.chosen, inflation=2.0)
    name = chosen.effects[0]
    count, rest = len(chosen.worth), tuple(e for e in chosen.effects if e != name)
    own = replace(chosen, effects=(*rest, name), worth=chosen.worth - 40.0 / count)
    near = replace(own, effects=(*rest, "trim_moment"), worth=own.worth - 8.0 / count)
    askew = replace(own.fit, free=(*own.fit.free, Free("head_angle_offset.d")),
                    values=np.append(own.fit.values, 0.01))  # fmt: skip
    far = replace(
        own, effects=(*rest, "head_angle_offset"), worth=own.worth - 30.0 / count, fit=askew
    )
    monkeypatch.setattr(Bench, "renoised", lambda _, model: replace(
        model, worth=model.worth + 40.0 / count, inflation=10.0))  # fmt: skip
    place = replace(found.choice.places[name], tried=(own, near, far))
    told = {t.effects[-1]: t.total for t in _level(bench, name, place, chosen).tried}
    assert told["trim_moment"] == pytest.approx(chosen.total - 8.0)
    assert told["head_angle_offset"] == pytest.approx(far.total)
    assert told[name] == pytest.approx(own.total)


def test_a_further_cause_that_is_more_likely_another_goes(
    demo: tuple[Measured, Found], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, found = demo
    choice, bench = found.choice, _bench(demo)
    assert without_doubtful(bench, choice) is choice
    name = choice.chosen.effects[1]
    asked: list[str] = []
    monkeypatch.setattr("pipeline.mismatch.nameless.dropped",
                        lambda _bench, choice, names: asked.extend(names) or choice)  # fmt: skip
    ahead = replace(choice, ahead={name: SELDOM + 3.0})
    without_doubtful(bench, ahead)
    assert asked == [name]


@pytest.mark.parametrize(
    ("own", "other", "stays"),
    [(0.28, 0.28, False), (0.45, 0.45, True), (0.45, 0.0, False), (0.55, 0.0, True)],
)
def test_a_cause_alone_that_is_more_likely_nothing_goes(
    demo: tuple[Measured, Found], monkeypatch: pytest.MonkeyPatch,
    own: float, other: float, stays: bool,
) -> None:  # fmt: skip
    """A null in which a start 17 ms late had 0.28, and so had a motor that spins up."""
    _, found = demo
    name = found.choice.chosen.effects[0]
    alone = replace(found.choice, chosen=replace(found.choice.chosen, effects=(name,)))
    monkeypatch.setattr("pipeline.mismatch.nameless.shares_in_place",
                        lambda *_: {name: own, "motor_spin_up": other})  # fmt: skip
    kept = without_doubtful(_bench(demo), alone)
    assert kept.chosen.effects == ((name,) if stays else ())


def test_a_tail_beat_off_by_another_share_in_each_trial_is_no_wrong_clock() -> None:
    """2.5 % slow in all trials; then 1, 4 and 8 % at three powers, as a supply that sags."""
    none = np.zeros(1)
    series = [Series(f"T{i}", "", "", none, none, none, none, none, none, none) for i in range(9)]

    def told(ratios: list[float], source: str = "motor_log") -> list[tuple[float, float]]:
        beats = {
            s.name: Flapping(4.0, 0.0, source, video_hz=4.0 * (1 + k), video_hz_std=0.002)
            for s, k in zip(series, ratios, strict=True)
        }
        return [s.evidence["clock_ratio"] for s in with_clock(series, beats)]

    for ratio, std in told([-0.025] * 9):
        assert (ratio, std) == pytest.approx((-0.025, CLOCK_STD), rel=0.02)
    apart = told([-0.01] * 3 + [-0.04] * 3 + [-0.08] * 3)
    together = np.mean([std for _, std in apart]) / 3  # of nine trials
    assert together > np.std([-0.01, -0.04, -0.08])
    stated = np.mean([std for _, std in told([-0.025] * 9, "flap_hz")]) / 3
    assert stated == pytest.approx(0.05, rel=0.01)  # a motor that no log has seen may be slow


def test_a_log_ahead_of_the_video_is_a_time_offset_that_no_path_tells(bare: Measured) -> None:
    """Lags as of a log 0.25 s ahead: one measurement, told once, of a number of its own."""
    hz = {s.name: float(s.inputs[-1, 1]) for s in bare.series}
    beats = {
        name: replace(bare.flapping[name], flap_hz=f, agrees=True, beat_lag_std_rad=0.03,
                      beat_lag_rad=float(np.angle(np.exp(1j * (0.7 - 2 * np.pi * f * 0.25)))))
        for name, f in hz.items()
    }  # fmt: skip
    told = with_delay(bare.series, beats, fitted=len(bare.series))
    values = np.array([s.evidence["delay"] for s in told])
    assert values[:, 0] == pytest.approx(0.25, abs=0.01)
    assert np.sum(values[:, 1] ** -2.0) ** -0.5 == pytest.approx(0.03, abs=0.01)
    found = find_mismatch(bare.study, told, bare.steady, progress=lambda _: None)
    wrote = plain(mismatch_json(found, bare.study, told))
    assert [c["name"] for c in wrote["causes"]] == ["time_offset"]
    size = wrote["causes"][0]["parameters"]["e"]
    assert size["value"] == pytest.approx(0.25, abs=0.02)
    assert 0.02 < size["std"] < 0.05


def test_a_number_of_which_no_trial_tells_is_neither_fitted_nor_a_held_shape(
    demo: tuple[Measured, Found],
) -> None:
    bench = _bench(demo)
    assert not any("delay" in s.evidence for s in bench.series)
    model = bench.refit(("time_offset",), demo[1].choice.bare)
    assert "time_offset.e" not in {f.label for f in model.fit.free}
    assert held_shapes(bench.kernel, model) == {}


def test_a_rival_whose_strength_may_be_nothing_takes_no_place(demo: tuple[Measured, Found]) -> None:
    _, found = demo
    chosen, name = found.choice.chosen, found.choice.chosen.effects[0]
    better = replace(
        chosen,
        effects=("stall",),
        worth=chosen.worth + 10 * chosen.inflation,
        p_value={"stall": 0.5},
    )
    place = replace(found.choice.places[name], tried=(better,))
    assert not _outdone(name, place, chosen)
    sure = replace(better, p_value={"stall": 1e-4})
    assert _outdone(name, replace(place, tried=(sure,)), chosen)
    own = [f for f in chosen.fit.free if f.name.startswith(name)]
    little = replace(sure, worth=chosen.worth + 0.5 * chosen.inflation / len(chosen.worth))
    as_many = replace(little, fit=replace(little.fit, free=tuple(Free("stall.k") for _ in own)))
    assert not _outdone(name, replace(place, tried=(as_many,)), chosen)
    fewer = replace(as_many, fit=replace(as_many.fit, free=as_many.fit.free[1:]))
    assert _outdone(name, replace(place, tried=(fewer,)), chosen)
    unsure = replace(place, tried=(replace(fewer, p_value={"stall": 9e-3}),))
    level = replace(place.before, worth=chosen.worth - 2 * chosen.inflation / len(chosen.worth))
    assert not _outdone(name, replace(unsure, before=level), chosen)
    doubtful = replace(found.choice, places={**found.choice.places, name: place})
    told = weights_in_place(replace(found, choice=doubtful), name)
    assert told["stall"] == told[name] > 0.1


def test_two_names_must_gain_clearly_more_than_terms_without_one(
    demo: tuple[Measured, Found], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, found = demo
    bench, choice = _bench(demo), found.choice
    before = replace(choice, chosen=choice.without["linear_yaw_damping"])
    before = replace(before, rounds=(replace(choice.rounds[0], before=before.chosen),))
    gain = choice.chosen.total - before.chosen.total

    def unnamed(part: float, *more: str) -> Trialled:
        worth = before.chosen.worth + part * gain / len(before.chosen.worth)
        effects = (*before.chosen.effects, "residual.c7", *more)
        return replace(before.chosen, worth=worth, effects=effects)

    both = (choice.rounds[0], choice.chosen, choice.without)
    monkeypatch.setattr(select, "two_at_once", lambda *_: both)
    monkeypatch.setattr(select, "places_of", lambda *_: choice.places)
    monkeypatch.setattr(Bench, "renoised", lambda _, model: model)
    assert two_more(bench, before, unnamed(0.9)) is before
    assert two_more(bench, before, unnamed(0.5)).chosen is choice.chosen
    assert two_more(bench, before, unnamed(0.9, "residual.c1")).chosen is choice.chosen
    assert two_more(bench, before, unnamed(1.1, "residual.c1")) is before
    monkeypatch.setattr(select, "two_at_once", lambda *_: None)
    assert two_more(bench, before, unnamed(0.5)) is before
    full = replace(before.chosen, effects=("stall", "sinking", "added_mass"))
    monkeypatch.setattr(select, "two_at_once", lambda *_: pytest.fail("a fifth cause"))
    assert two_more(bench, replace(before, chosen=full), full).chosen is full


@pytest.mark.parametrize(("ahead", "goes"), [(1.0, True), (-1.0, False)])
def test_names_that_share_the_work_of_one_term_go_together(
    demo: tuple[Measured, Found], monkeypatch: pytest.MonkeyPatch, ahead: float, goes: bool
) -> None:
    """One term beside the strongest cause does better than all other names together, or not."""
    _, found = demo
    bench, choice, fin = _bench(demo), found.choice, "tail_fin_lift"
    names = (fin, "crossflow_drag", "added_mass")
    chosen = replace(choice.chosen, effects=names)
    alone = replace(choice.without["linear_yaw_damping"], effects=(fin,))
    without = {e: alone if e != fin else choice.without[fin] for e in names}
    crowd = replace(choice, chosen=chosen, without=without)
    one = replace(chosen, effects=(fin, "residual.b7"), p_value={"residual.b7": 1e-9},
                  worth=chosen.worth + ahead * chosen.inflation)  # fmt: skip
    place = Round(choice.bare, alone, {}, (one,))
    monkeypatch.setattr("pipeline.mismatch.nameless.one_round", lambda *_, **__: place)
    monkeypatch.setattr("pipeline.mismatch.nameless.anew", lambda _, model: model)
    left = replace(choice, chosen=alone)
    monkeypatch.setattr("pipeline.mismatch.nameless.dropped", lambda *_: left)
    monkeypatch.setattr("pipeline.mismatch.nameless.tells", lambda *_: True)
    monkeypatch.setattr(Bench, "less", lambda *_: alone)
    assert not_a_crowd(bench, crowd) is (left if goes else crowd)
    with monkeypatch.context() as silent:
        silent.setattr("pipeline.mismatch.nameless.tells", lambda *_: False)
        assert not_a_crowd(bench, crowd) is crowd
    told = replace(crowd, chosen=replace(chosen, side=alone.side + 20.0))
    assert not_a_crowd(bench, told) is told
    assert not_a_crowd(bench, choice) is choice


def test_the_rest_moves_no_shape_that_it_cannot_tell() -> None:
    """Strength, shape and a coefficient of three trials; the shape is the first trial's."""
    hessian = np.array([np.diag([4.0, 99.0, 1.0]), np.diag([4.0, 0.5, 1.0]),
                        np.diag([4.0, 0.5, 1.0])])  # fmt: skip
    hessian[0, 0, 1] = hessian[0, 1, 0] = 3.0
    normal = Normal(hessian, np.array([[-2.0, 1.0, 0.0], [1.0, 2.0, 3.0], [1.0, -3.0, -3.0]]),
                    np.zeros(3))  # fmt: skip
    shape, nothing = np.array([False, True, False]), np.zeros(3, bool)
    first, last = np.array([0]), np.array([2])
    assert kept_shapes(normal, first, shape, nothing).tolist() == [False, True, False]
    without = step_of_rest(normal, first, kept_shapes(normal, first, shape, nothing))
    assert without == pytest.approx([2.0 / 8.0, 0.0, 0.0], rel=1e-5, abs=1e-12)
    told = step_of_rest(normal, last, kept_shapes(normal, last, shape, nothing))
    rest = hessian[:2].sum(axis=0)
    assert told == pytest.approx(np.linalg.solve(rest, [-1.0, 3.0, 3.0]), rel=1e-3)
    held = step_of_rest(normal, last, kept_shapes(normal, last, shape, shape))
    assert held == pytest.approx([-1.0 / 8.0, 0.0, 1.5], rel=1e-5)


def test_a_frame_that_was_hardly_seen_is_no_error_of_the_path(
    demo: tuple[Measured, Found],
) -> None:
    m, found = demo
    test = [s for s in m.series if s.name in found.held_out]
    spoilt = test[0].seen.copy()
    spoilt[40, :2] += 0.03
    noise = test[0].noise.copy()
    noise[40, :2, :2] *= 50.0**2
    unsure = replace(test[0], seen=spoilt, noise=noise)
    seen = np.isfinite(unsure.seen[:, 0])
    assert np.flatnonzero(seen & ~well_seen([unsure])[0]).tolist() == [40]
    models = {"extended": found.extended}
    clean, off, told = (
        path_errors(m.study, compiled(plates()), models, [one, *test[1:]]).rmse_m["extended"]
        for one in (test[0], replace(unsure, noise=test[0].noise), unsure)
    )
    assert off > 1.05 * clean
    assert told == pytest.approx(clean, rel=0.01)


def first_seen(series: Series) -> np.ndarray:
    """Where the keypoint was seen first (2,)."""
    return series.seen[np.isfinite(series.seen[:, 0])][0, :2]


def test_a_centre_of_mass_far_off_is_found_whole(demo: tuple[Measured, Found]) -> None:
    """5 cm: where a trial starts is known by the keypoint alone, which lies there no more."""
    _, found = demo
    bench, model = _bench(demo), found.choice.chosen
    off = swung(bench.series, found.extended, "centre_of_mass_shift", {"d": -0.05})
    moved = [replace(s, mean=np.concatenate([first_seen(s), s.mean[2:]])) for s in off]
    bench = replace(bench, series=moved)
    again = bench.settled(bench.refit((*model.effects, "centre_of_mass_shift"), model))
    assert again.fit.by_label()["centre_of_mass_shift.d"] == pytest.approx(-0.05, rel=0.02)


def test_a_model_astray_names_nothing_surely(demo: tuple[Measured, Found]) -> None:
    _, found = demo
    chosen = replace(found.choice.chosen, astray=16.0)
    choice = replace(found.choice, chosen=chosen)
    assert verdict_of(compiled(plates()), choice, chosen) == "unexplained"
    lost = replace(found, choice=choice, residual=chosen, verdict="unexplained")
    sure, unsure = ({c["name"]: c["weight"] for c in causes(f)} for f in (found, lost))
    assert all(unsure[name] == pytest.approx(0.5 * weight) for name, weight in sure.items())
    assert unsure["unexplained"] == pytest.approx(0.0, abs=1e-9)
    said = sentence(lost, causes(lost), [])
    assert "with tail_fin_lift (weight" in said
    assert "16 times more than their errors" in said
    few = replace(chosen, worth=chosen.worth[:9])
    assert verdict_of(compiled(plates()), replace(choice, chosen=few), few) == "physics"


def test_an_effect_that_one_trial_bends_does_not_lead_the_coefficients_astray() -> None:
    """Two numbers that do not mix: how widely one spreads says nothing of the other."""
    kernel, rng = compiled(plates()), np.random.default_rng(4)
    said = rng.normal(size=(18, 2)) * [1.0, 8.0]
    hessian = np.repeat(np.eye(2)[None], 18, axis=0)
    values = said.mean(axis=0)
    normal = Normal(hessian, said - values, np.zeros(18))
    free = (Free("C_T"), Free("linear_yaw_damping.N_r"))
    found = Fit(free, np.array([0.006, 0.03]), normal, "converged", 1)
    assert inflation(kernel, found) > 15.0
    assert inflation(kernel, found, own=True) < 2.5


def test_plain_terms_without_a_name_tell_beside_a_strong_cause(
    demo: tuple[Measured, Found],
) -> None:
    _, found = demo
    chosen = found.choice.chosen

    def beside(
        over: float, left: float, chance: float = 1e-7, term: str = "residual.a8"
    ) -> Trialled:
        gain = over * chosen.inflation / len(chosen.worth)
        noise = replace(chosen.noise, disturbance=left * chosen.noise.disturbance)
        effects = (*chosen.effects, term)
        p_value = {**chosen.p_value, term: chance}
        return replace(chosen, effects=effects, worth=chosen.worth + gain, noise=noise,
                       p_value=p_value)  # fmt: skip

    strong = chosen.total - min(m.total for m in found.choice.without.values())
    assert 20.0 * chosen.inflation < 0.1 * strong
    assert tells(found.choice, beside(20.0, 0.5))
    assert not tells(found.choice, beside(20.0, 0.8))
    assert not tells(found.choice, beside(6.0, 0.5))
    assert not tells(found.choice, beside(20.0, 0.5, chance=1e-5))
    assert tells(found.choice, beside(20.0, 0.5, 7e-7, "hump"))
    assert not tells(found.choice, beside(10.0, 0.5, 7e-7, "hump"))
    assert not tells(found.choice, beside(20.0, 0.5, 7e-7, "sloshing"))
    assert not tells(found.choice, chosen)


@pytest.mark.parametrize(
    ("term", "over", "chance", "told"),
    [("residual.c8", 6.0, 4e-6, False), ("residual.c8", 6.0, 5e-7, True),
     ("residual.c8", 41.0, 2e-6, True), ("residual.c8", 41.0, 2e-5, False),
     ("hump", 6.0, 5e-7, False), ("hump", 41.0, 2e-6, True), ("sloshing", 41.0, 2e-6, False)],
)  # fmt: skip
@pytest.mark.parametrize("left", [0.5, 1.0])
def test_a_term_that_stands_alone_needs_a_small_p_value(
    demo: tuple[Measured, Found], term: str, over: float, chance: float, told: bool, left: float
) -> None:
    """The smallest of 85 nulls was 4e-6, with a gain of 6; what looked random need not be less."""
    _, found = demo
    bare = found.choice.bare
    alone = replace(found.choice, chosen=bare, without={})
    noise = replace(bare.noise, disturbance=left * bare.noise.disturbance)
    more = replace(bare, effects=(term,), noise=noise, p_value={term: chance},
                   worth=bare.worth + over * bare.inflation / len(bare.worth))  # fmt: skip
    assert tells(alone, more) == told


@pytest.mark.parametrize(
    ("term", "chance", "told"),
    [("residual.a8", 9e-4, True), ("residual.a8", 2e-3, False), ("sloshing", 2e-4, False),
     ("sloshing", 9e-5, True), ("hump", 9e-5, False)],
)  # fmt: skip
def test_terms_of_much_gain_that_may_be_chance_do_not_tell(
    demo: tuple[Measured, Found], term: str, chance: float, told: bool
) -> None:
    """A swing that was none gained 17 over the inflation in nine trials, p = 9e-4."""
    _, found = demo
    chosen = found.choice.chosen
    noise = replace(chosen.noise, disturbance=0.5 * chosen.noise.disturbance)
    gain = chosen.total - min(m.total for m in found.choice.without.values())
    more = replace(chosen, effects=(*chosen.effects, term), noise=noise,
                   worth=chosen.worth + gain / len(chosen.worth),
                   p_value={**chosen.p_value, term: chance})  # fmt: skip
    assert tells(found.choice, more) == told


def test_a_scale_is_what_rigid_lengths_say_whatever_the_paths_say(
    demo: tuple[Measured, Found],
) -> None:
    """Lengths 5 % too long, paths that know of nothing: the scale is 5 %, and as sure as they."""
    m, found = demo
    few = [s for s in thin(m.series) if s.name not in found.held_out][:6]
    told = [replace(s, evidence={"scale": (0.05, 0.003 * len(few) ** 0.5)}) for s in few]
    bench = Bench(compiled(plates()), told, found.baseline.base, (), found.baseline.fit.free,
                  lambda _: None)  # fmt: skip
    model = bench.refit((*found.choice.chosen.effects, "scale_error"), found.choice.chosen)
    firm, aside = with_direct(bench, model)
    assert aside == {"scale_error.k": pytest.approx(0.003)}
    again = firm.refit(model.effects, model)
    assert again.fit.by_label()["scale_error.k"] == pytest.approx(0.05, abs=2e-4)
    k = [f.label for f in again.fit.free].index("scale_error.k")
    wide, narrow = (spread_of(firm, again, a).cov for a in (aside, {}))
    assert np.sqrt(wide[k, k] - narrow[k, k]) == pytest.approx(0.003)
    assert np.all(np.diag(wide) >= np.diag(narrow))
    faint = [replace(s, evidence={"scale": (0.005, 0.003 * len(few) ** 0.5)}) for s in few]
    assert with_direct(replace(bench, series=faint), model)[1] == {}


def test_what_is_dropped_leaves_the_rest_refitted_and_weighed_anew(
    demo: tuple[Measured, Found],
) -> None:
    _, found = demo
    bench = _bench(demo)
    left = dropped(bench, found.choice, ["linear_yaw_damping"])
    assert left.chosen.effects == ("tail_fin_lift",)
    assert left.without["tail_fin_lift"].effects == ()
    assert left.chosen.total > left.without["tail_fin_lift"].total
    assert left.places["tail_fin_lift"].before.effects == ()
    none = dropped(bench, found.choice, list(found.choice.chosen.effects))
    assert none.chosen is found.choice.bare
    assert not none.without


def test_a_name_that_a_nameless_term_replaces_goes(demo: tuple[Measured, Found]) -> None:
    """`residual.c1` is a moment by the yaw rate, as the damping is."""
    _, found = demo
    bench = _bench(demo)
    chosen = found.choice.chosen
    residual = bench.settled(bench.refit((*chosen.effects, "residual.c1"), chosen))
    left, beside = without_proxies(bench, found.choice, residual)
    assert left.chosen.effects == ("tail_fin_lift",)
    assert beside.effects == ("tail_fin_lift", "residual.c1")
