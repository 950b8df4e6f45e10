"""Whether the files of an archive are those of its history: none lost, exchanged or rolled back to an earlier state."""

from collections import defaultdict
from collections.abc import Collection, Iterator, Set
from contextlib import ExitStack, suppress
from pathlib import Path, PurePosixPath

from tribopipe.archive.file_signature import STUDIES, SUFFIX, stamps
from tribopipe.archive.history import FILE_NAME, Account, Entry, Known, State, append, can_be_named, entry
from tribopipe.archive.lock import share_of, writers_lock
from tribopipe.archive.seal import state_of
from tribopipe.base.errors import ArchiveError, did_you_mean
from tribopipe.pipeline.verify.file_findings import Look

_ACCEPT = "tribopipe verify --accept"
_RESTORE = "the archive may have been replaced by an older copy: compare it with your backups"


def look_into_history(
    archive: Path, sound: Set[str], chosen: Collection[str] | None = None, against: str = ""
) -> tuple[list[Look], Account]:
    """Hold files against the history of their archive; return what was found, and the history.

    Parameters
    ----------
    archive
        Folder of the archive.
    sound
        Files that are whole, by their path in the archive; of others it is known already that they are not right.
    chosen
        Files to look at; all that are there or should be, where there is no choice.
    against
        Hash of a line that was kept elsewhere, or how it begins.

    Raises
    ------
    ArchiveError
        Where another process holds the lock of a file for minutes.
    """
    try:
        account = Account(archive).read()
        looks = [_look_at_itself(archive, account, against)]
        if account.begun:
            names = account.files.keys() | stamps(archive).keys() if chosen is None else chosen
            looks += _look_at_files(archive, account, sorted(names), sound)
    except OSError as error:
        look, account = Look(FILE_NAME), Account(archive)
        why = f"cannot be read ({error.strerror or error}); expected a readable file"
        look.error("history", why, "check its permissions, and run the command again")
        return [look], account
    return looks, account


def accept(archive: Path, wanted: str, by: str | None = None) -> list[str]:
    """Acknowledge that a run or a study is gone or is another one, or what is wrong with the history itself.

    Parameters
    ----------
    archive
        Folder of the archive.
    wanted
        Id of the run or study, or its path in the archive; ``history.jsonl`` for the history.
    by
        Who accepts it.

    Returns
    -------
    Paths in the archive of what was accepted.

    Raises
    ------
    ArchiveError
        Where nothing of that name is to be accepted.
    OSError
        Where the history cannot be written.
    """
    account = Account(archive).read()
    if wanted == FILE_NAME:
        _accept_history(archive, account, by)
        return [wanted]
    names = [f"{wanted}{SUFFIX}", f"{STUDIES}/{wanted}{SUFFIX}", f"{wanted}"]
    accepted = [name for name in names if name in account.files and _accepted(archive, account, name, by)]
    if not accepted:
        open_ones = [
            _without_suffix(name) for name in account.files if _is_open(account.files[name], _state(archive, name))
        ]
        raise ArchiveError(
            f"{archive}: found nothing to accept for {wanted!r}; expected a run or study that is missing or differs "
            f"from the history; {did_you_mean(wanted, open_ones)}"
        )
    return accepted


def _accepted(archive: Path, account: Account, name: str, by: str | None) -> bool:
    with writers_lock(archive, PurePosixPath(name).stem):
        state = state_of(archive / name)
        if not _is_open(account.read().files[name], state):
            return False
        append(archive, [entry("accepted", name, after=state, by=by)])
    return True


def _accept_history(archive: Path, account: Account, by: str | None) -> None:
    """Accept what is wrong with the history; where there is none, one begins with the files that are there."""
    if account.begun or stamps(archive) or account.missing():
        append(archive, [])  # which says what is missing
    if not account.read().problems:
        raise ArchiveError(f"{archive}: found nothing to accept for {FILE_NAME}; expected an incomplete history")
    append(archive, [entry("accepted", FILE_NAME, problems=account.fingerprint, by=by)])
    files = account.read().files
    unknown = {name for name in stamps(archive) if name not in files or files[name].by_hand}
    list(_look_at_files(archive, account, sorted(unknown), unknown))  # all are adopted, and need not be told one by one


def _look_at_itself(archive: Path, account: Account, against: str) -> Look:
    look, count, missing = Look(FILE_NAME), len(stamps(archive)), account.missing()
    begin = f"run `{_ACCEPT} {FILE_NAME}` to continue without it"
    if not account.begun and (count or missing):
        message = f"found {count} runs and studies, but no history of the archive; expected a history of all changes"
        look.error("history", message, f"restore it from a backup, or {begin}")
    elif missing:
        message = (
            f"found a history with missing lines (hash of the last of these: {missing[:16]}); expected a complete "
            "history"
        )
        look.error("history", message, f"restore it from a backup, or {begin}")
    for problem in account.problems:
        look.error("history", problem.found, f"restore it from a backup, or {begin}", f"line {problem.line}")
    if against and not account.has(against):
        message = f"found no line with the hash {against} in the history; expected the line specified with --against"
        look.error("history", message, _RESTORE)
    return look


def _look_at_files(archive: Path, account: Account, names: Collection[str], sound: Set[str]) -> Iterator[Look]:
    """Look closer at files that are not plainly as they should be, while nobody writes them; settle what can be."""
    shares = defaultdict(list)
    for name in names:
        if _is_in_doubt(account.files.get(name), _state(archive, name)):
            shares[share_of(PurePosixPath(name).stem)].append(name)
    for doubted in shares.values():
        looks = {name: Look(name) for name in doubted}
        with ExitStack() as held:
            with suppress(OSError):  # where nobody can write, nobody does
                held.enter_context(writers_lock(archive, PurePosixPath(doubted[0]).stem))
            account.read()
            settled = [one for name in doubted if (one := _judged(account, looks[name], _state(archive, name), sound))]
            if settled and account.is_whole:
                with suppress(OSError):
                    append(archive, settled)
        yield from looks.values()
    account.read()


def _judged(account: Account, look: Look, state: State, sound: Set[str]) -> Entry | None:
    """Note what is wrong with a file; return the line that settles what can be."""
    known, mend = account.files.get(look.name), f"run `{_ACCEPT} {_without_suffix(look.name)}` if this is intended"
    if known is None or (state is not None and known.states == {None}) or (known.by_hand and state in known.states):
        if state is None or look.name not in sound or not can_be_named(look.name):
            return None
        look.note(
            "history",
            "found a file that was added by hand; expected only files that tribopipe has written to this archive",
            "no action is needed",
        )
        return entry("adopted", look.name, after=state)
    if known.foreign:
        message = f"found a file that had been replaced before tribopipe changed it on {known.foreign}; expected the"
        look.error("history", f"{message} file written by tribopipe", f"compare it with a backup, and {mend}")
    elif state is None and None not in known.states:
        look.error(
            "history",
            f"found no file; expected the file written on {known.date}",
            f"restore it from a backup, or {mend}",
        )
    elif state not in known.states and look.name in sound:
        look.error("history", _other(known, state), f"restore it from a backup, or {mend}")
    elif known.unconfirmed and state in known.states:
        return entry("settled", look.name, after=state)
    return None


def _other(known: Known, state: State) -> str:
    if state in known.earlier:
        return f"found the version written on {known.earlier[state]}; expected the version written on {known.date}"
    return f"found a file that differs from the one written on {known.date}; expected the file written on that date"


def _is_in_doubt(known: Known | None, state: State) -> bool:
    return known is None or known.by_hand or known.unconfirmed or _is_open(known, state)


def _is_open(known: Known, state: State) -> bool:
    return bool(known.foreign) or state not in known.states


def _state(archive: Path, name: str) -> State:
    """Return the state of a file; "unreadable" where it cannot be read, which its other checks report."""
    try:
        return state_of(archive / name)
    except OSError:
        return "unreadable"


def _without_suffix(name: str) -> str:
    return name.removesuffix(SUFFIX)
