"""What figures show, in words: their captions, and what a screen reader says of them."""

from tribopipe.physics.laws import law_title

RUN_CAPTIONS = {
    "depth": (
        "Depth signal: what the sensor read; its zero offset and drift, and the corrected wear, where the run has what "
        "that takes. It ends on what was measured after the test (bar: 95 % interval)."
    ),
    "friction": "Friction coefficient as measured, what was fitted to it, and below, what is left over.",
    "clean-up": "Signals as recorded and as cleaned up.",
    "wear": (
        "Wear as measured, beside the laws as fitted and as predicted from other runs, with 95 % bands (bar: value "
        "measured after the test, 95 % interval)."
    ),
    "contact": "Wear depth, mean pressure and both half axes of the contact by the fitted law, with 95 % bands.",
    "local-wear": "Wear with the pressure solved for at each point, beside the global model.",
    "local-pressure": "Pressure over the contact as it wears.",
}
_STUDY_CAPTIONS = {
    "friction": "Friction coefficient of each run, and what was fitted to it.",
    "coefficient": (
        "Effective k_D of each run, by worn volume over load and distance in stretches of the curve, against the "
        "friction coefficient there; beside it what both laws say."
    ),
}


def study_caption(what: str, *, discs: bool) -> str:
    """Return the caption of a study's figure, by its name, of two discs or of a pin."""
    if what in _STUDY_CAPTIONS:
        return _STUDY_CAPTIONS[what]
    law = law_title(what.removeprefix("wear-"))
    if discs:
        return (
            f"Volume worn off each disc beside {law}, with 95 % bands; below, what was measured over what the law "
            "says. Filled markers: runs that identify k_D; open ones: runs that are predicted."
        )
    return (
        f"Pin wear depth of each run beside {law} with its 95 % band; the law is fitted to the runs that say so, and "
        "predicts the others."
    )
