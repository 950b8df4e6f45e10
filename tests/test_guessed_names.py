"""Expressions that somebody types who has not read the API, and how many of them work.

The first twenty were written down before the API was read, from the habits of pandas,
xarray and lmfit; ``run`` is a run folder that was read, ``archive`` an archive that was
opened, ``fit`` a wear fit.
"""

FROM_HABIT = (
    "tp.read_run(folder)",
    "run.columns",
    "run.head()",
    "run.describe()",
    "len(run)",
    "'depth' in run",
    "run.depth",
    "run['depth'].values",
    "run['depth'].mean()",
    "run['depth'].attrs['units']",
    "run.to_csv(path)",
    "run.plot()",
    "run.to_xarray()",
    "tp.open_archive(archive_path)",
    "archive.keys()",
    "archive.items()",
    "fit.params['k_d'].value",
    "fit.params['k_d'].stderr",
    "fit.residual",
    "fit.fit_report()",
)
