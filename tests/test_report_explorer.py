"""Data of the trial explorer: stored compactly, restored within the stated resolution."""

from __future__ import annotations

import base64
import gzip
import json

import numpy as np
import pytest
from exact_campaign import campaign_with_damping_found, exact_campaign

from bluekoi.campaign import Campaign
from bluekoi.report.explorer import compressed_trial_time_series
from bluekoi.report.packing import gzip_base64, quantised_differences


def restored_column(stored: dict) -> np.ndarray:
    """As explorer.js restores a column."""
    total, out = 0, []
    for step in stored["steps"]:
        total += step or 0
        out.append(np.nan if step is None else total * stored["unit"])
    return np.array(out)


def unpack(text: str) -> dict:
    return json.loads(gzip.decompress(base64.b64decode(text)))


def test_a_column_is_restored_within_half_its_resolution():
    values = np.cumsum(np.random.default_rng(3).normal(size=500))
    values[[0, 7, 8, 499]] = np.nan
    found = restored_column(json.loads(json.dumps(quantised_differences(values, 1e-3))))
    np.testing.assert_allclose(found, values, atol=5.001e-4)
    assert np.array_equal(np.isnan(found), np.isnan(values))


def test_packing_is_reproducible():
    assert gzip_base64("x" * 99) == gzip_base64("x" * 99)
    assert gzip.decompress(base64.b64decode(gzip_base64("µ"))).decode() == "µ"


def test_models_are_given_at_the_times_of_the_track():
    base = campaign_with_damping_found(exact_campaign(powers=(75,)))
    track = base.tracks["T02"]
    late = track.time_s[::2]
    columns = {"time_s": late, "joint_x_m": 0.2 * late, "joint_y_m": 0 * late}
    found = unpack(
        compressed_trial_time_series(
            Campaign(**{**base.__dict__, "simulations": {"T02": columns}}), "T02"
        )
    )
    assert found.keys() == {"measured", "before"}
    x = restored_column(found["before"]["x_m"])
    assert len(x) == len(track.time_s)
    assert x[:-1] == pytest.approx(0.2 * track.time_s[:-1], abs=1e-4)
    assert np.isnan(x[-1])  # the simulation ends one frame earlier
    assert np.nanmedian(restored_column(found["before"]["speed_m_s"])) == pytest.approx(
        0.2, abs=1e-4
    )


def test_a_long_trial_is_thinned_and_one_without_track_has_no_series():
    base = exact_campaign(powers=(75,), angles=(45,), heads=(0.12,))
    ((name, track),) = base.tracks.items()
    times = np.linspace(0, 300, 9000)
    many = {k: np.interp(times / 100, track.time_s, v) for k, v in vars(track).items()
            if isinstance(v, np.ndarray) and v.ndim == 1}  # fmt: skip
    long = type(track)(**{**many, "time_s": times})
    found = unpack(
        compressed_trial_time_series(Campaign(**{**base.__dict__, "tracks": {name: long}}), name)
    )
    assert len(found["measured"]["time_s"]["steps"]) == 2000
    assert restored_column(found["measured"]["time_s"])[-1] == pytest.approx(300)
    assert compressed_trial_time_series(Campaign(study=base.study), name) == ""
