"""Session that follows one run: new samples, estimates and alarms at each update."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from tribopipe.base.errors import ContactError, FitError
from tribopipe.base.units import show
from tribopipe.documents.preprocessing import Invert
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record
from tribopipe.evaluation.load_and_friction import load_share
from tribopipe.extras.live.alarms import (
    Alarm,
    AlarmKind,
    StuckSensor,
    alarm_at,
    blocks,
    counterbody_alarms,
    departure,
    friction_alarms,
    load_alarms,
)
from tribopipe.extras.live.estimate import Estimate, Posterior, estimated, posterior
from tribopipe.extras.live.follower import Appended, Follower
from tribopipe.extras.live.problem import Asked, live_problem
from tribopipe.extras.live.state import State


class LiveUpdate(Record):
    """Result of one update."""

    id: str
    """Name of the run."""
    samples: int
    """Samples with depth so far."""
    sliding_distance: Quantity | None = None
    """Sliding distance so far; none before the first sample."""
    estimate: Estimate | None = None
    """Estimate from the samples; None if there are too few."""
    reason: str | None = None
    """Why there is no estimate."""
    alarms: tuple[Alarm, ...] = ()
    """Alarms, each reported once."""
    notes: tuple[str, ...] = ()
    """Prior information and its source."""


class Session:
    """A run that is followed."""

    def __init__(self, folder: Path, asked: Asked) -> None:
        """Follow the run of a folder."""
        contact = asked.run.manifest.contact
        if contact is not None and not contact.sensor_tells:
            raise ContactError(
                f"{asked.run.id}: found a {contact.kind} run, whose wear cannot be determined from the depth signal "
                "during the test; expected a pin on a disc; process the run when it has ended"
            )
        self.asked = asked
        self.state = State()
        self.posterior: Posterior | None = None
        """k_D by the last update; none while it is unknown."""
        self.grew = False
        """True if there are samples since the update before the last."""
        self._follower = Follower(asked.run.manifest, folder)
        self._sensor = StuckSensor()
        self._reached: float | None = None
        self._reason = "no samples yet"
        self._told: set[AlarmKind] = set()

    def look(self) -> LiveUpdate:
        """Take in what has come, and report what it shows.

        Raises ``TribopipeError`` where the files cannot be read, or hold nothing that can be followed.
        """
        self.grew, alarms = False, list[Alarm]()
        for appended in self._follower.look():
            alarms += self._taken(appended)
        if self.grew:
            self._judge()
            alarms += self._amiss()
        return self._update(alarms)

    def still(self, seconds: float) -> LiveUpdate:
        """Report that nothing has come for so long, unless the planned end was reached, or nobody knows it."""
        planned, reached = self.asked.planned, self._reached or 0.0
        if planned is None or self.asked.ends_at(reached):
            return self._update([])
        message = (
            f"no data have been appended for {seconds:.0f} s (at {show(reached, None, 'm')} of "
            f"{show(planned, None, 'm')}): the test or its recording may have stopped"
        )
        return self._update([alarm_at("stalled", reached, message)])

    def _taken(self, appended: Appended) -> Iterator[Alarm]:
        """Take in samples."""
        if "depth" not in appended.columns:
            raise FitError(
                f"{self.asked.run.id}: found no depth signal; expected one, to determine the wear; map "
                "its column in run.toml"
            )
        if appended.anew:
            self.state, self._sensor = State(), StuckSensor()
            message = "the file was truncated or replaced: restarting from its new content"
            yield Alarm(kind="replaced", message=message)
        turned = any(isinstance(step, Invert) and "depth" in step.signals for step in self.asked.recipe.clean_up)
        columns = dict(appended.columns) | ({"depth": -appended.columns["depth"]} if turned else {})
        self.asked = replace(self.asked, run=replace(self.asked.run, origins=appended.origins))
        self.state.add(columns)
        self._sensor.add(columns["depth"], columns["sliding_distance"])
        if len(columns["depth"]):
            self.grew, self._reached = True, float(columns["sliding_distance"][-1])

    def _judge(self) -> None:
        try:
            self.posterior = posterior(live_problem(self.asked, self.state), self.asked.recipe.monte_carlo)
        except FitError as error:
            self.posterior, self._reason = None, str(error)

    def _amiss(self) -> Iterator[Alarm]:
        """Report what does not look sound."""
        yield from self._sensor.alarms()
        if not self.state.samples or not self._reached:
            return
        means = blocks(self.state, self.asked.planned or self._reached)
        if self.asked.run.origins.get("normal_force") == "measured":
            nominal = self.asked.run.manifest.conditions.normal_load.value
            share = load_share(self.asked.run, self.asked.recipe.uncertainty)
            yield from load_alarms(means, nominal, share * nominal)
        yield from friction_alarms(means)
        if self.posterior is not None:
            yield from counterbody_alarms(self.posterior)
        if self.posterior is not None and self.asked.planned is not None:
            found = departure(self.posterior, self.asked.run.manifest, self.state, self.asked.planned)
            yield from [] if found is None else [found.alarm]

    def _update(self, alarms: list[Alarm]) -> LiveUpdate:
        new = list({alarm.kind: alarm for alarm in reversed(alarms) if alarm.kind not in self._told}.values())
        self._told |= {alarm.kind for alarm in new}
        found = self.posterior
        return LiveUpdate(
            id=self.asked.run.id,
            samples=self.state.samples,
            sliding_distance=None if self._reached is None else Quantity(value=self._reached, unit="m"),
            estimate=None if found is None else estimated(found, self.asked.law, self.asked.planned),
            reason=self._reason if found is None else None,
            alarms=tuple(new),
            notes=self.asked.known.notes,
        )

    @property
    def alarmed(self) -> bool:
        """True if there was an alarm so far."""
        return bool(self._told)
