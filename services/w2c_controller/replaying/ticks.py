"""Recorded states and commands, brought together tick by tick."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from w2c import topics
from w2c.through import Heard

PATIENCE = 500
"""States that come while a command waits for the one it answers, before that is given up"""
MOST_WAITING = 5000
"""States without a command"""


@dataclass(frozen=True)
class Tick:
    """A command, and the states that its controller ticked on since the one before."""

    command: Heard
    states: tuple[Heard, ...]
    """The last is the one that the command answers; those before it are of lost commands"""
    problem: str = ""
    """Why nobody can know what the controller ticked on; "" = it is known"""


@dataclass(frozen=True)
class _Waiting:
    command: Heard
    missing: int
    """Commands of this controller that were lost right before it"""


class Pairing:
    """Finds for each command what it was made of. Fed in the order of arrival."""

    def __init__(self) -> None:
        self._states: dict[tuple[str, int], Heard] = {}
        self._waiting: deque[_Waiting] = deque()
        self._newest: Heard | None = None
        """Command that arrived last"""
        self._missing = 0
        self._done: Heard | None = None
        """Command that was paired last"""
        self._since = 0

    def add(self, heard: Heard) -> Iterator[Tick]:
        """Take a state or a command; yields what is known now."""
        if heard.topic is topics.ROBOT_STATE:
            self._states[heard.envelope.boot_id, heard.envelope.sequence] = heard
            self._since += 1
            if len(self._states) > MOST_WAITING:
                del self._states[next(iter(self._states))]
        else:
            self._add_command(heard)
        while self._waiting:
            if self._answered(self._waiting[0].command) is None and self._since <= PATIENCE:
                return
            yield self._take(self._waiting.popleft())
            self._since = 0

    def finish(self) -> Iterator[Tick]:
        """Yield what waits for a state that does not come any more."""
        while self._waiting:
            yield self._take(self._waiting.popleft())

    def _add_command(self, command: Heard) -> None:
        last, self._newest = self._newest, command
        if not self._waiting:
            self._since = 0
        if last is None or last.envelope.boot_id != command.envelope.boot_id:
            self._missing = 0
        else:
            self._missing += max(command.envelope.sequence - last.envelope.sequence - 1, 0)
            if command.message.tick <= last.message.tick and _of_one_robot(command, last):
                return  # the same answer, for a robot that asked again
        self._waiting.append(_Waiting(command, self._missing))
        self._missing = 0

    def _answered(self, command: Heard) -> Heard | None:
        source = command.envelope.inputs[0] if command.envelope.inputs else None
        return None if source is None else self._states.get((source.boot_id, source.sequence))

    def _take(self, waiting: _Waiting) -> Tick:
        command, state = waiting.command, self._answered(waiting.command)
        last, self._done = self._done, command
        if state is None:
            tick = command.message.tick
            return Tick(command, (), f"the state of tick {tick} is not in the recording")
        before = self._forget_until(state)
        if not waiting.missing:
            return Tick(command, (state,))
        after = last.message.tick if last is not None else -1
        new = {one.message.tick: one for one in before if after < one.message.tick}
        new.pop(state.message.tick, None)
        if len(new) != waiting.missing:
            text = f"{waiting.missing} commands are missing, and which states they answered"
            return Tick(command, (state,), text)
        return Tick(command, (*new.values(), state))

    def _forget_until(self, state: Heard) -> list[Heard]:
        """Return the states before this one in order, and keep only those after it."""
        boot_id, tick, before = state.envelope.boot_id, state.message.tick, []
        for source, one in list(self._states.items()):
            if one.envelope.boot_id == boot_id and one.message.tick > tick:
                continue
            if one.envelope.boot_id != boot_id and one.seconds > state.seconds:
                continue
            if one.envelope.boot_id == boot_id:
                before.append(one)
            del self._states[source]
        return sorted(before, key=lambda one: one.message.tick)


def _of_one_robot(command: Heard, other: Heard) -> bool:
    """Tell whether two commands answer the same process of a robot."""
    boots = [one.envelope.inputs[0].boot_id for one in (command, other) if one.envelope.inputs]
    return len(boots) == 2 and boots[0] == boots[1]
