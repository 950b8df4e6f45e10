"""A lab whose folder is watched by a clock that tests set."""

from pathlib import Path

from tribopipe.documents.recipe import Recipe
from tribopipe.extras.watch.lab import Lab
from tribopipe.extras.watch.watcher import Watcher

TEMPLATE = 'schema = "tribopipe.template/1"\n[conditions]\nnormal_load = "5 N"\nsliding_speed = "0.1 m/s"\n'
SETTLE = 10.0


def export(seed: int = 0, rows: int = 12) -> bytes:
    """What an instrument writes, another one for each seed; longer ones begin as shorter ones do."""
    lines = [f"{n / 10:.1f},{2 + seed / 100 + (n * 7 % 5) / 10:.3f}\n" for n in range(rows)]
    return "".join(["Time [s],Friction force [N]\n", *lines]).encode()


class Bench:
    """A lab with a folder that is watched, by a clock that is set."""

    def __init__(self, folder: Path, **how) -> None:
        for name in ("in", "runs"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        self.folder, self.runs, self.template = folder / "in", folder / "runs", folder / "lab.toml"
        self.template.write_text(TEMPLATE, encoding="utf-8")
        (self.runs / ".watch").mkdir(exist_ok=True)
        how = {"template": self.template, "settle": SETTLE, "figures": False, **how}
        self.lab = Lab(self.folder, self.runs, folder / "archive", Recipe(), **how)
        self.now = 0.0
        self.start()

    def start(self) -> None:
        self.watcher = Watcher(self.lab)

    def put(self, name: str, content: bytes) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        return path

    def look(self, after: float = 0.0) -> list[tuple[str, str | None, str | None]]:
        """Look some time later; return what happened."""
        return [(event.kind, event.file, event.run) for event in self.told(after)]

    def told(self, after: float = 0.0) -> list:
        self.now += after
        return list(self.watcher.look(self.now))

    def settled(self) -> list[tuple[str, str | None, str | None]]:
        """See what is there, and look again when it has settled."""
        return self.look() + self.look(SETTLE)

    @property
    def made(self) -> dict[str, bytes]:
        """The runs, each with the bytes of its exports."""
        folders = (path for path in self.runs.iterdir() if path.name != ".watch")
        return {run.name: b"".join(path.read_bytes() for path in sorted(run.glob("*.csv"))) for run in folders}
