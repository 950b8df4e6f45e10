"""Kinds of contact by the names that run.toml gives them: tribopipe's own, and those that other packages add.

Another package adds a kind under the entry point ``tribopipe.contacts``; its class is a ``SlidingPin``.
"""

from collections.abc import Mapping
from importlib.metadata import EntryPoint
from typing import Annotated, Any, TypeVar, cast, get_args

from pydantic import Field, GetCoreSchemaHandler, ValidationInfo, ValidatorFunctionWrapHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from tribopipe.base.plugins import Plugins
from tribopipe.documents.block_on_ring import BlockOnRing
from tribopipe.documents.contact import Contact, SlidingBall, SlidingPin, Specimen
from tribopipe.documents.four_ball import FourBall
from tribopipe.documents.pin_on_flat import BallOnDisc, PinOnDisc, Reciprocating, ReciprocatingBall
from tribopipe.documents.twin_disc import TwinDisc

Answer = TypeVar("Answer")
GROUP = "tribopipe.contacts"
_SHIPPED: tuple[type[Contact], ...] = (PinOnDisc, Reciprocating, BlockOnRing, FourBall, TwinDisc)


def family_of(contact: Contact, answers: Mapping[type[Contact], Answer]) -> Answer:
    """Return the answer for the family of a contact."""
    return next(answers[family] for family in type(contact).__mro__ if family in answers)


def kind_of(contact: type[Contact]) -> str:
    """Return the kind that run.toml names a class by."""
    return str(get_args(contact.model_fields["kind"].annotation)[0])


SHIPPED: dict[str, type[Contact]] = {kind_of(contact): contact for contact in _SHIPPED}
"""tribopipe's own kinds of contact by their names in run.toml."""
ASSUMED: type[Contact] = PinOnDisc
"""Kind that is assumed where nothing states one."""
ROLES = tuple(dict.fromkeys(role for contact in _SHIPPED for role in contact.roles))
"""Bodies of all families, as post-test measurements and results call them."""
ROLLING_ROLES = tuple(role for contact in _SHIPPED if contact.tip_role is None for role in contact.roles)
"""Those of bodies that roll on each other, neither of which stays in contact."""
WITH_BALL: dict[str, type[SlidingBall]] = {kind_of(contact): contact for contact in (BallOnDisc, ReciprocatingBall)}
"""Those kinds whose pin may be a ball instead, with the ball."""


def _load(entry: EntryPoint) -> type[Contact]:
    contact = entry.load()
    if not (isinstance(contact, type) and issubclass(contact, SlidingPin)):
        raise TypeError(f"found {contact!r}; expected a subclass of SlidingPin")
    kinds = get_args(contact.model_fields["kind"].annotation)
    if kinds != (entry.name,):
        raise TypeError(f"found the kind {contact.model_fields['kind'].annotation}; expected Literal['{entry.name}']")
    if entry.name in SHIPPED:
        raise ValueError("the name is used by tribopipe itself")
    bodies = [
        contact.model_fields[name].annotation if name in contact.model_fields else None for name in contact.body_names
    ]
    specimens = all(isinstance(body, type) and issubclass(body, Specimen) for body in bodies)
    if len(bodies) != 2 or not specimens or not ("pin" in contact.model_fields or hasattr(contact, "pin")):
        raise TypeError(f"found the bodies {contact.body_names}; expected two specimens, one of them the pin")
    return contact


ADDED: Plugins[type[Contact]] = Plugins(GROUP, "contact", _load, kind_of)
"""Kinds that other packages add."""


def contacts() -> dict[str, type[Contact]]:
    """Return each kind of contact by its name in run.toml, tribopipe's own first."""
    return SHIPPED | dict(ADDED)


def body_like(contact: Contact, name: str) -> str:
    """Return the body of a contact that has the part of one of another contact: a ball or block that of a pin."""
    if name in contact.body_names:
        return name
    every = (*contacts().values(), *WITH_BALL.values())
    others = (one.body_names for one in every if one.roles == contact.roles and name in one.body_names)
    return next((contact.body_names[names.index(name)] for names in others), name)


def variants(kind: str | None) -> tuple[type[Contact], ...]:
    """Return the classes of a kind that is installed: with a pin, and with a ball instead; empty without a kind."""
    named = (contact_named(kind), None if kind is None else WITH_BALL.get(kind))
    return tuple(one for one in named if one is not None)


def alternatives(kind: type[Contact]) -> dict[str, str]:
    """Return the bodies of a kind that run.toml may describe as another one, and that other one: a ball for a pin."""
    others = WITH_BALL.get(kind_of(kind), kind).body_names
    return {name: other for name, other in zip(kind.body_names, others, strict=True) if name != other}


def with_a_pin(contact: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return ``[contact]`` as it is written, with a pin in the place of a ball that replaces it.

    Raises ``ValueError`` where both are described.
    """
    ball = WITH_BALL.get(contact.get("kind", ""))
    return contact if ball is None or "ball" not in contact else ball.with_a_pin(contact)


def contact_named(kind: object) -> type[Contact] | None:
    """Return the class of a kind; none of a kind that is not installed."""
    if not isinstance(kind, str):
        return None
    return SHIPPED.get(kind) or ADDED.get(kind)


def contact_described(contact: Any) -> type[Contact] | None:
    """Return the class of a contact, as run.toml describes it or as it was read; none of a kind that is unknown."""
    written = contact if isinstance(contact, Mapping) else {}
    kind = written.get("kind", getattr(contact, "kind", None))
    has_ball = isinstance(kind, str) and ("ball" in written or hasattr(contact, "ball"))
    return (WITH_BALL.get(kind) if has_ball else None) or contact_named(kind)


def spoken(name: str) -> str:
    """Write a key as words: "crowned disc" for ``curved_disc``."""
    for kind in contacts().values():
        for body, words in kind.body_words.items():
            name = name.replace(body, words)
    return name.replace("_", " ")


class _OfItsKind:
    """Has a contact read as the class of its kind, and written with all its fields."""

    def __init__(self, *shipped: type[Contact]) -> None:
        self._shipped = shipped

    def __get_pydantic_core_schema__(self, source: type[Contact], handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of tribopipe's kinds, which reports what is missing in a document without a kind."""
        union: Any = self._shipped[0]
        for kind in self._shipped[1:]:
            union |= kind
        tagged = Annotated[union, Field(discriminator="kind")] if len(self._shipped) > 1 else union

        def read(written: Any, own: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Contact:
            kind = written.get("kind") if isinstance(written, Mapping) else None
            if isinstance(written, source):
                return written
            if isinstance(kind, str):
                return _of_family(source, written).model_validate(written, context=info.context)
            return cast(Contact, own(written))

        anything = core_schema.simple_ser_schema("any")
        return core_schema.with_info_wrap_validator_function(
            read, handler.generate_schema(tagged), serialization=anything
        )


def _of_family(family: type[Contact], written: Mapping[str, Any]) -> type[Contact]:
    """Return the class of a contact. Raises ``ValueError`` where none of the family is installed by its kind."""
    contact = contact_described(written)
    if contact is None or not issubclass(contact, family):
        known = [name for name, other in contacts().items() if issubclass(other, family)]
        raise PydanticCustomError(
            "union_tag_invalid", "", {"discriminator": "'kind'", "expected_tags": ", ".join(map(repr, known))}
        )
    return contact


AnyContact = Annotated[Contact, _OfItsKind(*_SHIPPED)]
"""A contact of any installed kind."""
AnyTwinDisc = Annotated[TwinDisc, _OfItsKind(TwinDisc)]
"""Two discs that roll on each other, of any installed kind."""
AnySlidingPin = Annotated[SlidingPin, _OfItsKind(*(kind for kind in _SHIPPED if issubclass(kind, SlidingPin)))]
"""A pin on a counterbody, of any installed kind."""
