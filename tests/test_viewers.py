"""The field's own viewers open a run on its wear curve: silx, nexusformat, h5glance (and h5web: test_browser.py)."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import silx.io
from silx.io import nxdata

from tribopipe.archive.store import Archive

BANDS = ["archard", "archard_lower", "archard_upper", "sarkar", "sarkar_lower", "sarkar_upper"]


@pytest.fixture(scope="module")
def expected(sample_archive) -> np.ndarray:
    step = sample_archive.step("si3n4-air-200mN", "drift_correction")
    return step.curves["pin_wear_depth"][0] * 1e6


def test_silx_opens_a_run_on_its_wear_curve(sample_archive, expected):
    with silx.io.open(str(sample_archive.path("si3n4-air-200mN"))) as file:
        shown = nxdata.get_default(file)
        assert shown.is_valid
        assert (shown.signal_name, shown.axes_dataset_names) == ("pin_wear_depth (um)", ["sliding_distance"])
        assert shown.auxiliary_signals_names == BANDS
        assert shown.title == "Wear of the pin, run si3n4-air-200mN"
        np.testing.assert_allclose(shown.signal[()], expected, rtol=1e-12)


# nexusformat 2.1 shapes arrays in a way that NumPy 2.5 deprecates.
@pytest.mark.filterwarnings("ignore:Setting the shape on a NumPy array:DeprecationWarning")
def test_nexusformat_plots_the_wear_curve(sample_archive, expected):
    from nexusformat.nexus import nxload

    shown = nxload(str(sample_archive.path("si3n4-air-200mN"))).plottable_data
    assert shown.nxpath == "/entry/wear"
    assert [axis.nxname for axis in shown.nxaxes] == ["sliding_distance"]
    np.testing.assert_allclose(shown.nxsignal.nxdata, expected, rtol=1e-12)


def test_both_open_two_discs_on_theirs(disc_pair):
    from nexusformat.nexus import nxload

    path = disc_pair.path(disc_pair.ids()[0])
    with silx.io.open(str(path)) as file:
        shown = nxdata.get_default(file)
        assert shown.is_valid
        assert (shown.signal_name, shown.axes_dataset_names) == ("wear_depth (um)", ["rotations"])
    assert nxload(str(path)).plottable_data.nxpath == "/entry/wear"


@pytest.mark.slow
def test_h5glance_reads_as_the_run_does(sample_archive: Archive):
    script = Path(sys.executable).with_name("h5glance")
    if not script.exists():
        script = script.with_suffix(".exe")
    printed = subprocess.run(
        [script, sample_archive.path("si3n4-air-200mN"), "entry"], capture_output=True, encoding="utf-8", check=True
    ).stdout
    groups = [line.split("\t")[0][1:].split(" (")[0] for line in printed.splitlines() if line[:1] in "├└"]
    told = ["conditions", "end_values", "raw", "drift_correction", "friction_fit", "wear_fit_archard", "wear"]
    assert [name for name in groups if name in told] == told
