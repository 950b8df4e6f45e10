"""Whether the time of a regular expression can grow faster than the text: judged by its parsed form.

A pattern becomes an automaton as Python's matcher walks it. Its time is linear where no text can be read in more ways
the longer it is: where there are no two places p and q and no word w, such that w leads from p to p, from p to q and
from q to q (Weber and Seidl, On the degree of ambiguity of finite automata, 1991). ``search`` and what is like it
begins at every character, which is one more place that reads anything. A match ends the search for others: a place from
where the pattern is already matched is no q.

Bounded repetitions stand for as many as three: they multiply the time by a number that does not grow with the text.
"""

import re
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import product
from typing import NamedTuple, TypeVar

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from re import _compiler, _constants, _parser  # type: ignore[attr-defined]  # isort: skip

SEARCHING = {"search", "finditer", "findall", "sub", "subn", "split", "scanner"}
_COPIES = 3
T = TypeVar("T")
_SAMPLE = "aZ_09!-. \t\n\r\x00\x1f\x7f\xe9\xb2\xa0\u0663\u2028\u4e2d"
Guard = Callable[[str | None, str | None], bool]
"""Whether a place may be passed between the character before it and the one behind it; none at an end."""


class Edge(NamedTuple):
    """From a place to another: without reading, where the guard says so, or by one of some characters."""

    to: int
    reads: frozenset[str] | None = None
    guard: Guard | None = None


class Automaton:
    """The places of a pattern, those in front first."""

    def __init__(self, pattern: re.Pattern) -> None:
        self._flags = pattern.flags
        self._is_bytes = isinstance(pattern.pattern, bytes)
        self._tree = _parser.parse(pattern.pattern, pattern.flags)
        self.edges: list[list[Edge]] = []
        self._sample = self._alphabet()
        self.looks_far = False
        """Whether what stands ahead decides by more than a character: then a match is none for sure."""
        self.end, self.nowhere = self._place(), self._place()
        self.start = self._build(list(self._tree), self.end)
        self.symbols = self._symbols()

    def steps(self, place: int, before: str | None, symbol: str) -> Counter[int]:
        """Return where a character leads to, and in how many ways."""
        found: Counter[int] = Counter()
        for edge in self._reading(place, before, symbol, ()):
            found[edge.to] += 1
        return found

    def is_matched(self, place: int, *, at_end: bool) -> bool:
        """Tell whether nothing more has to be read: whatever comes, or where the text ends."""
        reached, new = {place}, [place]
        while new:
            ahead = [edge.to for edge in self.edges[new.pop()] if edge.reads is None and self._is_open(edge, at_end)]
            new += [to for to in ahead if to not in reached]
            reached.update(ahead)
        return self.end in reached

    def _is_open(self, edge: Edge, at_end: bool) -> bool:
        return edge.guard is None or (at_end and all(edge.guard(before, None) for before in self.symbols))

    def kinds_before(self) -> dict[str, str]:
        """Return one of all characters that guards take alike as the one before a place, for each character."""
        guards = [edge.guard for edges in self.edges for edge in edges if edge.guard is not None]
        alike: dict[object, str] = {}
        told = {
            one: tuple(guard(one, after) for guard in guards for after in (None, *self.symbols)) for one in self.symbols
        }
        return {one: alike.setdefault(told[one], one) for one in self.symbols}

    def _reading(self, place: int, before: str | None, symbol: str, passed: tuple[int, ...]) -> Iterator[Edge]:
        for edge in self.edges[place]:
            if edge.reads is not None:
                if symbol in edge.reads:
                    yield edge
            elif edge.to not in passed and (edge.guard is None or edge.guard(before, symbol)):
                yield from self._reading(edge.to, before, symbol, (*passed, edge.to))

    def _place(self, *edges: Edge) -> int:
        self.edges.append(list(edges))
        return len(self.edges) - 1

    def _build(self, nodes: Sequence[tuple], to: int) -> int:
        """Return the place from where some nodes, one behind the other, lead to a place."""
        for node in reversed(nodes):
            to = self._node(*node, to)
        return to

    def _node(self, operation: object, argument: object, to: int) -> int:
        name = str(operation)
        if name in ("LITERAL", "NOT_LITERAL", "ANY", "IN"):
            return self._place(Edge(to, self._read_by((operation, argument))))
        return getattr(self, f"_{name.lower()}")(argument, to)

    def _subpattern(self, argument: tuple, to: int) -> int:
        return self._build(argument[-1], to)

    def _atomic_group(self, body: Sequence[tuple], to: int) -> int:
        return self._build(body, to)  # which may be left in more ways than it really is

    def _branch(self, argument: tuple, to: int) -> int:
        return self._place(*(Edge(self._build(body, to)) for body in argument[1]))

    def _max_repeat(self, argument: tuple, to: int) -> int:
        least, most, body = argument
        if most == _constants.MAXREPEAT:
            to = self._loop(body, to)
        else:
            for _ in range(min(most - least, _COPIES)):
                to = self._place(Edge(self._build(body, to)), Edge(to))
        for _ in range(min(least, _COPIES)):
            to = self._build(body, to)
        return to

    _min_repeat = _max_repeat

    def _possessive_repeat(self, argument: tuple, to: int) -> int:
        """One that repeats a character goes on as long as it can; any other is taken for one that may stop before."""
        least, most, body = argument
        reads = self._one_character(body)
        if most != _constants.MAXREPEAT or reads is None:
            return self._max_repeat(argument, to)
        to = self._loop(body, to, lambda _, after: after not in reads)
        for _ in range(min(least, _COPIES)):
            to = self._build(body, to)
        return to

    def _loop(self, body: Sequence[tuple], to: int, guard: Guard | None = None) -> int:
        turn = self._place()
        self.edges[turn] += [Edge(self._build(body, turn)), Edge(to, None, guard)]
        return turn

    def _assert(self, argument: tuple, to: int) -> int:
        return self._looks(argument, to, wanted=True)

    def _assert_not(self, argument: tuple, to: int) -> int:
        return self._looks(argument, to, wanted=False)

    def _looks(self, argument: tuple, to: int, *, wanted: bool) -> int:
        """Guard by a character; of what is longer ahead, what it reads is part of the automaton, and no guard."""
        direction, body = argument
        reads = self._one_character(body)
        if reads is not None:
            ahead = direction == 1
            return self._place(Edge(to, None, lambda before, after: ((after if ahead else before) in reads) is wanted))
        if direction == 1:
            self.looks_far = True
            return self._place(Edge(self._build(body, self.nowhere)), Edge(to))
        return to

    def _groupref(self, argument: int, to: int) -> int:
        if self._tree.state.groupwidths[argument][1] > 1000:
            raise NotImplementedError("a reference to a group of any length")
        return to

    def _at(self, argument: object, to: int) -> int:
        lines = bool(self._flags & re.MULTILINE)

        def is_word(one: str | None) -> bool:
            return one is not None and (one.isalnum() or one == "_")

        guards: dict[str, Guard] = {
            "AT_BEGINNING": lambda before, _: before is None or (lines and before == "\n"),
            "AT_BEGINNING_STRING": lambda before, _: before is None,
            "AT_END": lambda _, after: after in (None, "\n"),
            "AT_END_STRING": lambda _, after: after is None,
            "AT_BOUNDARY": lambda before, after: is_word(before) != is_word(after),
            "AT_NON_BOUNDARY": lambda before, after: is_word(before) == is_word(after),
        }
        return self._place(Edge(to, None, guards[str(argument)]))

    def _one_character(self, body: Sequence[tuple]) -> frozenset[str] | None:
        """Return what a body reads that reads one character; none of any other."""
        if len(body) == 1 and str(body[0][0]) in ("LITERAL", "NOT_LITERAL", "ANY", "IN"):
            return self._read_by(body[0])
        return None

    def _read_by(self, node: tuple) -> frozenset[str]:
        alone = _compiler.compile(_parser.SubPattern(self._tree.state, [node]), self._flags)
        return frozenset(one for one in self._sample if alone.fullmatch(self._as_read(one)))

    def _as_read(self, one: str) -> str | bytes:
        return one.encode("latin-1") if self._is_bytes else one

    def _alphabet(self) -> str:
        """Return characters of all kinds, and those that the pattern names with those beside them."""
        named = set(_SAMPLE)
        written = self._tree.state.str
        for one in written.decode("latin-1") if self._is_bytes else written:
            named |= {one, chr(max(ord(one) - 1, 0)), chr(ord(one) + 1), one.swapcase()[:1]}
        return "".join(sorted(one for one in named if not self._is_bytes or ord(one) < 256))

    def _symbols(self) -> list[str]:
        """Return one of all characters that every place and every guard takes alike."""
        alike: dict[object, str] = {}
        kinds = [edge.reads for edges in self.edges for edge in edges if edge.reads is not None]
        guards = [edge.guard for edges in self.edges for edge in edges if edge.guard is not None]
        for one in self._sample:
            read = tuple(one in reads for reads in kinds)
            passed = tuple(
                guard(*pair) for guard in guards for pair in ((None, one), (one, None), (one, "a"), ("a", one))
            )
            alike.setdefault((read, passed), one)
        return list(alike.values())


_ANYWHERE = -1
"""The place of one who has not begun."""
Where = tuple[int, str | None]
"""A place, and the character before it."""


class Walk:
    """An automaton as it is walked by a call."""

    def __init__(self, pattern: re.Pattern, call: str) -> None:
        self._automaton = automaton = Automaton(pattern)
        self._searches, self._to_the_end = call in SEARCHING, call == "fullmatch"
        self.symbols = automaton.symbols
        self.kinds = automaton.kinds_before()
        self.steps = cache(self._steps)
        self.is_matched = cache(self._is_matched)
        self.first: Where = (_ANYWHERE if self._searches else automaton.start, None)

    def _steps(self, where: Where, symbol: str) -> Counter[int]:
        place, before = where
        if place == _ANYWHERE:
            return Counter({_ANYWHERE: 1}) + self._automaton.steps(self._automaton.start, before, symbol)
        return self._automaton.steps(place, before, symbol)

    def begun(self, place: int) -> frozenset[int]:
        """Return where one is who begins at a place of the text, if that is what a place stands for."""
        return frozenset({self._automaton.start} if place == _ANYWHERE else ())

    def _is_matched(self, place: int) -> bool:
        """Tell whether a text is matched from here on, whatever it is."""
        if place == _ANYWHERE or self._automaton.looks_far:
            return False
        if not self._to_the_end and self._automaton.is_matched(place, at_end=False):
            return True
        if not self._automaton.is_matched(place, at_end=True):
            return False
        pairs = product({*self.kinds.values()}, self.symbols)
        return all(place in self._automaton.steps(place, before, one) for before, one in pairs)


def ambiguity(pattern: re.Pattern, call: str) -> str | None:
    """Return a word that can be read in more ways the more often it is repeated; none where there is none.

    Parameters
    ----------
    pattern : re.Pattern
    call : str
        What the pattern is called by: ``"match"``, ``"fullmatch"``, or one of ``SEARCHING``.
    """
    walk = Walk(pattern, call)
    ahead = _graph(walk)
    turns = _turns(ahead)
    homes = {where: group for group in turns for where in group}
    for group in turns:
        if word := _twice_around(walk, group):
            return word
    for p in homes:
        for q in homes.keys() & _reached(ahead, p):
            apart = homes[q] is not homes[p] and q[1] == p[1] and not walk.is_matched(q[0])
            if apart and (word := _word(walk, p, q, homes)):
                return word
    return None


def _twice_around(walk: Walk, group: set[Where]) -> str | None:
    """Return a character at which one who goes round has two ways that meet again: each turn doubles the time."""
    ahead: dict[tuple[int, int, str | None], dict[tuple[int, int, str | None], str]] = {}
    new = [(place, place, before) for place, before in group]
    while new:
        x, y, before = here = new.pop()
        if here in ahead:
            continue
        ahead[here] = {}
        for symbol in walk.symbols:
            kind = walk.kinds[symbol]
            ways = [
                {to: count for to, count in walk.steps((one, before), symbol).items() if (to, kind) in group}
                for one in (x, y)
            ]
            if x == y and any(count > 1 and not walk.is_matched(to) for to, count in ways[0].items()):
                return symbol
            ahead[here] |= {(a, b, kind): symbol for a, b in product(*ways) if not walk.is_matched(b)}
        new += ahead[here]
    for pairs in _turns({here: {*beyond} for here, beyond in ahead.items()}):
        if len({x == y for x, y, _ in pairs}) > 1:
            return next(ahead[one][to] for one in pairs for to in ahead[one] if one[0] == one[1] and to[0] != to[1])
    return None


def _next(walk: Walk, where: Where) -> set[Where]:
    return {(to, walk.kinds[symbol]) for symbol in walk.symbols for to in walk.steps(where, symbol)}


def _reached(ahead: Mapping[Where, set[Where]], first: Where) -> set[Where]:
    found, new = {first}, [first]
    while new:
        beyond = ahead[new.pop()] - found
        found |= beyond
        new += beyond
    return found


def _graph(walk: Walk) -> dict[Where, set[Where]]:
    """Return where each place leads to that a text may lead to."""
    ahead, new = {}, [walk.first]
    while new:
        where = new.pop()
        if where not in ahead:
            ahead[where] = _next(walk, where)
            new += ahead[where]
    return ahead


def _turns(ahead: Mapping[T, set[T]]) -> list[set[T]]:
    """Return groups of places that lead to each other, and so back to themselves."""
    numbers = {where: number for number, where in enumerate(ahead)}
    pairs = np.array([(numbers[one], numbers[to]) for one, beyond in ahead.items() for to in beyond]).reshape(-1, 2)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=2 * (len(ahead),))
    groups: dict[int, set[T]] = defaultdict(set)
    for where, label in zip(ahead, connected_components(graph, connection="strong")[1], strict=True):
        groups[label].add(where)
    return [group for group in groups.values() if any(ahead[one] & group for one in group)]


def _word(walk: Walk, p: Where, q: Where, homes: dict[Where, set[Where]]) -> str | None:
    """Return a word that leads from p to p, from p to q and from q to q.

    One that is matched from where it begins does not begin anew at its second character: all places that it leads to
    are looked at.
    """
    last, crowd = p[1], walk.begun(p[0])
    new = deque([((p[0], p[0], q[0]), crowd, last, "")])
    found = {new[0][:3]}
    while new:
        (x, y, z), crowd, before, word = new.popleft()
        for symbol in walk.symbols:
            kind = walk.kinds[symbol]
            begun = frozenset(to for place in crowd for to in walk.steps((place, before), symbol))
            if any(map(walk.is_matched, begun)):
                continue
            xs = [to for to in walk.steps((x, before), symbol) if (to, kind) in homes[p]]
            zs = [to for to in walk.steps((z, before), symbol) if (to, kind) in homes[q] and not walk.is_matched(to)]
            for there in product(xs, walk.steps((y, before), symbol) if xs and zs else (), zs):
                if there == (p[0], q[0], q[0]) and kind == last:
                    return word + symbol
                if (there, begun, kind) not in found:
                    found.add((there, begun, kind))
                    new.append((there, begun, kind, word + symbol))
    return None
