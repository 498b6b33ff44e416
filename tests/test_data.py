"""The types that flow: shapes checked, tables read and written whole."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bluekoi import data
from bluekoi.data import (
    KeypointPositions,
    Keypoints,
    Pose,
    Track,
    has_excess_variance,
    is_confident,
)
from bluekoi.errors import InputError

TIMES = np.arange(5) / 30


def small_track(**changes) -> Track:
    columns = {name: np.linspace(0, 1, 5) for name in data.TRACK_COLUMNS} | {"time_s": TIMES}
    return Track(**(columns | changes))


def test_a_wrong_shape_names_every_field_that_is_wrong():
    with pytest.raises(InputError) as caught:
        Keypoints(TIMES, ("hinge",), np.zeros((5, 2)), np.zeros((4, 1)), np.zeros((5, 1, 2, 2)))
    text = str(caught.value)
    assert "xy_px: found shape (5, 2); expected shape (5, 1, 2)" in text
    assert "likelihood" in text
    assert "cov_px2" not in text


@pytest.mark.parametrize("times", [[0, 1, 1, 2, 3], [0, 2, 1, 3, 4], [0, 1, np.nan, 2, 3]])
def test_times_that_repeat_go_back_or_are_missing_are_refused(times):
    with pytest.raises(InputError, match="increasing times"):
        Pose(np.array(times, float), np.zeros((5, 4)), np.zeros((5, 4, 4)))


def test_parts_are_found_by_name():
    xy = np.arange(20.0).reshape(5, 2, 2)
    found = KeypointPositions(TIMES, ("a", "b"), xy, np.zeros((5, 2, 2, 2)), np.ones((5, 2)))
    assert np.array_equal(found.part("b"), xy[:, 1])


def test_a_track_goes_through_its_file(tmp_path):
    before = small_track(x_m=np.array([0, 1, np.nan, 3, 1 / 3]), recoil=np.full((5, 3), 0.25),
                         recoil_std=np.full((5, 3), 0.125))  # fmt: skip
    data.write_track(tmp_path / "t.csv", before)
    after = data.read_track(tmp_path / "t.csv")
    for name in data.TRACK_COLUMNS:
        np.testing.assert_allclose(getattr(after, name), getattr(before, name), rtol=1e-8)
    np.testing.assert_array_equal(after.recoil, before.recoil)
    np.testing.assert_array_equal(after.recoil_std, before.recoil_std)


def test_the_track_file_has_the_columns_of_the_contract(tmp_path):
    data.write_track(tmp_path / "t.csv", small_track())
    header = (tmp_path / "t.csv").read_text().splitlines()[0].split(",")
    estimates = ("x_m", "y_m", "heading_rad", "head_angle_rad", "speed_m_s", "vx_m_s", "vy_m_s")
    for name in (*estimates, "yaw_rate_rad_s"):
        assert name in header
        assert f"{name}_std" in header
    assert header[0] == "time_s"


def test_a_pose_goes_through_its_file_with_its_covariance(tmp_path):
    rng = np.random.default_rng(1)
    root = rng.normal(size=(5, 4, 4))
    before = Pose(TIMES, rng.normal(size=(5, 4)), root @ np.swapaxes(root, 1, 2))
    data.write_pose(tmp_path / "p.csv", before)
    after = data.read_pose(tmp_path / "p.csv")
    np.testing.assert_allclose(after.values, before.values, rtol=1e-8)
    np.testing.assert_allclose(after.cov, before.cov, rtol=1e-8)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "an empty file"),
        ("a,c\n1,2\n", "a column b"),
        ("a,b\n1,2\n3\n", "row 3: found 1 cells"),
        ("a,b\n1,x\n", "row 2"),
        (b"\xff\xfea,b", "unreadable"),
    ],
)
def test_an_unreadable_table_names_file_and_row(tmp_path, text, expected):
    path = tmp_path / "t.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError, match=r"t\.csv") as caught:
        data.read_columns(path, ("a", "b"))
    assert expected in str(caught.value)


def test_a_table_with_a_header_alone_has_no_rows(tmp_path):
    (tmp_path / "t.csv").write_text("a,b\n")
    assert [len(column) for column in data.read_columns(tmp_path / "t.csv", ("a",)).values()] == [
        0,
        0,
    ]


@given(st.lists(st.floats(-1e12, 1e12), min_size=1, max_size=20))
def test_numbers_come_back_to_nine_digits(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("t") / "t.csv"
    data.write_columns(path, {"a": np.array(values)})
    np.testing.assert_allclose(data.read_columns(path, ("a",))["a"], values, rtol=1e-8)


def test_a_cell_with_a_comma_or_quote_is_quoted(tmp_path):
    data.write_columns(tmp_path / "t.csv", {"a": ['x, "y"', "plain"], "n": [1, True]})
    assert (tmp_path / "t.csv").read_text() == 'a,n\n"x, ""y""",1\nplain,1\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a,b,a\n1,2,3\n", ("row 1", "a more than once", "each column once")),
        ("a;b\n1;2\n", ("row 1", "separated by commas")),
        ("a,b\n1,2\n\n1,x\n", ("row 4", "numbers")),
        ("a,b\n1,2\n1e400,2\n", ("row 3", "found '1e400'", "a finite number")),
        ("a,b\n1,2\n1_000,2\n", ("row 3", "found '1_000'", "a number without underscores")),
    ],
)
def test_a_csv_that_is_not_what_it_seems_is_refused_with_its_row(tmp_path, text, words):
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(InputError) as reported:
        data.read_columns(path, ("a", "b"))
    assert all(word in str(reported.value) for word in words)


def test_quoted_numbers_are_numbers(tmp_path):
    (tmp_path / "t.csv").write_text('"a","b"\n"1.5","2"\n')
    assert data.read_columns(tmp_path / "t.csv", ("a",))["a"].tolist() == [1.5]


def test_a_point_counts_from_a_likelihood_of_0_6_on_or_where_none_is_stated():
    assert is_confident(np.array([0.59, 0.6, 1.0, np.nan])).tolist() == [False, True, True, True]


def test_a_frame_ten_times_less_sure_than_usual_is_poorly_seen():
    variance = np.array([1.0, 99.0, 101.0, np.nan])
    assert has_excess_variance(variance, 1.0).tolist() == [False, False, True, True]
