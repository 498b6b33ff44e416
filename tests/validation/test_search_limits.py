"""What the limits of search and posterior leave out."""

from validation.search_limits import LimitEffects, limit_line, limit_summary


def test_summary_states_the_largest_gain_and_the_largest_change() -> None:
    found = [LimitEffects("a", (1.0, 5.0), 0, 0.0), LimitEffects("b", (3.0,), 2, 0.25, (-1.5, 0.5))]
    assert limit_summary(found) == (
        "2 studies: 3 sets, further rounds add 3.0 in the median, 5.0 at most; probabilities "
        "change by 0.2500 at most; the discrepancy of 2 has not come to rest, another fit changes "
        "their log posterior by 1.5 at most"
    )
    assert "b: 1 sets fitted to the end" in limit_line(found[1])
    assert "2 sets whose discrepancy has not come to rest" in limit_line(found[1])
