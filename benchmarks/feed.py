"""A test that goes on: a recorded run is written anew, bit by bit, without what was measured after it.

    python benchmarks/feed.py sample_runs/si3n4-air-200mN growing --seconds 60

Bits end anywhere, as what a recorder writes does. To be followed meanwhile: `tribopipe live growing`.
"""

import argparse
import time
from pathlib import Path

import numpy as np

from tribopipe.documents.manifest import read_manifest


def _without_end_values(written: str) -> str:
    """Take the table [end_values] out of a run.toml."""
    kept, inside = [], False
    for line in written.splitlines(keepends=True):
        inside = line.startswith("[end_values]") or (inside and not line.startswith("["))
        kept += [] if inside else [line]
    return "".join(kept)


def main() -> None:
    """Write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("run", type=Path, help="run folder of one signal file")
    parser.add_argument("folder", type=Path, help="folder to write it into, bit by bit")
    parser.add_argument("--seconds", type=float, default=60.0, help="how long the test is to go on (%(default)s)")
    parser.add_argument("--bits", type=int, default=200, help="in how many bits it is written (%(default)s)")
    parser.add_argument("--until", type=float, default=1.0, help="share of the test after which it stops (%(default)s)")
    options = parser.parse_args()
    manifest, content = read_manifest(options.run / "run.toml")
    name = manifest.signals[0].names[0]
    recorded = (options.run / name).read_bytes()
    recorded = recorded[: round(options.until * len(recorded))]
    options.folder.mkdir(parents=True, exist_ok=True)
    (options.folder / "run.toml").write_text(_without_end_values(content.decode("utf-8")), encoding="utf-8")
    rng = np.random.default_rng(1)
    ends = np.sort(rng.choice(np.arange(1, len(recorded)), options.bits - 1, replace=False)).tolist()
    with (options.folder / name).open("wb") as file:
        for first, last in zip([0, *ends], [*ends, len(recorded)], strict=True):
            file.write(recorded[first:last])
            file.flush()
            time.sleep(options.seconds / options.bits)


if __name__ == "__main__":
    main()
