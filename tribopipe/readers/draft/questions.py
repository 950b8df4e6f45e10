"""Questions to the person who makes a run: what only the lab knows, one key of run.toml after the other."""

import re
from collections.abc import Callable, Iterator

from tribopipe.readers.draft.blanks import blanks_of
from tribopipe.readers.draft.gathering import take_radius
from tribopipe.readers.draft.known_values import LOAD, Known, bodies_of, sections

Ask = Callable[[str], str]
"""Shows a question and gives the answer, "" for none."""
Say = Callable[[str], None]

_YES = ("y", "yes")
_BALL = re.compile(r"(?:D|dia[a-z]*|[Ø⌀∅])[\s=]*(?=\d)", re.IGNORECASE)
_PIN = "contact.pin"
_SHAPE = f"{_PIN}.shape"
_OF_THE_RUN = (LOAD, "conditions.sliding_speed")
_OF_A_PIN = ("shape", "radius", "flat_radius")
_OF_EACH = ("material", "youngs_modulus", "poisson_ratio")
_MORE_WORDS = {
    LOAD: "; needed",
    f"{_PIN}.radius": '; or "D = 6 mm" for a diameter',
    _SHAPE: "; without a description of the bodies, only friction is evaluated",
}


def ask_for_missing(known: Known, ask: Ask, say: Say) -> None:
    """Ask for what is not known, what is needed first; no answer leaves a key open."""
    for key in _open_questions(known):
        while answer := ask(_question(known, key)).strip():
            problem = _answered(known, key, answer)
            if problem is None:
                break
            say(problem)


def _answered(known: Known, key: str, answer: str) -> str | None:
    """Take an answer: y for what is offered, a ball by its diameter as "D = 6 mm", or a value."""
    offer, ball = known.offered(key), _BALL.match(answer)
    if offer is not None and answer.casefold() in _YES:
        return known.take(key, offer.value, f"{offer.why}, accepted")
    if key != f"{_PIN}.radius" or ball is None:
        return known.take_typed(key, answer)
    problem = known.take_typed(f"{_PIN}.diameter", answer[ball.end() :])
    take_radius(known)
    return problem


def _open_questions(known: Known) -> Iterator[str]:
    """Give the keys to ask for, judged again after each answer; of a pin whose shape is left open nothing is asked."""
    for key in (*_OF_THE_RUN, *_of_the_bodies(known.kind)):
        shapeless = key.startswith("contact.") and key != _SHAPE and _SHAPE not in known.given
        if key not in known.given and not shapeless and known.fits(key, blanks_of(known.kind)[key].value):
            yield key


def _of_the_bodies(kind: str) -> Iterator[str]:
    """Give the keys of a pin and its counterbody, and none of two discs."""
    if _PIN not in bodies_of(kind):
        return
    for table in bodies_of(kind):
        needed = (name for name, field in sections()[table].model_fields.items() if field.is_required())
        own = _OF_A_PIN if table == _PIN else tuple(name for name in needed if name not in _OF_EACH)
        yield from (f"{table}.{name}" for name in (*own, *_OF_EACH))


def _question(known: Known, key: str) -> str:
    blank = blanks_of(known.kind)[key]
    doubts = [f"{doubt.value}: {doubt.why}" for doubt in known.doubts.get(key, [])]
    yes = ["y accepts it"] if known.offered(key) else []
    told = "; ".join([*(doubts or [f"such as {blank.value}"]), *yes, "Enter leaves it open"])
    return f"{key}, {blank.words}{_MORE_WORDS.get(key, '')} ({told})"
