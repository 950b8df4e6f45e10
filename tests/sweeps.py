"""Cases of one test of which a few stand for all in the default tests; CI runs the others with the slow ones."""

from collections.abc import Iterable

import pytest


def others_slow(cases: Iterable, *telling: object, first: int = 1) -> list:
    """Leave all cases to the slow tests but the telling ones; where none is named, all but the first so many."""
    listed = [case if hasattr(case, "marks") else _param(case) for case in cases]
    if telling:
        places = [place for place, case in enumerate(listed) if _values(case) in telling]
        assert len(places) == len(telling), f"found {len(places)} cases, expected these: {telling}"
    else:
        places = list(range(first))
    return [case if place in places else _slow(case) for place, case in enumerate(listed)]


def _param(case: object):
    return pytest.param(*case) if isinstance(case, tuple) else pytest.param(case)


def _values(case) -> object:
    return case.values[0] if len(case.values) == 1 else case.values


def _slow(case):
    marks = [mark for mark in case.marks if mark.name != "slow"]
    return pytest.param(*case.values, marks=[*marks, pytest.mark.slow], id=case.id)
