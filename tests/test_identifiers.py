"""ORCID, ROR, DOI and licence: what is right is taken in any spelling, what is mistyped is told."""

from contextlib import suppress

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ManifestError
from tribopipe.documents.dataset import Dataset, doi, orcid, orcid_check_digit, ror, spdx_licence
from tribopipe.documents.record import load_toml

FIFTEEN = st.text("0123456789", min_size=15, max_size=15)


def written(digits: str) -> str:
    """An ORCID from its first 15 digits."""
    all_of_it = digits + orcid_check_digit(digits)
    return "-".join(all_of_it[start : start + 4] for start in range(0, 16, 4))


@pytest.mark.parametrize("known", ["0000-0002-1825-0097", "0000-0001-5109-3700", "0000-0002-1694-233X"])
def test_orcids_that_orcid_org_shows_are_taken(known):
    assert orcid(known) == known
    assert orcid(f" https://orcid.org/{known.lower()} ") == known
    assert orcid(known.replace("-", "")) == known


@settings(max_examples=40)
@given(FIFTEEN)
def test_each_fifteen_digits_have_one_last_digit(digits):
    taken = [last for last in "0123456789X" if _is_taken(digits + last)]
    assert taken == [orcid_check_digit(digits)]


@settings(max_examples=40)
@given(FIFTEEN, st.integers(0, 14), st.sampled_from("0123456789"))
def test_one_mistyped_digit_is_told(digits, place, other):
    assume(digits[place] != other)
    last = orcid_check_digit(digits)
    with pytest.raises(ValueError, match="mistyped digit"):
        orcid(digits[:place] + other + digits[place + 1 :] + last)


@settings(max_examples=40)
@given(FIFTEEN, st.integers(0, 13))
def test_two_digits_exchanged_are_told(digits, place):
    first, second = digits[place : place + 2]
    assume(first != second)
    last = orcid_check_digit(digits)
    with pytest.raises(ValueError, match="mistyped digit"):
        orcid(digits[:place] + second + first + digits[place + 2 :] + last)


@settings(max_examples=40)
@given(st.text(max_size=40))
def test_any_text_is_an_orcid_or_told(text):
    if _is_taken(text):
        found = orcid(text)
        assert written(found.replace("-", "")[:15]) == found
    else:
        with pytest.raises(ValueError, match="expected an ORCID iD"):
            orcid(text)


def _is_taken(text: str) -> bool:
    try:
        orcid(text)
    except ValueError:
        return False
    return True


def test_other_identifiers_are_taken_in_any_spelling():
    assert ror("04t3en479") == ror("https://ror.org/04t3en479/") == "https://ror.org/04t3en479"
    assert doi("10.5281/zenodo.5720626") == doi("https://doi.org/10.5281/zenodo.5720626") == "10.5281/zenodo.5720626"
    assert spdx_licence("cc-by-4.0") == spdx_licence("https://spdx.org/licenses/CC-BY-4.0.html") == "CC-BY-4.0"


@pytest.mark.parametrize("read", [ror, doi, spdx_licence])
@settings(max_examples=25)
@given(text=st.text(max_size=30))
def test_any_other_text_is_told(read, text):
    with suppress(ValueError):
        assert read(text)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('license = "MIT"', "license: unknown key; did you mean 'licence'?"),
        ('licence = "CC BY 4"', "licence: found 'CC BY 4'; expected a license identifier from spdx.org/licenses"),
        ('licence = "MIT OR CC0-1.0"', "licence: found 'MIT OR CC0-1.0'; expected a license"),
        ('doi = "zenodo"', "doi: found 'zenodo'; expected a DOI"),
        ('published = "soon"', "published: found 'soon'"),
        ('publisher = { name = "KIT", ror = "kit" }', "publisher.ror: found 'kit'; expected a ROR ID"),
        ('language = "English"', "language: found 'English'"),
        ('creators = [{ given_name = "A" }]', "creators[0].family_name: missing; add this key"),
        ('creators = [{ family_name = "A", orcid = "0000-0002-1825-0098" }]', "creators[0].orcid: found"),
    ],
)
def test_mistake_in_dataset_toml_is_one_sentence(tmp_path, line, said):
    path = tmp_path / "dataset.toml"
    path.write_text(f'schema = "tribopipe.dataset/1"\n{line}\n', encoding="utf-8")
    with pytest.raises(ManifestError) as told:
        load_toml(path, Dataset)
    assert str(told.value).startswith(f"{path}: {said}")
    assert "\n" not in str(told.value)


def test_what_repositories_ask_for_is_named():
    said = {"schema": "tribopipe.dataset/1", "title": "Wear", "creators": [{"family_name": "Carberry"}]}
    assert Dataset.model_validate(said).lacking() == ["description", "licence", "the orcid of Carberry"]
