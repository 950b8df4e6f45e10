"""An archived run or study computed again from what it was made from, and compared number by number.

``reproduce(archive, run_id)`` reads a run again from its archived source files and takes each of its steps again, with
the options archived with it, from what the archive holds; ``reproduce_study(archive, study_id)`` evaluates a study
again. Both return a ``Reproduction``: a ``Redone`` for "raw" and each step in order, or for "study". Nothing is written
into the archive. Both raise ``ArchiveError`` where the run or study is not there or cannot be read; what goes wrong
with one step is given in its ``Redone``.
"""

from tribopipe.pipeline.reproduce.redone import Difference, Outcome, Redone, Reproduction
from tribopipe.pipeline.reproduce.runs import reproduce
from tribopipe.pipeline.reproduce.studies import reproduce_study

__all__ = ["Difference", "Outcome", "Redone", "Reproduction", "reproduce", "reproduce_study"]
