"""Many tasks at once, in processes of this machine or on a Dask cluster; each answer comes as soon as it is there.

    for task, answer in as_done(work, tasks, Crew(jobs=2)):
        ...

Who has several batches keeps the workers for all of them:

    with at_work(Crew(jobs=2)) as crew:
        ...
"""

from tribopipe.base.executor.pool import ALONE, Crew, as_done, at_work

__all__ = ["ALONE", "Crew", "as_done", "at_work"]
