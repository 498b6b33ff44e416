"""The tank `coupled_bodies`: its null is the published model, its files and truths are usable."""

from __future__ import annotations

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from candidate_causes import LEFT_RIGHT_ASYMMETRIC_CAUSES, MEASUREMENT, PHYSICS
from click.testing import CliRunner
from study_files import assert_same_files

from bluekoi.cli import main
from validation.generators.coupled_bodies import (
    articulated,
    faults,
    generate,
    place_laws,
    plan,
    polars,
    strength,
    studies,
    tracking,
    water,
    writing,
)
from validation.generators.coupled_bodies.camera import draw_camera, pool_corners, with_fitted_pose
from validation.generators.coupled_bodies.form import HiddenLaw
from validation.generators.coupled_bodies.ideal import (
    MOTION_STAGES,
    detectability_sigmas,
    sensitivity,
)
from validation.generators.coupled_bodies.placing import PlacedMotion, simulate_placed
from validation.generators.coupled_bodies.robots import (
    GUST_KNOTS,
    ParallelTrials,
    Robot,
    with_strengths,
)

PAPER_ROBOT = Robot(mass=0.68, inertia=0.0095, core_share=0.85, body_length=0.331, head_length=0.12,
              span=0.069, hinge_to_com=0.04, tail_length=0.066, depth=0.04, C_T=4.5e-3, C_D0=0.5,
              C_Da=4.0, C_La=3.14, C_Ma=0.1, C_Md=0.104)  # fmt: skip
POOL = (3.6, 2.2, 0.4)


def still_water_trials(angles_deg, hertz=5.82, head=0.12) -> ParallelTrials:
    """Trials in still water, without errors."""
    n = len(angles_deg)
    zero = np.zeros(n)
    angle = np.deg2rad(angles_deg)
    coef = np.array([getattr(PAPER_ROBOT, name) for name in studies.COEFFICIENTS])
    start = np.zeros((6, n))
    start[:2] = [[1.8], [1.1]]
    return ParallelTrials(
        power=zero + 100,
        command=angle,
        angle=angle,
        flap=zero + hertz,
        head=zero + head,
        start=start,
        coef=np.repeat(coef[:, None], n, 1),
        shaft=zero,
        wander=np.ones((3, 1, n)) * [[[0.0]], [[1.0]], [[0.0]]],
        mean=0j * zero,
        modes=np.zeros((6, 1, n)),
        gust=np.zeros((GUST_KNOTS, n), complex),
        size=np.zeros((0, n)),
    )


def law_of(cause: str, name: str, size: float, **shape: float) -> HiddenLaw:
    form = next(f for f in plan.CATALOGUE if (f.cause, f.name) == (cause, name))
    pool = {"pool_length_m": POOL[0], "pool_width_m": POOL[1]}
    return HiddenLaw(form, size, pool | {k: v[0] for k, v in form.ranges.items()} | shape)


def simulate(
    trials: ParallelTrials, laws: list[HiddenLaw], seconds: float, robot: Robot = PAPER_ROBOT, **kw
):
    trials = with_strengths(trials, [h.strength for h in laws])
    return articulated.simulate_motion(trials, robot, laws, seconds, **kw)


def published_rates(state, phi, hertz, area, arm):
    """Rates of the published equations (1) to (8), written out in world axes."""
    _, _, th, vx, vy, r = state
    v = vx + 1j * vy
    q, along, alpha = 500 * area * abs(v) ** 2, v / abs(v), th - np.angle(v)
    T = PAPER_ROBOT.C_T * 500 * area * hertz**2 * np.exp(1j * (th + phi))
    L = q * PAPER_ROBOT.C_La * np.sin(2 * alpha) * along * 1j
    D = -q * (PAPER_ROBOT.C_D0 + PAPER_ROBOT.C_Da * (1 - np.cos(2 * alpha))) * along
    N = ((L + D) * np.conj(1j * np.exp(1j * th))).real
    M = q * PAPER_ROBOT.C_Ma * np.sin(2 * alpha) - PAPER_ROBOT.C_Md * r * abs(r)
    a = (T + L + D) / PAPER_ROBOT.mass
    return [vx, vy, r, a.real, a.imag, (M + N * arm) / PAPER_ROBOT.inertia]


@pytest.mark.parametrize("head", [0.12, 0.175])
def test_rates_of_a_null_are_those_of_the_published_equations(head):
    state = np.array([0.3, 0.2, 0.7, 0.31, 0.12, -0.4])
    full = np.concatenate([state, [0, 0]])[:, None]
    found = articulated.rates(0.0, full, still_water_trials([30.0], head=head), PAPER_ROBOT)[:6, 0]
    arm = head + 0.04 - (0.331 + head - 0.12) / 4
    want = published_rates(state, np.deg2rad(30), 5.82, head * 0.069, arm)
    np.testing.assert_allclose(found, want, rtol=1e-5)


def test_straight_speed_and_instability_are_those_of_the_paper():
    end = simulate(still_water_trials([0.0]), [], 8).states[-1]
    assert np.hypot(end[3, 0], end[4, 0]) == pytest.approx(0.552, abs=1e-3)
    assert articulated.growth_rate(still_water_trials([0.0]), PAPER_ROBOT, []) == pytest.approx(
        3.6, abs=0.1
    )


def test_a_robot_without_thrust_stays_at_rest():
    states = simulate(still_water_trials([30.0, 0.0], hertz=0.0), [], 3).states
    np.testing.assert_allclose(states[-1], states[0], atol=1e-12)


def test_a_hinge_that_turns_at_rest_turns_the_two_bodies_against_each_other():
    """Constraint of the hinge: I_head theta' + I_core (theta + phi)' = 0, place kept."""
    lag = law_of("servo_lag", "first_order", 1.0, tau_s=0.1)
    trial = with_strengths(still_water_trials([40.0], hertz=0.0), [1.0])
    trial.coef[:] = 0.0
    film = simulate(trial, [lag], 1.5)
    phi, _ = articulated.head_angle(trial, [lag], film.times)
    theta = film.states[:, 2, 0]
    np.testing.assert_allclose(0.15 * theta + 0.85 * (theta + phi[:, 0]), 0, atol=1e-4)
    np.testing.assert_allclose(film.states[:, :2, 0], [[1.8, 1.1]] * len(theta), atol=1e-12)


def test_integration_is_of_fourth_order():
    trial = still_water_trials([30.0])
    trial.start[3:6] = np.array([0.25, 0.25, -0.6])[:, None]

    def end(step):
        return simulate(trial, [], 0.4, step=step).states[-1, :6, 0]

    fine = end(1 / 640)
    ratio = np.linalg.norm(end(1 / 80) - fine) / np.linalg.norm(end(1 / 160) - fine)
    assert 13 < ratio < 20


def random_states(count: int) -> np.ndarray:
    """Random motions near one wall, without memories."""
    rng = np.random.default_rng(6)
    out = np.zeros((8, count))
    out[:2] = rng.uniform([[0.25], [0.8]], [[0.5], [1.4]], (2, count))
    out[2:6] = rng.normal(0, [[1.0], [0.3], [0.2], [0.5]], (4, count))
    return out


def rates(state, angle_deg, hidden):
    """Rates 0.2 s after the start of trials with a longer head."""
    many = with_strengths(
        still_water_trials([angle_deg] * state.shape[1], head=0.16), [h.strength for h in hidden]
    )
    many.start[2] = 0.0
    return articulated.rates(0.2, state, many, PAPER_ROBOT, hidden)


def test_even_laws_are_mirror_symmetric():
    mirror = np.array([1, -1, -1, 1, -1, -1])[:, None]
    one = random_states(20)
    other = one * [[1], [-1], [-1], [1], [-1], [-1], [1], [1]]
    for form in plan.CATALOGUE:
        if form.cause in LEFT_RIGHT_ASYMMETRIC_CAUSES or form.stage not in MOTION_STAGES:
            continue
        hidden = [law_of(form.cause, form.name, (form.low * form.high) ** 0.5)]
        here, there = rates(one, 25.0, hidden), rates(other, -25.0, hidden)
        np.testing.assert_allclose(there[:6], mirror * here[:6], atol=1e-9, err_msg=form.name)


def test_a_mirrored_robot_swims_mirrored():
    out = simulate(still_water_trials([25.0, -25.0]), [], 3.0).states
    np.testing.assert_allclose(out[:, [2, 5], 0], -out[:, [2, 5], 1], atol=1e-9)
    assert out[-1, 5, 0] < -0.1  # positive phi turns clockwise


def test_a_law_of_strength_zero_gives_the_null_and_another_one_does_not():
    state = random_states(20)
    null = rates(state, 30.0, [])
    for form in plan.CATALOGUE:
        if form.stage not in MOTION_STAGES or form.stage == "sink":
            continue
        none = rates(state, 30.0, [law_of(form.cause, form.name, 0.0)])
        np.testing.assert_allclose(none[:6], null[:6], atol=1e-12)
        some = rates(state, 30.0, [law_of(form.cause, form.name, form.high / 2)])
        assert np.abs(some - null)[2:].max() > 1e-3, form.name


def test_passive_forces_take_energy_from_the_robot():
    rng = np.random.default_rng(0)
    state = np.zeros((8, 50))
    state[2:6] = rng.normal(0, [[1.0], [0.3], [0.3], [0.8]], (4, 50))
    for cause in ("viscous_drag", "wave_drag", "coulomb_friction", "crossflow_drag",
                  "linear_yaw_damping", "wake_reentry"):  # fmt: skip
        for form in (f for f in plan.CATALOGUE if f.cause == cause):
            hidden = law_of(cause, form.name, form.high / 10)
            many = with_strengths(still_water_trials([20.0] * 50), [hidden.strength])
            c = articulated.instantaneous_state(0.0, state, many, PAPER_ROBOT, [hidden])
            F, N = form.law(c, many.size[0], hidden.shape)
            assert np.all((F * np.conj(c.v)).real + N * c.r < 1e-12), form.name


def test_forces_have_the_values_computed_by_hand():
    """u = 0.3 m/s, w = 0.1 m/s, r = 0.5 /s on a straight robot along x."""
    state = np.zeros((8, 1))
    state[:6, 0] = 1.8, 1.1, 0.0, 0.3, 0.1, 0.5
    trial = still_water_trials([0.0])
    c = articulated.instantaneous_state(0.0, state, trial, PAPER_ROBOT, [])
    one = np.ones(1)

    def force(cause, name, **shape):
        hidden = law_of(cause, name, 1.0, **shape)
        return hidden.form.law(c, one, hidden.shape)

    F, N = force("tail_fin_lift", "forward", back=0.8)
    x = -0.8 * (0.171 + 0.066)
    w = 0.1 + 0.5 * x
    assert F[0] == pytest.approx(-500j * 0.3 * w)
    assert N[0] == pytest.approx(-500 * 0.3 * w * x)
    assert force("viscous_drag", "linear")[0][0] == pytest.approx(-(0.3 + 0.1j) / 0.3)
    assert force("linear_yaw_damping", "linear")[1][0] == -0.5
    assert force("wave_drag", "fourth")[0][0] == pytest.approx(-(0.1**2 / 0.25**2) * c.along[0])
    loss = plan.CATALOGUE[[f.name for f in plan.CATALOGUE].index("exponential")]
    assert loss.law(c, one, {})[0] == pytest.approx(np.exp(-0.3 / (5.82 * 0.331)))
    assert force("trim_moment", "square")[1][0] == pytest.approx(0.1 / 0.09)
    F, _ = force("crossflow_drag", "square")
    ends = 0.1 + 0.5 * np.array([-0.237, 0.04])
    inner = np.sum(ends * np.abs(ends) * ends * [-1, 1]) / (3 * 0.5)
    assert F[0].imag == pytest.approx(-500 * 0.069 * inner, rel=1e-2)


def test_water_has_no_divergence_and_the_stated_strength():
    rng = np.random.default_rng(3)
    sea = water.WaterMotion(0.0, 1e-3, 1.0)
    modes = water.draw_fourier_modes(rng, sea, 4000)
    at, d = np.full(4000, 1.0 + 0.7j), 1e-7
    here = water.eddy_velocity(modes, at, 0.0)
    assert here.real.std() == pytest.approx(1e-3, rel=0.05)
    assert here.imag.std() == pytest.approx(1e-3, rel=0.05)
    spread = ((water.eddy_velocity(modes, at + d, 0.0) - here).real
              + (water.eddy_velocity(modes, at + 1j * d, 0.0) - here).imag) / d  # fmt: skip
    assert np.abs(spread).max() < 1e-6


def test_gyres_have_their_strength_as_greatest_speed_or_at_half_the_width():
    x = np.linspace(0.05, POOL[0] - 0.05, 300)[:, None] + 1j * np.linspace(0, POOL[1], 200)
    c = type("C", (), {"x": x, "t": 0.0})
    for form in place_laws.FORMS:
        if form.cause == "pool_gyre" and form.name in ("lamb_oseen", "scully"):
            v = form.law(c, 0.01, law_of("pool_gyre", form.name, 1).shape)
            assert np.abs(v).max() == pytest.approx(0.01, rel=0.01)
    solid = law_of("pool_gyre", "solid", 1)
    c.x = np.array([POOL[0] / 2 + 1j * POOL[1]])
    assert solid.form.law(c, 0.01, solid.shape)[0] == pytest.approx(-0.01)


def test_tables_of_the_plate_are_the_published_law():
    alpha = np.random.default_rng(1).uniform(-np.pi, np.pi, 500)
    found = polars.interpolate_polar(polars.flat_plate(), alpha)
    want = [np.sin(2 * alpha), 1 - np.cos(2 * alpha), np.sin(2 * alpha)]
    np.testing.assert_allclose(found, want, atol=1e-6)


def test_every_cause_of_the_contract_has_three_forms_and_comes_in_its_turn():
    forms = {}
    for form in plan.CATALOGUE:
        forms.setdefault(form.cause, set()).add(form.name)
    assert set(forms) - {plan.UNLISTED_NAME} == PHYSICS | MEASUREMENT
    assert all(len(names) >= 3 for names in forms.values())
    assert all(f.variable for f in plan.CATALOGUE if f.cause == plan.UNLISTED_NAME)
    drawn = {name for index in range(60) for name in plan.hidden_causes(5, index)}
    assert drawn == set(forms) - {plan.FIN_CAUSE}
    rng = np.random.default_rng(0)
    for cause, names in forms.items():
        assert {plan.draw_forms(rng, [cause])[0].name for _ in range(150)} == names


def test_shares_of_kinds_fins_and_short_studies_hold_in_each_twenty():
    kinds = [plan.study_kind(3, i) for i in range(40)]
    names = [k.name for k in kinds]
    assert {n: names.count(n) / 2 for n in plan.KIND_COUNTS} == plan.KIND_COUNTS
    assert sum(k.fin for k in kinds) == 20
    assert sum(k.few for k in kinds) == 8


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_way_back_through_surface_and_lens_is_exact(seed):
    rng = np.random.default_rng(seed)
    camera = draw_camera(rng, POOL)
    at = rng.uniform(0.1, 3.5, 50) + 1j * rng.uniform(0.1, 2.1, 50)
    px = camera.see(at, 0.2)
    assert np.abs(camera.back(px, 0.2, at + 0.02) - at).max() < 1e-7
    assert np.all((px > 0) & (px < camera.size))
    top = camera.surface(at, 0.2)
    ray = top - camera.place
    sine = np.hypot(ray[:, 0], ray[:, 1]) / np.linalg.norm(ray, axis=1)
    below = np.abs(at - top[:, 0] - 1j * top[:, 1])
    np.testing.assert_allclose(sine, 1.333 * below / np.hypot(below, 0.2), rtol=1e-6)
    again = with_fitted_pose(camera, POOL, 0.05, camera.project(pool_corners(POOL, 0.05)))
    np.testing.assert_allclose(again.place, camera.place, atol=1e-6)


def test_the_lenses_are_those_of_opencv():
    points = np.random.default_rng(0).uniform([0.2, 0.2, 0], [2.8, 1.6, 0.01], (20, 3))
    kinds = set()
    for seed in range(8):
        camera = draw_camera(np.random.default_rng(seed), POOL)
        turn = cv2.Rodrigues(camera.turn)[0]
        project = cv2.fisheye.projectPoints if camera.fisheye else cv2.projectPoints
        args = (points[:, None], camera.turn[:, None], -turn @ camera.place[:, None],
                camera.matrix, camera.distortion)  # fmt: skip
        want = project(*args)[0].reshape(-1, 2)
        np.testing.assert_allclose(camera.project(points), want, atol=1e-6)
        kinds.add(camera.fisheye)
    assert kinds == {True, False}


def test_tracking_errors_have_the_stated_size_and_memory():
    tracker = tracking.Tracker(0.5, 0.2, 0.1, 0, 0, 0)
    noise = tracking.correlated_errors(np.random.default_rng(0), tracker, np.arange(200) / 30, 400)
    assert noise.var() == pytest.approx(0.5**2 + 0.2**2, rel=0.03)
    lag = np.sqrt(3) / 30 / 0.1
    want = 0.25 * (1 + lag) * np.exp(-lag)
    assert (noise[1:] * noise[:-1]).mean() == pytest.approx(want, rel=0.05)


def test_detections_have_gaps_and_swaps_of_low_likelihood():
    tracker = tracking.Tracker(0.5, 0.2, 0.1, 0.0, 0.03, 0.05)
    px = np.arange(10.0).reshape(1, 5, 2) * 100 + np.zeros((600, 1, 1))
    found = tracking.detections(np.random.default_rng(2), tracker, px, np.zeros((600, 5, 2)))
    swapped = np.isclose(found[:, 0, 0], px[0, 4, 0])
    assert swapped.sum() > 5
    assert np.all(found[swapped, 0, 2] < 0.3)
    assert 0.01 < np.mean(found[..., 2] < 0.1) < 0.3


def test_log_wraps_and_has_its_dead_zone():
    sensor = writing.Potentiometer(20.0, "empty", 0.0, 0.0)
    turns = np.arange(400) * 0.0125
    angles = writing.logged_angles(np.random.default_rng(0), sensor, turns)
    dead = (360 * turns) % 360 > 340
    assert np.array_equal(np.isnan(angles), dead)
    np.testing.assert_allclose(angles[~dead], (360 * turns[~dead]) % 360, atol=1e-9)


def _shorten_trials() -> tuple:
    rng = np.random.default_rng(8)
    setup = studies.draw_setup(rng, plan.StudyKind("single", fin=False, few=True), [])
    start = setup.lanes.start.copy()
    start[:2] = [[setup.pool[0] / 2], [setup.pool[1] / 2]]
    return rng, setup, replace(setup.lanes, start=start)


def test_sigma_grows_with_the_strength_and_knows_the_error_of_the_servo():
    rng, setup, trials = _shorten_trials()
    found = []
    for size in (1.0, 2.0):
        laws = [law_of("viscous_drag", "linear", 4e-4 * size),
                law_of("head_angle_offset", "constant", 1e-3 * size)]  # fmt: skip
        sized = strength.with_law_strengths(trials, laws)
        film = articulated.simulate_motion(sized, setup.robot, laws, 4.0)
        motion = PlacedMotion(sized, film, np.full(9, 4.0))
        seen = sensitivity(setup, motion, laws)
        found.append(detectability_sigmas(rng, setup, motion, laws, seen=seen))
    np.testing.assert_allclose(found[1] / found[0], 2.0, rtol=0.2)
    assert 0 < found[0][1] <= 1.02 * 1e-3 / np.deg2rad(0.3) * 3


def test_a_fault_of_strength_zero_shows_the_null_and_another_one_does_not():
    _, setup, trials = _shorten_trials()
    film = articulated.simulate_motion(
        strength.with_law_strengths(trials, []), setup.robot, [], 5.0
    )
    motion = PlacedMotion(trials, film, np.full(9, 4.0))
    times, turns = np.arange(1200) * 0.005, np.arange(1200) * 0.005 * 4

    def shown(size, form):
        laws = [HiddenLaw(form, size, dict.fromkeys(form.ranges, 1.0))]
        own = replace(motion, lanes=strength.with_law_strengths(trials, laws))
        own_setup = replace(setup, tracker=tracking.Tracker(1e-9, 1e-9, 0.1, 0, 0, 0))
        content = studies.StudyContent(own_setup, own, laws, np.zeros(1))
        said = studies.stated_setup(setup.scene, setup.robot, laws)
        film = [
            studies.film_detections(np.random.default_rng(1), content, k, times, turns)[:100, :, :2]
            for k in range(9)
        ]
        stated = [*said.pool, *said.matrix.ravel(), *said.distortion, said.index, *said.marks.flat]
        return np.concatenate([*[f.ravel() for f in film], stated])

    null = shown(0.0, faults.FORMS[0])
    for form in faults.FORMS:
        np.testing.assert_allclose(shown(0.0, form), null, atol=1e-5)
        assert np.abs(shown(form.high / 2, form) - null).max() > 1e-3, form.name


def test_fins_make_straight_swimming_stable():
    rng, setup, _ = _shorten_trials()
    for form in (f for f in plan.CATALOGUE if f.cause == plan.FIN_CAUSE):
        fin = strength.draw_fin(rng, setup.lanes, setup.robot, form, setup.pool)
        assert strength.straight_growth_rate(setup.lanes, setup.robot, [fin]) < 0
        assert strength.straight_growth_rate(setup.lanes, setup.robot, []) > 0.5


@pytest.fixture(scope="module")
def generated_studies(tmp_path_factory):
    """A null and a study with a hidden drag; nine trials each."""
    folder = tmp_path_factory.mktemp("tank")
    few = [i for i in range(40) if plan.study_kind(9, i).few and not plan.study_kind(9, i).fin]
    drag = next(f for f in plan.CATALOGUE if f.cause == "viscous_drag")
    return folder, [
        generate(9, i, folder, forms=f) for i, f in zip(few, ([], [drag]), strict=False)
    ]


def test_files_are_accepted_by_the_tool(generated_studies):
    folder, truths = generated_studies
    for truth in truths:
        done = CliRunner().invoke(main, ["check", str(folder / "studies" / truth["study"])])
        assert done.exit_code == 0, done.output
        assert "no error found in the files" in done.output


def test_truths_have_the_keys_of_the_scores_and_sigma_in_range(generated_studies):
    folder, truths = generated_studies
    for truth, hidden in zip(truths, ([], ["viscous_drag"]), strict=True):
        path = folder / "truth" / f"{truth['study']}.json"
        assert json.loads(path.read_text()) == json.loads(json.dumps(truth))
        names = [c["name"] for c in truth["causes"]]
        assert names == (["tail_fin_lift"] if truth["fin"] else []) + hidden
        assert all(10 <= c["sigma"] <= 60 for c in truth["causes"] if c["name"] in hidden)
        assert {"group", "trials", "unlisted", "generator", "coefficients"} <= set(truth)
        trials = (folder / "studies" / truth["study"] / "trials.csv").read_text().splitlines()
        assert len(trials) == truth["trials"] + 1 == 10


def test_a_series_is_reproduced(generated_studies, tmp_path):
    folder, truths = generated_studies
    generate(9, truths[0]["index"], tmp_path, forms=[])
    study = f"studies/{truths[0]['study']}"
    assert_same_files(tmp_path / study, folder / study)


def test_trials_begin_from_rest_last_four_seconds_and_stay_in_the_pool():
    rng, setup, trials = _shorten_trials()
    motion = simulate_placed(
        rng,
        strength.with_law_strengths(trials, []),
        setup.robot,
        [],
        pool=setup.pool,
        wanted=setup.wanted,
    )
    length, width, _ = setup.pool
    for k, end in enumerate(motion.ends):
        x, y = motion.film.at(np.linspace(0, end, 50))[:, :2, k].T
        assert min(x.min(), y.min(), length - x.max(), width - y.max()) > 0.2
        assert 4 <= end <= 9
    assert np.all(motion.film.states[0, 3:6] == 0)
