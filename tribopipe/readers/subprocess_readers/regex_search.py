"""First match of a regular expression.

Standard input is JSON: the pattern, and the texts to be searched one after the other. The answer is JSON, too: the
index of the first text with a match and what its first group matched, or else the whole match; null where none has one.
"""

import json
import re
import sys
from collections.abc import Iterable


def main() -> None:
    """Answer with the first hit."""
    pattern, texts = json.load(sys.stdin.buffer)
    sys.stdout.write(json.dumps(first_hit(pattern, texts)))


def first_hit(pattern: str, texts: Iterable[str]) -> tuple[int, str] | None:
    """Return the index of the first text with a match, and what matched."""
    wanted = re.compile(pattern, re.MULTILINE)
    for index, text in enumerate(texts):
        found = wanted.search(text)
        if found is not None:
            return index, (found[1] if wanted.groups else found[0]) or ""
    return None


if __name__ == "__main__":
    main()
