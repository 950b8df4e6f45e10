"""What figures show, in words: their captions, and their text for screen readers."""

from tribopipe.physics.laws import law_title

RUN_CAPTIONS = {
    "depth": (
        "Depth signal: sensor reading, its zero offset and drift, and the corrected wear, if available. The corrected "
        "wear ends at the post-test measurement (bar: 95 % interval)."
    ),
    "friction": "Measured friction coefficient with its fit; below, the residuals.",
    "clean-up": "Signals as recorded and after preprocessing.",
    "wear": (
        "Measured wear with the fitted and predicted laws and their 95 % bands (bar: post-test measurement, 95 % "
        "interval)."
    ),
    "contact": "Wear depth, mean pressure and both half axes of the contact with the fitted law, with 95 % bands.",
    "local-wear": "Wear with the local contact pressure, compared with the global model.",
    "local-pressure": "Pressure over the contact as it wears.",
}
_STUDY_CAPTIONS = {
    "friction": "Friction coefficient of each run, with its fit.",
    "coefficient": (
        "Effective k_D of each run, the wear volume over load and distance in windows along the curve, plotted against "
        "the friction coefficient there, with both laws."
    ),
}


def study_caption(what: str, *, discs: bool) -> str:
    """Return the caption of a study's figure, by its name, of two discs or of a pin."""
    if what in _STUDY_CAPTIONS:
        return _STUDY_CAPTIONS[what]
    law = law_title(what.removeprefix("wear-"))
    if discs:
        return (
            f"Wear volume of each disc with {law} and its 95 % band; below, measured over predicted wear. Filled "
            "markers: runs that identify k_D; open ones: runs that are predicted."
        )
    return (
        f"Pin wear depth of each run with {law} and its 95 % band; the law is fitted to the runs marked as fitted, and "
        "predicts the others."
    )
