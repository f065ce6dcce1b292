"""The loop of `simulate`: compute batches leg by leg until the errors or another limit are reached."""

import math
import time
import warnings
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace

from transport.results.batches import Batch
from transport.results.record import Cost, Forecast
from transport.results.report import other_estimators
from transport.results.result import Result
from transport.run.executor import POLL_SECONDS, Executor, WorkersLost
from transport.run.forecast import Forecaster
from transport.run.interruption import Interruption
from transport.run.memory import check_memory
from transport.run.progress import Progress
from transport.run.provenance import Origin, distinct_origins, origin_warnings, this_origin
from transport.run.schedules import Leg, batches_in, schedule_for, sizes_of
from transport.run.settings import MAX_BATCHES, MAX_PARTICLES_UNSCORED, Settings
from transport.run.state import State, restore_schedule, saved_checks
from transport.run.stopping import Look, status_of
from transport.statistics.notation import duration, ratio_text
from transport.validation import SceneError

# Number of particles after which a class of paths without a score is assumed never to score.
UNSCORED_PARTICLES = 1 << 18
MISSING_BATCHES = "are in none of these runs"  # identifies the warning about missing batches of a merged run
RESPONSIVE_SECONDS = 1.0  # [s] that a batch may take in a run that can be interrupted


class IdleWarning(UserWarning):
    """Some threads of a run have no batches to compute."""


class Run:
    """A run takes batches in order, and checks errors between legs of batches only.

    Its end therefore does not depend on timing.
    """

    def __init__(
        self,
        settings: Settings,
        executor: Executor,
        bar: Progress,
        interruption: Interruption,
        preparation: float = 0.0,
        saved: Result | None = None,
        between: Callable[["Run"], None] | None = None,
    ) -> None:
        """Make a run that is new, or continues the saved one.

        preparation: time taken to start the executor [s]; between: called after each batch and every
        POLL_SECONDS, to save the run.
        """
        self.settings, self.limits = settings, settings.limits
        self.executor, self.bar, self.interruption = executor, bar, interruption
        self.plan, self.preparation, self.between = executor.plan, preparation, between
        self.threads, self.workers = executor.threads, executor.workers  # when the run begins
        self.warnings: list[str] = []
        self.looks: list[Look] = []
        self.forecast: Forecast | None = None
        # The totals of all batches, including those replaced by a later round.
        self.particles = self.crossings = self.collisions = 0
        self.leg: Leg = []  # the present leg
        self.done = 0  # finished batches of the present leg
        self.size = 0  # particles of a batch of the last leg begun; 0 before the first
        self.is_complete, self.is_idle_warned = True, False
        self.saved: State | None = None
        self.origins: tuple[Origin, ...] = ()  # provenance of the batches of the saved run
        if saved is not None:
            self.saved, self.origins = saved.state, saved.state.origins or (this_origin(),)
            self.forecast = None if saved.cost is None else saved.cost.forecast
            self.warnings += (warning for warning in saved._warnings if MISSING_BATCHES in warning)

    def go(self) -> None:
        """Run until a limit is reached or the run is interrupted; set `state`, `is_complete` and warnings."""
        self.interruption.begin()
        # Make the schedule, and refuse what does not fit into memory.
        self.begun = self.last_shown = time.perf_counter()
        self.schedule, self.forecaster = schedule_for(self.limits, self.plan), Forecaster(self.threads)
        if self.saved is not None:
            self.schedule.make_room()
        saved = self.saved
        here = sum(map(len, (saved.batches, saved.current, saved.ahead))) if saved else 0
        check_memory(self.plan, self.schedule, 0 if self.workers else self.threads, here)
        try:
            # Run leg after leg until the errors are reached.
            if self.saved is None or self._restore():
                while self._leg() and not self._is_enough():
                    pass
            self.interruption.check()
        except (KeyboardInterrupt, WorkersLost) as why:
            # Keep the batches finished so far, also those out of order.
            self.is_complete = False
            self.state = self.now()
            self._take_out_of_order()
            if isinstance(why, WorkersLost) and not self.batches:
                raise
            reason = f": {why}" if str(why) else ""
            self.warnings.append(f"interrupted after {len(self.batches)} batches{reason}")
            return
        self.state = self.now()
        if not_reached := self._missed_target():
            self.warnings.append(not_reached)

    @property
    def batches(self) -> list[Batch]:
        """Return the batches that the result is made of."""
        return self.schedule.kept

    @property
    def slopes(self) -> dict[str, float]:
        """Return the slope of each target's error against time, where it was measured."""
        if not self.looks:
            return {}
        found = {name: self.schedule.slope(self.looks, name) for name in self.limits.error}
        return {name: slope for name, slope in found.items() if slope is not None}

    def result(self, is_complete: bool) -> Result:
        """Return the result of the batches done so far; `state` must be theirs."""
        cost = Cost(
            seconds=self._elapsed,
            preparation=self.preparation,
            particles=self.particles,
            crossings=self.crossings,
            collisions=self.collisions,
            threads=self.threads,
            workers=self.workers,
            slopes=self.slopes,
            forecast=self.forecast,
        )
        settings = self.settings
        warnings = [*self.warnings, *self.executor.warnings, *origin_warnings(self.state.origins)]
        asked, choice, seed = settings.tracking, settings.choice, settings.seed
        return Result(self.plan, self.batches, seed, cost, is_complete, warnings, asked, choice, self.state)

    def _leg(self) -> bool:
        """Run the batches until the next error check; return False if there are none or time is up."""
        begun = time.perf_counter()
        if not self.leg:
            self._next_leg()
        if not self.leg:
            return False
        # Take batches in order. Between them save the run, check Ctrl-C and the time, and show the progress.
        self.size, sizes = self.leg[0][0], list(sizes_of(self.leg, self.done))
        with closing(self.executor.map(sizes, self.schedule.count)) as batches:
            for batch in batches:
                if batch is not None:
                    self._take(batch)
                if self.between is not None:
                    self.between(self)
                self.interruption.check()
                if self._is_late() and len(self.batches) > 1:
                    return False
                if time.perf_counter() - self.last_shown > POLL_SECONDS:
                    self._show()
                    if self.last_shown - begun > RESPONSIVE_SECONDS:
                        self._warn_idle()
        # Finish the leg, and time it for the forecast.
        self.schedule.end_leg()
        self.leg = []
        self.forecaster.add_leg(self.executor.done, time.perf_counter() - begun)
        return True

    def _next_leg(self) -> None:
        """Set the batches until the next error check; none where the run is over.

        A part of a run gets its own batches only.
        """
        self.leg, self.done = self.schedule.next_leg(self.looks), 0
        if self.limits.part != (1, 1) and self.leg:
            most = math.ceil(batches_in(self.leg) / self.schedule.together)
            if self.limits.part[1] > most:
                got = f"part must be one of at most {most} parts, got {self.limits.part}"
                cure = f"pass batches={self.limits.part[1]} or more, the same in every part"
                raise SceneError(f"simulate: {got}, as each needs a batch; {cure}")
            self.executor.next, self.leg = self.schedule.part(self.leg)

    def _take(self, batch: Batch) -> None:
        """Add a batch to the run."""
        self.particles += batch.histories
        self.crossings += batch.crossings
        self.collisions += batch.collisions
        self.schedule.take(batch)
        self.done += 1

    # ---- saving and resuming ----

    def now(self) -> State:
        """Return the state of the run between two batches."""
        schedule, saved = self.schedule, self.saved
        is_new = saved is None or self.particles > saved.particles
        return State(
            self.limits,
            type(schedule).__name__,
            {name: int(getattr(schedule, name)) for name in schedule.remembered},
            list(schedule.batches),
            self.executor.next,
            list(schedule.current),
            self.leg,
            self.done,
            dict(self.executor.ahead),
            list(self.looks),
            self.particles,
            self.crossings,
            self.collisions,
            self._elapsed,
            distinct_origins(self.origins, self._new_origins) if is_new else saved.origins,
        )

    @property
    def _new_origins(self) -> tuple[Origin, ...]:
        """Return the provenance of the new batches.

        It is that of the workers, or of this process where it resumes a run; else empty.
        """
        return self.executor.origins or (() if self.saved is None else (this_origin(),))

    def _restore(self) -> bool:
        """Restore the saved state; return whether the run must go on."""
        saved = self.saved
        self.executor.next, self.looks = saved.next, saved_checks(saved, self.limits)
        if restore_schedule(saved, self.schedule):
            self.leg, self.done, self.executor.ahead = saved.leg, saved.done, dict(saved.ahead)
        self.particles, self.crossings, self.collisions = saved.particles, saved.crossings, saved.collisions
        self.begun -= saved.seconds
        if self.leg or not self.limits.error:
            return not self._is_late()
        del self.looks[-1:]
        return not self._is_enough()

    def _take_out_of_order(self) -> None:
        """Take batches that were finished out of order into the result of a run that ends early."""
        for number in sorted(self.executor.ahead):
            self._take(self.executor.ahead[number])

    def _is_late(self) -> bool:
        return self.limits.seconds is not None and self._elapsed >= self.limits.seconds

    @property
    def _elapsed(self) -> float:
        return time.perf_counter() - self.begun

    def no_result_message(self) -> str:
        """Return the message of a run interrupted before its first batch.

        It states how long a batch takes, and how to shorten batches.
        """
        if not self.size:
            return "the time was used up before a batch was begun, so there is no result; pass more seconds"
        # particles per second of one thread, which computes one batch at a time
        rate = self.executor.started / self._elapsed / self.threads
        message = f"interrupted before the first batch of {self.size} particles was complete"
        message += ", so there is no result"
        if not rate > 0:
            return message
        takes = self.size / rate
        wanted = math.ceil((self.limits.particles or 0) / (RESPONSIVE_SECONDS * rate))
        message += f"; one takes about {duration(takes)}, and {self.threads} run at a time"
        if not self.limits.batches < wanted or takes < 2 * RESPONSIVE_SECONDS:
            return message
        return f"{message}; pass batches={min(wanted, MAX_BATCHES)} for shorter ones"

    # ---- error checks and forecasts between legs ----

    def _is_enough(self) -> bool:
        """Check the target errors and forecast the rest of the run; return whether the run may end."""
        if not self.limits.error:
            return False
        look = self._check_errors()
        self.looks.append(look)
        is_hopeless = look.is_blind and self.particles >= MAX_PARTICLES_UNSCORED
        if self.schedule.is_enough(self.looks) or is_hopeless:
            return not self._may_resolve(look, look.least_seen.unseen)
        # End where a single number has a finding that the other limits leave no room to resolve.
        of_numbers = look.max_unseen_number
        if not look.is_blind and of_numbers > 1 and not self._may_resolve(look, of_numbers):
            return True
        # Forecast the rest of the run, and keep the first clear forecast.
        to_come = (math.inf, 0) if look.is_blind else self.schedule.to_come(self.looks)
        self.forecaster.plan(self._elapsed, self.particles, *to_come)
        is_clear = self.forecaster.is_clear(look) and self.schedule.is_foreseen(self.looks)
        if self.forecast is None and is_clear:
            self.forecast = self.forecaster.forecast
        return False

    def _may_resolve(self, look: Look, times: float) -> bool:
        """Return whether the run should go on to resolve relevant paths that have not scored.

        It should where that is possible before its other limits are reached. times: factor of particles that
        this takes. Without another limit a run ends where its error should be reached.
        """
        if times <= 1:
            return False
        if look.particles < UNSCORED_PARTICLES:
            return True
        if self.limits.particles is None and self.limits.seconds is None:
            return times * look.particles <= look.particles_needed
        return times * look.particles <= self._particles_at_limits

    @property
    def _particles_at_limits(self) -> float:
        """Number of particles at which the run meets a limit other than its errors; 0 if it has none."""
        limits, rate = self.limits, self.particles / max(self._elapsed, 1e-9)
        ends = [] if limits.particles is None else [limits.particles]
        ends += [] if limits.seconds is None else [rate * limits.seconds]
        return min(ends, default=0)

    def _check_errors(self) -> Look:
        """Return an error check: what is known about the target errors."""
        result = Result(self.plan, self.batches, self.settings.seed, None, True, [])
        least, most = UNSCORED_PARTICLES / result.particles, self._particles_at_limits / result.particles
        standings = []
        for name, target in self.limits.error.items():
            each = status_of(name, result.quantity(name), target)
            # Go on until what has not scored is resolved, if the other limits leave room for it.
            awaited = each.unseen if each.unseen <= most else min(each.unseen, least)
            standings.append(replace(each, foretold=max(each.foretold, awaited)) if awaited > 1 else each)
        return Look(result.particles, len(self.batches), tuple(standings))

    def _missed_target(self) -> str | None:
        """Return the warning of a run that ended before its target errors; None where they were reached."""
        if not self.limits.error:
            return None
        look = self._check_errors()
        worst, doubted = look.worst, look.least_seen
        is_in_doubt = doubted.unseen > 1 and worst.relative < math.inf
        status = doubted if is_in_doubt else worst
        ratio = status.relative / status.target
        # Name the quantity furthest from its target, or the one with a finding, and the reason.
        why = []
        if ratio > 1:
            times = f"at {ratio_text(ratio)} times the requested error"
            why.append(times if ratio < math.inf else "without a score for it")
        if is_in_doubt:
            link = "and" if why and status.has_bins else "because"
            why.append(f"{link} {self._why_unresolved(status.unseen)}: {status.doubt}")
        if not why:
            return None
        stopped = f"{status.name}: stopped after {self.particles} particles, {', '.join(why)}"
        others = other_estimators(self.settings.scene, self.plan.method, self.settings.choice)
        return f"{stopped}. {others}" if others else stopped

    def _why_unresolved(self, times: float) -> str:
        """Return why a finding stays that this factor of particles would resolve."""
        if self.limits.particles is not None or self.limits.seconds is not None:
            return "running on to its limits would not resolve a finding"
        if math.isinf(times):
            return "running on would not resolve a finding"
        return f"it would take {ratio_text(times)} times as many particles to resolve a finding"

    def _warn_idle(self) -> None:
        """Warn, once, where there are fewer batches than threads."""
        batches, enough = batches_in(self.leg), self.threads * self.limits.part[1]
        if self.is_idle_warned or batches >= self.threads or self.schedule.count >= enough:
            return
        self.is_idle_warned = True
        idle = self.threads - batches
        message = f"{batches} batches for {self.threads} threads leave {idle} of them idle"
        message += f"; start the run with batches={enough} or more, or use threads={batches}"
        self.warnings.append(message)
        warnings.warn(message, IdleWarning, stacklevel=2)

    def _show(self) -> None:
        """Show the particles so far, the worst error and the expected time on the progress."""
        self.last_shown = time.perf_counter()
        particles, elapsed = self.particles + self.executor.started, self._elapsed
        ends = [self.forecaster.end(elapsed, particles)]  # [s], the earliest of which counts
        if self.limits.particles is not None and particles:
            ends.append(elapsed * self.limits.particles / particles)
        if self.limits.seconds is not None:
            ends.append(self.limits.seconds)
        self.bar.running(particles, elapsed, min(ends), self.looks[-1].worst if self.looks else None)
