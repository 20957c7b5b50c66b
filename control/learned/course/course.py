"""The course from here to the target: manoeuvre, landing, hold.

* MANOEUVRE: K periods to rest in the landing attitude. K comes from the shortest manoeuvre
  (`free_time`), sought from another start each period while the model is being learned, and counts
  down; `steer` re-solves the arrival exactly, with a period more when it can't be met.
* LANDING: the last periods. phi_n is past help, the rest still arrives exactly. A landing that
  began early takes phi_n along whenever the time left allows it, but takes no longer for it.
* HOLD: arrival `hold_periods` from now, every period anew: a linear feedback near the target. phi_n
  drifts, as it must, until it is worth another manoeuvre (`rearm_deg`).

A landing that misses is flown again at once, if phi_n is off by more than is worth waiting out
(`MISSED`), and once only.
"""

from dataclasses import dataclass, replace
from enum import Enum, StrEnum

import numpy as np

from ...ground.arrays import Array, Quaternion, WheelVector
from ...ground.attitude import error_angle
from ...model.momentum import MomentumModel
from ..belief.identify import Knowledge
from ..settings import LearnedSettings
from .arc import LENGTHS, Arcs
from .drift import drift_ahead, landing, phase_error
from .free_time import FreeTime, momentum_limit, solve_free_time
from .steering import Equations, Steering, steer

ACCEPTED = 5e-4  # rad, rad/s: an arrival that misses by more takes another period (0.03 deg)
EXTRA_PERIODS = (0, 1, 2, 4)  # tried in turn before the manoeuvre is sought anew
PATIENCE = 12  # Newton steps for an arrival with more periods than its guess had
WORTH_A_LOOP = np.deg2rad(0.1)  # phi_n below this is left over rather than flown around
MISSED = np.deg2rad(0.2)  # phi_n so far off after landing: in 80 s it is more error than the loop
LANDING_PERIODS = 3  # so close to the end no loop is left that would turn the body about n
OVERRUNS = 4  # periods by which a landing may be put off; then the hold takes what is left
SHARE = 2.0 / 3.0  # of the drift to come, by which the landing is biased: see `drift`
DRIFT_BOUND = 0.8  # of the re-arming error: how far off the landing may be biased


class CourseStatus(StrEnum):
    """What a command belongs to, as a sentence."""

    MANOEUVRE = "The shortest manoeuvre left is flown."
    STRETCHED = "The manoeuvre takes longer than planned."
    OPEN_ARC = "A manoeuvre too long, or too close to a speed limit, to be ended exactly yet."
    LANDING = "The last periods arrive exactly."
    AGAIN = "The landing missed and is flown again."
    HOLD = "The target is held."


class Phase(Enum):
    """Part of the course."""

    MANOEUVRE = "on the way"
    LANDING = "about to arrive"
    HOLD = "arrived"


@dataclass(frozen=True)
class Course:
    """What is planned from a control instant on."""

    phase: Phase
    torque: Array
    """Torque the rotors are to keep in each period, Nm, shape (K, m); none before a search."""
    searches_left: int
    """Periods in which the manoeuvre's shape will still be sought anew."""
    searches: int = 0
    """Searches made since the flight began: numbers the random starts."""
    status: CourseStatus = CourseStatus.MANOEUVRE
    steering: Steering | None = None
    """The exact arrival, where there is one."""
    overruns: int = 0
    """Periods by which the landing has been put off."""
    bias: float = 0.0
    """phi_n aimed at, rad."""
    again: bool = False
    """Whether this is the second try at a landing that missed."""


@dataclass(frozen=True)
class Situation:
    """Where the spacecraft is and what is known."""

    arcs: Arcs
    """Where plans lead, by this prediction."""
    model: MomentumModel
    knowledge: Knowledge
    x0: Array
    """(q, p, torque the rotors keep now), and what `arcs` wants beside."""
    torque_max: WheelVector
    """What the rotors can be given, Nm: the limit less friction."""

    @property
    def q(self) -> Quaternion:
        """Attitude, body -> inertial."""
        return self.x0[:4]

    @property
    def p(self) -> WheelVector:
        """Spin momenta, Nms."""
        return self.x0[4 : 4 + self.model.spacecraft.wheels]


@dataclass(frozen=True, eq=False)
class Navigator:
    """Plots courses to one target: settings and prepared problems, no state."""

    settings: LearnedSettings
    target: Quaternion
    period: float
    free_time: FreeTime

    def depart(self, wheels: int) -> Course:
        """A course that is still to be sought."""
        return Course(Phase.MANOEUVRE, np.zeros((0, wheels)), self.settings.search_plans)

    def advance(self, course: Course, here: Situation) -> Course | None:
        """The course one period later, re-solved from here; None if none was found."""
        course = replace(course, torque=course.torque[1:])
        if course.phase is Phase.HOLD:
            if error_angle(here.q, self.target) < np.deg2rad(self.settings.rearm_deg):
                return self._hold(course, here)
            course = self._depart_anew(course)
        elif self._missed(course, here):
            course = replace(self._depart_anew(course), again=True)
        in_all = self._land_in_all(course, here)
        if in_all is not None:
            return in_all
        if course.phase is Phase.MANOEUVRE:
            manoeuvre = self._manoeuvre(course, here)
            if manoeuvre is None or len(manoeuvre.torque) > LANDING_PERIODS:
                return manoeuvre
            course = manoeuvre
        return self._land(course, here) if len(course.torque) > 1 else self._hold(course, here)

    def _depart_anew(self, course: Course) -> Course:
        """A course still to be sought, from starts not tried before."""
        return replace(self.depart(course.torque.shape[1]), searches=course.searches)

    def _missed(self, course: Course, here: Situation) -> bool:
        """Whether a first landing that ends now has left phi_n too far from where it aimed."""
        if course.phase is not Phase.LANDING or len(course.torque) > 1 or course.again:
            return False
        return abs(phase_error(here.model, here.q, self.target) - course.bias) > MISSED

    def _manoeuvre(self, course: Course, here: Situation) -> Course | None:
        """The shorter of what is left of the old plan and what a search finds, made exact."""
        bias = self._bias(course, here)
        goal = landing(here.model, self.target, bias)
        course = replace(course, bias=bias)
        if course.searches_left > 0 or len(course.torque) == 0:
            found = self._search(course, here, goal)
            course = replace(
                course,
                searches_left=course.searches_left - 1,
                searches=course.searches + 1,
                torque=_shorter(course.torque, found),
            )
        if len(course.torque) == 0:
            return None
        return self._arrive(course, here, goal)

    def _bias(self, course: Course, here: Situation) -> float:
        """Minus the share of the drift to come, as far as it can be relied upon, rad."""
        hold = self.settings.hold_s
        delay = len(course.torque) * self.period
        drift = drift_ahead(here.model, here.knowledge, self.target, delay, hold)
        bound = DRIFT_BOUND * np.deg2rad(self.settings.rearm_deg)
        return float(np.clip(-SHARE * here.knowledge.reliance * drift, -bound, bound))

    def _search(self, course: Course, here: Situation, goal: Quaternion) -> Array | None:
        """Torques of the shortest manoeuvre from a new start, on the control grid and with a last
        period of rest."""
        number, limit = course.searches, here.torque_max
        best = solve_free_time(self.free_time, here.model, here.q, here.p, goal, limit, number)
        if best is None:
            return None
        periods = int(np.ceil((best.duration + self.settings.margin_s) / self.period))
        return np.vstack([best.on_grid(periods, self.period), np.zeros(limit.size)])

    def _arrive(self, course: Course, here: Situation, goal: Quaternion) -> Course:
        """The plan made to end in the goal, with as few periods more as that takes."""
        K = len(course.torque)
        if max(LENGTHS) < K + max(EXTRA_PERIODS):
            return replace(course, status=CourseStatus.OPEN_ARC, steering=None, searches_left=1)
        for extra in EXTRA_PERIODS:
            if extra == 1:
                early = self._land_early(course, here, goal)
                if early is not None:
                    return early
            guess = np.vstack([course.torque, np.zeros((extra, course.torque.shape[1]))])
            patience = PATIENCE if extra else PATIENCE // 2
            steering = self._steer(here, goal, guess, Equations.ALL, patience)
            if steering.miss < ACCEPTED:
                break
        else:  # too far off the plan: seek a new one next time, meanwhile fly the best there is
            status = CourseStatus.STRETCHED
            return replace(course, torque=steering.torque, status=status, searches_left=1)
        if _too_fast(here, steering):
            return replace(course, status=CourseStatus.OPEN_ARC, steering=None, searches_left=1)
        planned = CourseStatus.AGAIN if course.again else CourseStatus.MANOEUVRE
        status = CourseStatus.STRETCHED if extra else planned
        return replace(course, torque=steering.torque, steering=steering, status=status)

    def _land_early(self, course: Course, here: Situation, goal: Quaternion) -> Course | None:
        """An arrival that leaves phi_n as it is, where that is not worth a loop of its own."""
        landed = self._land(course, here)
        steering = landed.steering
        assert steering is not None
        left = phase_error(here.model, steering.x[-1, :4], goal)
        return landed if steering.miss < ACCEPTED and abs(left) < WORTH_A_LOOP else None

    def _land_in_all(self, course: Course, here: Situation) -> Course | None:
        """A landing that began early and can arrive in all of the attitude after all. Without this
        phi_n would be left to what each period's plan, as it is solved anew, makes of it."""
        if course.phase is not Phase.LANDING or len(course.torque) <= LANDING_PERIODS:
            return None
        bias = self._bias(course, here)
        goal = landing(here.model, self.target, bias)
        steering = self._steer(here, goal, course.torque, Equations.ALL, PATIENCE // 2)
        if steering.miss > ACCEPTED or _too_fast(here, steering):
            return None
        return replace(course, torque=steering.torque, steering=steering, bias=bias)

    def _land(self, course: Course, here: Situation) -> Course:
        """The rest of the plan, arriving in everything that the wheels move directly."""
        goal = landing(here.model, self.target, course.bias)
        steering = self._steer(here, goal, course.torque, Equations.ACTUATED, PATIENCE // 2)
        if steering.miss > ACCEPTED and course.overruns == OVERRUNS:
            return self._hold(course, here)
        if steering.miss > ACCEPTED:
            course = replace(course, overruns=course.overruns + 1)
            longer = np.vstack([course.torque, np.zeros_like(course.torque[:1])])
            steering = self._steer(here, goal, longer, Equations.ACTUATED, PATIENCE // 2)
        return replace(
            course,
            phase=Phase.LANDING,
            torque=steering.torque,
            steering=steering,
            status=CourseStatus.LANDING,
        )

    def _hold(self, course: Course, here: Situation) -> Course:
        """A few periods to rest at the target, phi_n left alone."""
        rest = np.zeros((self.settings.hold_periods, here.torque_max.size))
        steering = self._steer(here, self.target, rest, Equations.ACTUATED, PATIENCE // 4)
        return replace(
            course,
            phase=Phase.HOLD,
            overruns=0,
            torque=steering.torque,
            steering=steering,
            status=CourseStatus.HOLD,
        )

    def _steer(
        self, here: Situation, goal: Quaternion, guess: Array, equations: Equations, steps: int
    ) -> Steering:
        return steer(
            here.arcs,
            here.model,
            here.x0,
            goal,
            guess,
            here.torque_max,
            self.period,
            equations,
            steps,
        )


def _shorter(old: Array, new: Array | None) -> Array:
    return old if new is None or 0 < len(old) <= len(new) else new


def _too_fast(here: Situation, steering: Steering) -> bool:
    """Whether a wheel would pass its speed limit, and go further beyond it than now."""
    m = len(here.p)
    limit = np.maximum(momentum_limit(here.model.spacecraft, here.torque_max), np.abs(here.p))
    return bool(np.any(np.abs(steering.x[:, 4 : 4 + m]) > limit + 1e-9))
