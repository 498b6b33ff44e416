"""Which trials a study has, under which laws, filmed how."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

from bluekoi.synthetic.ground_truth_physics import Coefficients, GroundTruthPhysics
from bluekoi.synthetic.optics import Camera, gopro_like_camera
from bluekoi.synthetic.picture_conditions import MIDDLE_PICTURE_CONDITIONS, PictureConditions

SIMULATED_FLAP_HZ_BY_POWER: Mapping[int, float] = {50: 2.37, 75: 4.02, 100: 5.82}
MAX_TRIAL_DURATION_S_BY_POWER: Mapping[int, float] = {50: 6.4, 75: 4.4, 100: 3.4}


@dataclass(frozen=True)
class TrialPlan:
    """One trial as ordered: power (%), head angle (deg) and length (m), longest duration (s)."""

    trial_id: str
    power_pct: int
    head_angle_deg: float
    head_length_m: float
    longest_s: float


@dataclass(frozen=True)
class StudyDesign:
    """A whole study: its trials, the laws of its tank, its camera and picture conditions,
    its seed.

    `coefficients_at` replaces the tank's coefficients at a power (Table I); `flap_spread` is the
    relative spread of the beat frequency between trials.
    """

    name: str
    plans: tuple[TrialPlan, ...]
    tank: GroundTruthPhysics
    seed: int
    camera: Camera = field(default_factory=gopro_like_camera)
    conditions: PictureConditions = MIDDLE_PICTURE_CONDITIONS
    coefficients_at: Mapping[int, Coefficients] = field(default_factory=dict)
    flap_hz: Mapping[int, float] = field(default_factory=lambda: dict(SIMULATED_FLAP_HZ_BY_POWER))
    flap_spread: float = 0.004
    water_rms_m_s: float = 0.0
    pool_depth_m: float = 0.3
    wall_margin_m: float = 0.09

    def plan_of_trial(self, trial_id: str) -> TrialPlan:
        """The plan of a trial; raises KeyError for an unknown one."""
        return {plan.trial_id: plan for plan in self.plans}[trial_id]


DEMO_HEAD_ANGLES_AND_LENGTHS = (
    (0.0, 0.12),
    (0.0, 0.12),
    (0.0, 0.175),
    (30.0, 0.12),
    (-30.0, 0.12),
    (45.0, 0.12),
    (-45.0, 0.12),
    (45.0, 0.175),
)


DEMO_PICTURE_CONDITIONS = replace(MIDDLE_PICTURE_CONDITIONS, mbit_s=20.0)
"""At 45 Mbit/s, as action cameras write, encoding and decoding take half of the demo's time."""


def full_factorial_trial_plans(
    powers: Iterable[int], settings: Iterable[tuple[float, float]]
) -> tuple[TrialPlan, ...]:
    """A plan for each power at each setting (head angle [deg], head length [m]): T01, T02, ..."""
    rows = enumerate(product(powers, settings), start=1)
    return tuple(
        TrialPlan(f"T{n:02d}", power, *each, MAX_TRIAL_DURATION_S_BY_POWER[power])
        for n, (power, each) in rows
    )


def demo_design(seed: int = 11) -> StudyDesign:
    """24 trials at 1080p: fin, gently moving water, recoil, and linear yaw damping."""
    tank = GroundTruthPhysics(yaw_damping_n_m_s=0.03)
    plans = full_factorial_trial_plans((50, 75, 100), DEMO_HEAD_ANGLES_AND_LENGTHS)
    return StudyDesign(
        "demo", plans, tank, seed, water_rms_m_s=0.001, conditions=DEMO_PICTURE_CONDITIONS
    )


def picture_conditions_design(
    state: PictureConditions, seed: int = 13, *, longest_s: float = 3.4
) -> StudyDesign:
    """Three trials (straight, turn to either side) filmed under the given picture conditions."""
    plans = (
        TrialPlan("T01", 100, 0.0, 0.12, longest_s),
        TrialPlan("T02", 75, 30.0, 0.12, longest_s),
        TrialPlan("T03", 100, -45.0, 0.175, longest_s),
    )
    return replace(demo_design(seed), name="ladder", plans=plans, conditions=state)
