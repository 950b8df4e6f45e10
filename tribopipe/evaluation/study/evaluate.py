"""A study from beginning to end: k_D of the fitted runs, every run's prediction, and a verdict on each."""

from collections.abc import Mapping, Sequence

from tribopipe.documents.recipe import Recipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.study.discs import evaluate_discs
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.study.pins import evaluate_pins
from tribopipe.results.agreement import LeftOut
from tribopipe.results.study_curves import Evaluation


def evaluate(
    study: Study, members: Mapping[str, Member], recipe: Recipe | None = None, left_out: Sequence[LeftOut] = ()
) -> Evaluation:
    """Evaluate a study on its runs, ``members`` by id; runs left out are only named.

    Raises ``FitError`` where no run is left to fit, where runs differ in bodies or medium, or where a run lacks
    something that the law needs.
    """
    rolls = any(member.corrected.run.manifest.rolls for member in members.values())
    return (evaluate_discs if rolls else evaluate_pins)(study, members, recipe, left_out)
