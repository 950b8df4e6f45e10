"""The page that says how quantities are written, and in which units."""

from site_parts.markdown import code, table, titled
from tribopipe.base.units import KINDS, pretty
from tribopipe.documents.signals import SIGNALS

_FORMS = """
Write a number with its unit, in quotes:

```toml
normal_load = "200 mN"
```

State the standard uncertainty in the same unit or in percent of the value:

```toml
normal_load = { value = "200 mN", standard_uncertainty = "2 mN" }
normal_load = { value = "200 mN", standard_uncertainty = "1 %" }
```

Enter repeated readings of a post-test measurement as `values`: their mean is used, with its standard uncertainty. The
method of measurement is optional:

```toml
pin_scar_diameter = { values = ["383.1 um", "384.4 um", "383.6 um"], method = "white-light" }
```

Ratios can be written without a unit. Any other number without a unit is an error, and so is a unit of the wrong kind.
In Python, in the archive and in `--json` output, all numbers are in SI units.
"""


def quantities_page() -> str:
    """Return the page of quantities and their units."""
    kinds = (
        (f"[]{{#{name.replace(' ', '-')}}}{name}", code(f'"{kind.example}"'), _unit(kind.si), _unit(kind.shown))
        for name, kind in KINDS.items()
    )
    signals = ((code(name), signal.kind, _unit(signal.unit), signal.meaning) for name, signal in SIGNALS.items())
    return (
        titled(1, "Quantities, units, signals", "quantities")
        + _FORMS
        + titled(2, "Kinds of quantities")
        + table(("Kind", "Example", "Unit in the archive", "Unit in results"), kinds)
        + titled(2, "Signals", "signals")
        + table(("Signal", "Kind", "Unit in the archive", "Meaning"), signals)
    )


def _unit(unit: str) -> str:
    return "1" if unit == "1" else pretty(unit)
