"""Look over the licences of all that is installed for an interpreter, with pip-licenses: `licences.py PYTHON`."""

import json
import re
import subprocess
import sys

KNOWN = {
    "orjson": "MPL-2.0: binds who changes orjson's own files",
    "certifi": "MPL-2.0: a list of certificates, which rocrate's and SurfaceTopography's downloads bring",
    "npTDMS": "LGPL-3.0, so tdms is an extra",
    "igor2": "LGPL-3.0, brought by the extra surface",
}
"""What is not permissive and may be there all the same, and why."""
BINDING = re.compile(r"\b[AL]?GPL|\bMPL|\bE[UP]PL|\bCDDL|\bSSPL|Lesser|Affero|Mozilla|Eclipse|UNKNOWN")


def licences(python: str) -> dict[str, str]:
    """Return the licence of each package that an interpreter has installed."""
    command = ["pip-licenses", "--python", python, "--from=mixed", "--format=json"]
    listed = json.loads(subprocess.run(command, check=True, capture_output=True, encoding="utf-8").stdout)
    return {package["Name"]: package["License"] for package in listed}


def main(python: str) -> int:
    """Print what binds, and return 1 where something does that is not known to."""
    found = licences(python)
    binding = {name: licence for name, licence in found.items() if BINDING.search(licence)}
    for name, licence in binding.items():
        print(f"{name}: {licence}; {KNOWN.get(name, 'not known to .ci/licences.py')}")
    print(f"{len(found)} packages, {len(found) - len(binding)} of them MIT, BSD, Apache, PSF or like these")
    return int(not binding.keys() <= KNOWN.keys())


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
