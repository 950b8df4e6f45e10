"""Questions to the person who makes a run: what only the lab knows, one key of run.toml after the other."""

from collections.abc import Callable, Iterator

from tribopipe.readers.draft.blanks import BLANKS
from tribopipe.readers.draft.known_values import LOAD, Known

Ask = Callable[[str], str]
"""Shows a question and gives the answer, "" for none."""
Say = Callable[[str], None]

_SHAPE = "contact.pin.shape"
_QUESTIONS = (
    LOAD,
    "conditions.sliding_speed",
    _SHAPE,
    "contact.pin.radius",
    "contact.pin.flat_radius",
    "contact.pin.material",
    "contact.pin.youngs_modulus",
    "contact.pin.poisson_ratio",
    "contact.disc.material",
    "contact.disc.youngs_modulus",
    "contact.disc.poisson_ratio",
)
_MORE_WORDS = {
    LOAD: "; needed",
    _SHAPE: "; with none of the bodies described, friction alone is evaluated",
}


def ask_for_missing(known: Known, ask: Ask, say: Say) -> None:
    """Ask for what is not known, what is needed first; no answer leaves a key open."""
    for key in _open_questions(known):
        while answer := ask(_question(known, key)).strip():
            problem = known.take_text(key, answer)
            if problem is None:
                break
            say(problem)


def _open_questions(known: Known) -> Iterator[str]:
    """Give the keys to ask for, judged anew after each answer; of a pin whose shape is left open nothing is asked."""
    for key in _QUESTIONS:
        of_bodies = key.startswith("contact.")
        settled = key in known.given or (of_bodies and known.kind != "pin-on-disc")
        shapeless = of_bodies and key != _SHAPE and _SHAPE not in known.given
        if not settled and not shapeless and known.fits(key, BLANKS[key].value):
            yield key


def _question(known: Known, key: str) -> str:
    blank = BLANKS[key]
    doubts = [f"{doubt.value}: {doubt.why}" for doubt in known.doubts.get(key, [])]
    told = "; ".join([*(doubts or [f"such as {blank.value}"]), "Enter leaves it open"])
    return f"{key}, {blank.words}{_MORE_WORDS.get(key, '')} ({told})"
