"""Regular expressions that a lab wrote, searched for in bounded time.

Some take a time that grows with two to the length of the text. One with at most a single sign of repetition or choice
cannot, where texts are short; any other is searched for by a process of its own, which costs 30 ms.
"""

import json
import re
from collections.abc import Sequence

from tribopipe.base.errors import ReaderError
from tribopipe.readers.subprocess_readers import answer_of
from tribopipe.readers.subprocess_readers.first_hit import first_hit
from tribopipe.results.run import SourceFile

_CHOICES = re.compile(r"[*+?{|]")
_MUCH = 2e7
"""Square of the length of a text, in all: one repetition may begin at each sign, and go on to the end."""


def search(pattern: str, texts: Sequence[str], file: str) -> tuple[int, str] | None:
    """Return the index of the first text in which a pattern is found, and what its first group, or it, matched.

    ^ and $ stand for the ends of lines. Raises ``ReaderError`` where the search takes too long.
    """
    if len(_CHOICES.findall(pattern)) < 2 and sum(len(text) ** 2 for text in texts) < _MUCH:
        return first_hit(pattern, texts)
    asked = SourceFile(file, json.dumps([pattern, texts]).encode("ascii"))
    try:
        found = json.loads(answer_of("first_hit.py", asked, remedy=""))
    except ReaderError:
        raise ReaderError(
            f"{file}: found no end to the search for {pattern!r}; expected a pattern that matches or fails "
            "immediately; write a simpler one, without nested repetition"
        ) from None
    return None if found is None else (found[0], found[1])
