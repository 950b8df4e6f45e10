"""Parameters of a wear law in addition to k_D as a recipe, or a plan, gives them: an input like any other."""

from collections.abc import Mapping, Sequence

from tribopipe.base.errors import FitError, did_you_mean
from tribopipe.base.units import show
from tribopipe.documents.quantity import Quantity, read_quantity
from tribopipe.documents.recipe import GivenParameter, LawName, Recipe
from tribopipe.physics.laws import WearLaw, law_named


def given_parameters(law: WearLaw, recipe: Recipe) -> dict[str, Quantity]:
    """Return the parameters that a recipe gives of a law. Raises ``FitError`` where it cannot have them."""
    return read_parameters(law, recipe.wear.parameters.get(law.name, {}), f"wear.parameters.{law.name}")


def read_parameters(law: WearLaw, written: Mapping[str, GivenParameter], where: str) -> dict[str, Quantity]:
    """Return parameters as they are written at a place. Raises ``FitError`` where a law cannot have them."""
    return {name: _read(law, name, said, f"{where}.{name}") for name, said in written.items()}


def _read(law: WearLaw, name: str, said: GivenParameter, where: str) -> Quantity:
    known = law.parameters()
    if name not in known:
        raise FitError(f"{where}: found a parameter that {law.title} does not have; {did_you_mean(name, known)}")
    try:
        quantity = read_quantity(said, known[name].kind)
    except ValueError as error:
        raise FitError(f"{where}: {error}") from None
    low, high = known[name].low, known[name].high
    if not low <= quantity.value <= high:
        ends = " to ".join(show(end, None, quantity.unit) for end in (low, high))
        raise FitError(f"{where}: found {quantity}; expected {ends}; correct it")
    return quantity


def law_as_given(name: LawName, recipe: Recipe) -> WearLaw:
    """Return a law with its parameters as a recipe gives them.

    Raises ``FitError`` where the law is not installed here, or has a parameter that is not given.
    """
    law = law_named(name)
    return law_with(law, given_parameters(law, recipe))


def law_with(law: WearLaw, given: Mapping[str, Quantity], place: str | None = None) -> WearLaw:
    """Return a law with parameters. Raises ``FitError`` where one is missing, saying where it belongs."""
    values = {law.input_of(name): quantity.value for name, quantity in given.items()}
    require_all(law, values, place)
    return law.at(values)


def require_all(law: WearLaw, values: Mapping[str, float], place: str | None = None) -> None:
    """Raise ``FitError`` where a parameter of a law is not among the values of inputs.

    It states where they belong: in a recipe, unless stated otherwise.
    """
    if missing := [parameter for parameter in law.parameters() if law.input_of(parameter) not in values]:
        raise FitError(
            f"{law.title}: found no {' and no '.join(missing)}; expected values, since only the fit of a single pin "
            f"identifies them; write them under {place or f'[wear.parameters.{law.name}] in a recipe'}"
        )


def indistinct(law: WearLaw, names: Sequence[str]) -> str:
    """Report that a run does not separate k_D from the parameters of its law."""
    return (
        f"wear fit: found a depth signal from which k_D and {' and '.join(names)} of {law.title} cannot be separated; "
        f"expected one that identifies them; give some under [wear.parameters.{law.name}] in a recipe, or fit another "
        "law"
    )
