"""The page that says how quantities are written, and in which units."""

from site_parts.markdown import code, table, titled
from tribopipe.base.units import KINDS, pretty
from tribopipe.documents.signals import SIGNALS

_FORMS = """
A number carries its unit, as a text:

```toml
normal_load = "200 mN"
```

With what it is uncertain by, one standard deviation, in the same unit or as a share of it:

```toml
normal_load = { value = "200 mN", standard_uncertainty = "2 mN" }
normal_load = { value = "200 mN", standard_uncertainty = "1 %" }
```

An end value may have been measured several times; its uncertainty is then that of the mean. It can say by what method:

```toml
pin_scar_diameter = { values = ["383.1 um", "384.4 um", "383.6 um"], method = "white-light" }
```

Ratios may be bare numbers. Anything else without a unit is refused, and so is a unit of another kind.
Inside tribopipe, in the archive and in `--json`, every number is SI.
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
        + table(("Kind", "Written as", "Archived in", "Shown in"), kinds)
        + titled(2, "Signals", "signals")
        + table(("Signal", "Kind", "Archived in", "Meaning"), signals)
    )


def _unit(unit: str) -> str:
    return "1" if unit == "1" else pretty(unit)
