"""When an addition to a model pays: where the trials it was not fitted to gain clearly by it, and
where its strength is sure when trials are left out.
"""

from __future__ import annotations

import numpy as np

from .judge import Trialled

CLAIMS = (
    (1.0, 1e-9, 0.0), (7.0, 3e-5, 0.0),
    (10.0, 1e-4, 0.02),
    (1.0, 1e-5, 0.05), (2.0, 2e-4, 0.05), (10.0, 1e-3, 0.05), (30.0, 5e-3, 0.3), (40.0, 2e-3, 0.2),
)  # fmt: skip
"""Least held-out log likelihood over the inflation, the largest p value that goes with it, and the
least part of what all effects together gain. About 30 candidates are tried, so that chance alone
shows one of p = 2e-4 in one study of 150, but without a gain. Few trials leave more to chance,
which a large gain makes up for. What a strong effect of another form than nature's leaves over is
small beside it, and any candidate may pick it up: it must be surer, or gain much by itself. Of 737
candidates tried beside all true causes (120 concealed studies of seed 1003) the surest that gained
was at 6.3 and 4e-5. A cause that acts in few trials (a wall) is never sure by all of them: of those
tried in 600 concealed studies one is told by the last claim alone, and it was true.
"""
TOLD_ASIDE = 6.0
"""A side measurement (rigid lengths, the tail beat) that an effect makes this much likelier, 3.5
deviations, speaks for it by itself: no misfit of the paths can feign it.
"""
PLAINLY = 2.0
"""It does so whatever the paths gain where it is so many times as much (4.9 deviations): in nine
trials a fold may lose more by chance.
"""
AGAINST = 1.0
"""A side measurement that an effect makes less likely by this much speaks against it: a wrong lens
that bends lengths by 0.1 %, where none is seen to 0.05 %, stood in for the form of a wall's drag.
"""
STEADIER, LARGE, NOT_LIKELY = 0.5, 35.0, 0.01
"""An addition that brings the spread of the numbers over the trials down to this part pays by this
gain over the inflation where its strength is not likely nothing: of 1848 refits (64 concealed
studies of other makers) that did not pay one is so, a thrust loss in nine trials, and it was true.
"""
WRONG = 5.0
"""A model with this inflation or more does not describe its trials. Then a step from it foretells
little, two effects may have to be added at once for either to be seen, and the strength of one
that is true differs from trial to trial by what is missing besides.
"""
FIRST, NOT_CHANCE = 12.0, 0.05
"""So the first effects beside a wrong model pay by this gain over the inflation if they are not
likely chance. In 101 concealed studies of nine trials the best candidate was always true above 8;
in 55 more three were false (24 to 76), which paid by their p value as well, and the three that paid
by their gain alone were true.
"""
MOST_INFLATED, MUCH = 4.0, 0.2
"""An addition that spreads the numbers over trials this many times more than before explains
nothing: it bends the model to single trials. Unless it gains this part of all: then it is wrong in
form, which comes next.
"""


def pays(before: Trialled, after: Trialled, bare: Trialled | None = None) -> bool:
    """Whether the held-out gain is clear and the new effects' strengths are sure.

    bare: the model without effects, from which the gain of all effects together is counted.
    """
    gain = after.total - before.total
    aside = after.side - before.side
    if aside < -AGAINST:
        return False
    if aside > TOLD_ASIDE and (gain > 0 or (aside > PLAINLY * TOLD_ASIDE and gain > -np.inf)):
        return True
    part = gain / max(after.total - (bare or before).total, 1e-9)
    if after.inflation > MOST_INFLATED * before.inflation and part < MUCH:
        return False
    if not before.effects and opens(before, after):
        return True
    worth, p_value = gain / after.inflation, _chance(before, after)
    if after.inflation < STEADIER * before.inflation and worth > LARGE and p_value < NOT_LIKELY:
        return True
    return any(worth > least and p_value < most and part > share for least, most, share in CLAIMS)


def explains_aside(rival: Trialled, chosen: Trialled, without: Trialled) -> bool:
    """Whether a rival for the place of a chosen effect explains what side measurements say, where
    these speak for the effect by themselves: else it may be there as well, but is no rival.
    """
    told = chosen.side - without.side > TOLD_ASIDE
    return not told or rival.side > chosen.side - TOLD_ASIDE


def opens(before: Trialled, after: Trialled) -> bool:
    """Whether an effect added to a wrong model pays as one of the first."""
    worth = (after.total - before.total) / after.inflation
    return before.inflation > WRONG and worth > FIRST and _chance(before, after) < NOT_CHANCE


def _chance(before: Trialled, after: Trialled) -> float:
    """The largest p value of the effects added."""
    return max((after.p_value[e] for e in after.effects if e not in before.effects), default=0.0)
