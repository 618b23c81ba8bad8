"""Feedback of measured wrenches and torques, as rates and limits of the Controller QP.

    effort rate = lambda_d' + Kp (lambda_d - lambda~) + Kd lambda_read'
    lambda~ <- a (lambda~ + dt lambda_flex') + (1 - a) lambda_read

(SEIKO Controller: Rouxel, Ivaldi and Mouret, RA-L 2024, equation (10); Kd is signed here.)
A contact whose sensor reads NaN goes on with its model: lambda~ integrates lambda_flex' alone.
"""

import math

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled
from w2c_controller.motion.filters import low_pass_gain
from w2c_controller.seiko.contacts import Enabled
from w2c_controller.seiko.desired import DesiredState
from w2c_controller.seiko.force_parameters import ForceParameters
from w2c_controller.sensing.loads import Measured

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]


class WrenchFeedback:
    """Wrench rates that bring measured wrenches to the desired ones; arrays are (4, 6)."""

    def __init__(self, parameters: ForceParameters, dt: float) -> None:
        self._dt = dt
        depth = max(round(parameters.difference_time / dt), 1)
        self._history = np.zeros((depth, 4, 6))
        self._next = 0
        self._gains = np.array(
            [
                parameters.proportional,
                parameters.damping,
                low_pass_gain(parameters.complementary_hz, dt),
                low_pass_gain(parameters.rate_hz, dt),
                depth * dt,
                dt / parameters.fade_in if parameters.fade_in > 0.0 else 1.0,
            ]
        )
        self._share = np.zeros(4)
        self._previous = np.zeros((4, 6))
        self._enabled = np.zeros(4, dtype=np.bool_)
        self._known = np.zeros(4, dtype=np.bool_)
        self.believed = np.zeros((4, 6))
        """lambda~, measured at low and modelled at high frequency [N, Nm]"""
        self.rates = np.zeros((4, 6))
        """lambda_read' [N/s, Nm/s]"""
        self.effort_rates = np.zeros((4, 6))
        """What the Controller QP is asked for [N/s, Nm/s]"""

    def reset(self, desired: DesiredState) -> None:
        """Start again; wrenches count as unknown until they are measured."""
        self._history[:] = np.nan
        self._known[:] = False
        self._share[:] = 0.0
        self._previous[:] = desired.wrenches
        self.believed[:] = desired.wrenches
        self.rates[:] = 0.0
        self.effort_rates[:] = 0.0

    def switch(self, enabled: Enabled) -> None:
        """Note new contacts: their wrench is taken as measured at the next step."""
        for k in range(4):
            self._known[k] = self._known[k] and enabled[k] == self._enabled[k]
            self._enabled[k] = enabled[k]
            if not self._known[k]:
                self._history[:, k] = np.nan
                self._share[k] = 0.0

    def step(self, desired: DesiredState, measured: Measured, model_rates: Matrix) -> None:
        """Update `effort_rates`.

        Args:
            desired: With the wrenches wanted.
            measured: Forces of the environment; NaN where a sensor reads NaN.
            model_rates: (4, 6) wrench rates of the flexible robot in the last tick.
        """
        _step(
            self._dt,
            self._gains,
            measured.feet,
            measured.hands,
            desired.contact_rotations,
            self._enabled,
            self._known,
            self._share,
            desired.wrenches,
            self._previous,
            model_rates,
            self._history[self._next],
            self.believed,
            self.rates,
            self.effort_rates,
        )
        self._next = (self._next + 1) % self._history.shape[0]


class TorqueLimits:
    """Limits of the flexible robot's joints that shrink where measured torques come too high.

    |tau_read| / tau_max > ratio: limit <- |tau_flex| + slack, where that is smaller;
    |tau_read| / tau_max < release: it grows back.
    """

    def __init__(self, parameters: ForceParameters, effort: Vector, dt: float) -> None:
        self._effort = effort
        self._bounded = parameters.mode == "full"
        self._settings = np.array(
            [
                parameters.torque_ratio,
                parameters.torque_ratio_release,
                parameters.torque_slack,
                parameters.torque_growth * dt,
                low_pass_gain(parameters.torque_hz, dt),
            ]
        )
        self._torque = np.full(effort.shape[0], np.nan)
        self.limits = np.full(effort.shape[0], np.inf)
        """(nj,) [Nm]"""
        self.reset()

    def reset(self) -> None:
        """Allow full effort again; without torque limits, any torque."""
        self._torque[:] = np.nan
        self.limits[:] = self._effort if self._bounded else np.inf

    def step(self, measured: Vector, model: Vector) -> None:
        """Update `limits`.

        Args:
            measured: (nj,) joint torques [Nm]; a joint that reads NaN keeps its limit.
            model: (nj,) torques of the flexible robot [Nm].
        """
        if self._bounded:
            _adapt(self._settings, self._effort, measured, model, self._torque, self.limits)


@compiled
def _step(
    dt: float,
    gains: Vector,
    feet: Matrix,
    hands: Matrix,
    surfaces: Matrix,
    enabled: Flags,
    known: Flags,
    share: Vector,
    desired: Matrix,
    previous: Matrix,
    model_rates: Matrix,
    oldest: Matrix,
    believed: Matrix,
    rates: Matrix,
    effort_rates: Matrix,
) -> None:
    """Update one tick; `oldest` is the slot of the ring that is read, then overwritten."""
    slow, smooth, window = gains[2], gains[3], gains[4]
    for k in range(4):
        share[k] = min(share[k] + gains[5], 1.0)
        proportional, damping = share[k] * gains[0], share[k] * gains[1]
        usable = True
        height = 6 if k < 2 else 3
        for i in range(height):
            if k < 2:
                value = feet[k, i]
            else:
                value = 0.0
                for j in range(3):
                    value += surfaces[k, j, i] * hands[k - 2, j]
            difference = value - oldest[k, i]
            if math.isfinite(difference):
                rates[k, i] += (1.0 - smooth) * (difference / window - rates[k, i])
            else:
                rates[k, i] = 0.0
            oldest[k, i] = value
            usable = usable and math.isfinite(value)
        for i in range(height):
            model = believed[k, i] + dt * model_rates[k, i]
            if not usable:
                believed[k, i] = model
                rates[k, i] = 0.0
            elif enabled[k] and known[k]:
                believed[k, i] = slow * model + (1.0 - slow) * oldest[k, i]
            else:
                believed[k, i] = oldest[k, i]
            effort_rates[k, i] = (
                (desired[k, i] - previous[k, i]) / dt
                + proportional * (desired[k, i] - believed[k, i])
                + damping * rates[k, i]
            )
            previous[k, i] = desired[k, i]
        known[k] = known[k] or usable


@compiled
def _adapt(
    settings: Vector,
    effort: Vector,
    measured: Vector,
    model: Vector,
    filtered: Vector,
    limits: Vector,
) -> None:
    """Update the filtered torques and the limits by one tick."""
    ratio, release, slack, growth, smooth = (
        settings[0],
        settings[1],
        settings[2],
        settings[3],
        settings[4],
    )
    for i in range(effort.shape[0]):
        if not math.isfinite(measured[i]):
            continue
        if math.isfinite(filtered[i]):
            filtered[i] = smooth * filtered[i] + (1.0 - smooth) * measured[i]
        else:
            filtered[i] = measured[i]
        load = abs(filtered[i]) / effort[i]
        tight = abs(model[i]) + slack
        if load > ratio:
            limits[i] = min(limits[i], tight)
        elif load < release:
            limits[i] = min(limits[i] + growth, effort[i])
