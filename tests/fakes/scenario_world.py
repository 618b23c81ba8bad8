"""A product and a world for scenarios, without processes: a table with two things, seen from above.

The camera hangs 2 m over the floor and looks straight down, x of the world to the right in the
picture and y up, so that a metre on the table (0.8 m high) is 1000 px / 1.2.
"""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count

import cv2
import msgspec
import numpy as np

from w2c import topics
from w2c.bus import CallContext
from w2c.bus.inprocess import InProcessBus, InProcessHub
from w2c.errors import RefusedError
from w2c.geometry import Intrinsics, Matrix, Vector, apply, inverse, transform
from w2c.messages import (
    Array,
    Box,
    CameraFrame,
    CameraView,
    CaptureRequest,
    ConfirmRequest,
    ControllerStatus,
    Evidence,
    GoalEvent,
    Picture,
    PictureRequest,
    SayRequest,
    Sighting,
    Target,
    Truth,
    Turn,
)
from w2c_evaluation.scenarios.eyewitness import Touching
from w2c_evaluation.scenarios.scenario import Meaning, Place, Prompt, Scenario

SIZE = (1280, 720)
INTRINSICS = Intrinsics(1000.0, 1000.0, 640.0, 360.0)
EYE = transform(np.diag([1.0, -1.0, -1.0]), (0.5, 0.0, 2.0))
TABLE_M = 0.8
HANDS = {"left_hand": 2, "right_hand": 3}


@dataclass(frozen=True)
class Thing:
    """A flat thing on the table."""

    name: str
    centre: tuple[float, float]
    size: tuple[float, float, float]

    def phrases(self) -> tuple[str, ...]:
        """Return its name."""
        return (self.name,)


THINGS = (Thing("book", (0.5, -0.2), (0.27, 0.2, 0.0)), Thing("cup", (0.8, 0.2), (0.1, 0.1, 0.0)))


@dataclass(frozen=True)
class Seen:
    """A surface."""

    owner: str
    point: Vector
    normal: Vector


SCENARIO = Scenario(
    "a",
    (
        Prompt(
            "Place your right hand on top of the book",
            Meaning("right_hand", "contact", "absolute", {"book": "book"}),
            Place("near the middle of the book", "book", spread=(0.12, 0.12, 0.0)),
        ),
        Prompt(
            "with your left hand, reach for the cup",
            Meaning("left_hand", "reach", "absolute", {"cup": "cup"}),
            Place("the middle of the cup", "cup"),
        ),
    ),
)


class FlatWitness:
    """A witness of the table."""

    effectors = {"left_sole": 0, "right_sole": 1, "palm": 2, "ball": 3}
    links = frozenset(effectors)
    objects = THINGS
    size = SIZE
    intrinsics = INTRINSICS

    def __init__(self) -> None:
        self.posed = 0

    def pose(self, generalized_position: Array) -> None:
        """Nothing moves."""
        self.posed += len(generalized_position) >= 0

    def world_from_object(self, name: str) -> Matrix:
        """Return the pose of a thing."""
        thing = next(thing for thing in THINGS if thing.name == name)
        return transform(np.eye(3), (*thing.centre, TABLE_M))

    def world_from_camera(self) -> Matrix:
        """Return the camera's pose."""
        return EYE

    def project(self, point: Vector) -> tuple[float, float] | None:
        """Return the pixel of a point."""
        return INTRINSICS.pixel_from_point(apply(inverse(EYE), point))

    def surface(self, u: float, v: float) -> Seen | None:
        """Return what is seen of the table."""
        x = EYE[0, 3] + (u - INTRINSICS.cx) / INTRINSICS.fx * (EYE[2, 3] - TABLE_M)
        y = EYE[1, 3] - (v - INTRINSICS.cy) / INTRINSICS.fy * (EYE[2, 3] - TABLE_M)
        owner = next(
            (
                thing.name
                for thing in THINGS
                if abs(x - thing.centre[0]) <= thing.size[0] / 2
                and abs(y - thing.centre[1]) <= thing.size[1] / 2
            ),
            "table",
        )
        return Seen(owner, np.array([x, y, TABLE_M]), np.array([0.0, 0.0, 1.0]))

    def owners(self, pixels: Array) -> list[str]:
        """Return what pixels show."""
        seen = [self.surface(u, v) for u, v in pixels]
        return ["" if one is None else one.owner for one in seen]

    def contacts(self) -> Sequence[Touching]:
        """Return nothing: what touches is the judge's test."""
        return ()


class FakeProduct:
    """Robot, camera, controller and dialogue in one: finds things, moves points, goes there.

    It understands `N cm to the left` and the like only where it is told what is meant, by `meant`.
    """

    def __init__(
        self, hub: InProcessHub, *, deaf: bool = False, misses_m: float = 0.0, loses: int = 0
    ) -> None:
        """Serve.

        Args:
            hub: The bus.
            deaf: Corrections change nothing.
            misses_m: How far beside the confirmed point hands end.
            loses: How many pictures the dialogue does not get.
        """
        self._buses = {name: hub.connect(name) for name in ("robot", "camera", "controller")}
        self._buses |= {name: hub.connect(name) for name in ("perception", "dialogue")}
        self._deaf = deaf
        self._misses_m = misses_m
        self._loses = loses
        self.captured = 0
        self._ids = count(1)
        self._target: Target | None = None
        self._instruction = ""
        self._hands = np.array([[0, 0.1, 0], [0, -0.1, 0], [0.2, 0.3, 1], [0.2, -0.3, 1.0]])
        self._forces = np.zeros((4, 3))
        self._stamp_ns = 0
        self._stop = threading.Event()
        self.jpeg = cv2.imencode(".jpg", np.full((*SIZE[::-1], 3), 200, np.uint8))[1].tobytes()
        dialogue: InProcessBus = self._buses["dialogue"]
        dialogue.serve(topics.SAY, self._say)
        dialogue.serve(topics.CONFIRM, self._confirm)
        self._buses["camera"].serve(topics.PICTURE, self._picture)
        self._buses["camera"].serve(topics.CAPTURE, self._capture)
        self._thread = threading.Thread(target=self._live, daemon=True)

    def __enter__(self) -> "FakeProduct":
        """Let time pass."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """End."""
        self._stop.set()
        self._thread.join(timeout=5.0)

    def _live(self) -> None:
        """Tell 0.1 s of robot time every millisecond."""
        while not self._stop.wait(0.001):
            self._stamp_ns += 100_000_000
            base = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
            truth = Truth(
                stamp_ns=self._stamp_ns,
                tick=self._stamp_ns // 2_000_000,
                generalized_position=np.zeros(3),
                world_from_base=base,
                end_effector_positions=self._hands.copy(),
                contact_forces=self._forces.copy(),
                fell=False,
            )
            self._buses["robot"].publish(topics.TRUTH, truth)
            if self._stamp_ns % 1_000_000_000 == 0:
                self._look()

    def _look(self) -> CameraFrame:
        frame = CameraFrame(
            stamp_ns=self._stamp_ns,
            frame="camera",
            width=SIZE[0],
            height=SIZE[1],
            intrinsics=INTRINSICS,
            jpeg=self.jpeg,
            depth=b"",
        )
        view = CameraView(
            stamp_ns=self._stamp_ns,
            world_from_camera=EYE,
            intrinsics=INTRINSICS,
            width=SIZE[0],
            height=SIZE[1],
        )
        status = ControllerStatus(
            stamp_ns=self._stamp_ns,
            tick=0,
            phase="hold",
            in_contact=(True, True, False, False),
            desired_forces=np.zeros((4, 3)),
            end_effector_positions=np.zeros((4, 3)),
            loads=np.zeros(4),
            solver_failures=0,
            lateness_us={},
            tick_us={},
        )
        self._buses["camera"].publish(topics.CAMERA_FRAME, frame)
        self._buses["perception"].publish(topics.CAMERA_VIEW, view)
        self._buses["controller"].publish(topics.CONTROLLER_STATUS, status)
        return frame

    def _capture(self, _request: CaptureRequest, _context: CallContext) -> CameraFrame:
        self.captured += 1
        return self._look()

    def _say(self, request: SayRequest, _context: CallContext) -> Turn:
        if self._loses > 0:  # a picture that never came
            self._loses -= 1
            return self._turn(
                request.text,
                "none",
                reply="The picture is unknown. Look at the live picture.",
                ok=False,
            )
        words = request.text.lower()
        named = [thing for thing in THINGS if thing.name in words]
        if named:
            self._instruction = words
            (x, y), box = named[0].centre, _box(named[0])
            # Vision points 6 cm beside the middle.
            return self._show(request, _pixel(x + 0.06, y), "prediction.absolute", named[0], box)
        target = self._target
        if target is None:
            raise RefusedError("no target")
        if any(yes in words for yes in ("yes", "perfect", "that's it")):
            return self._go(request.text, request.target_id)
        u, v = target.u, target.v
        if not self._deaf:
            u += 20.0 * ("right" in words) - 20.0 * ("left" in words)
            v += 20.0 * ("down" in words) - 20.0 * ("up" in words)
        return self._show(request, (u, v), "correction", None, None)

    def _show(
        self,
        request: SayRequest,
        pixel: tuple[float, float],
        module: str,
        thing: Thing | None,
        box: Box | None,
    ) -> Turn:
        seen = FlatWitness().surface(*pixel)
        assert seen is not None
        self._target = Target(
            target_id=f"target-{next(self._ids)}",
            frame_stamp_ns=request.frame_stamp_ns,
            u=pixel[0],
            v=pixel[1],
            point=seen.point,
            normal=seen.normal,
            state="proposed",
            boxes=[] if box is None else [box],
            phrases=[] if thing is None else [thing.name],
        )
        return self._turn(request.text, module, target=self._target)

    def _confirm(self, request: ConfirmRequest, _context: CallContext) -> Turn:
        return self._go("", request.target_id)

    def _go(self, text: str, target_id: str) -> Turn:
        target = self._target
        if target is None or target.target_id != target_id or target.point is None:
            raise RefusedError("another target is on the screen")
        limb = "left_hand" if "left" in self._instruction else "right_hand"
        task = "reach" if "reach" in self._instruction else "contact"
        goal_id = f"goal-{next(self._ids)}"
        threading.Timer(0.02, self._arrive, (goal_id, limb, task, target.point)).start()
        return self._turn(text, "confirmation", target, goal_id, limb, task)

    def _arrive(self, goal_id: str, limb: str, task: str, point: Vector) -> None:
        # The ball of the right hand touches with its surface, the left hand stops 2 cm before.
        away = np.array([self._misses_m, 0.0, 0.05 if task == "contact" else 0.02])
        self._hands[HANDS[limb]] = point + away
        if task == "contact":
            self._forces[HANDS[limb]] = (0.0, 0.0, 40.0)
        for state in ("accepted", "loaded" if task == "contact" else "reached"):
            event = GoalEvent(
                stamp_ns=self._stamp_ns,
                goal_id=goal_id,
                end_effector=limb,  # type: ignore[arg-type]
                task=task,  # type: ignore[arg-type]
                state=state,
            )
            self._buses["controller"].publish(topics.GOAL_EVENT, event)

    def _picture(self, _request: PictureRequest, _context: CallContext) -> Picture:
        return Picture(stamp_ns=self._stamp_ns, jpeg=self.jpeg)

    def _turn(
        self,
        text: str,
        module: str,
        target: Target | None = None,
        goal_id: str = "",
        limb: str = "",
        task: str = "",
        reply: str = "",
        *,
        ok: bool = True,
        retryable: bool = False,
    ) -> Turn:
        return Turn(
            stamp_ns=self._stamp_ns,
            text=text,
            module=module,
            reply=reply,
            ok=ok,
            retryable=retryable,
            target=target,
            goal_id=goal_id,
            end_effector=limb,
            task=task,
            seconds=0.1,
        )


class AskingProduct(FakeProduct):
    """Asks which of two things a `Place ...` means, and what the first correction is."""

    def __init__(
        self, hub: InProcessHub, *, among: Sequence[Thing] = THINGS, late: int = 0
    ) -> None:
        """Serve; `among` are the things that it hesitates between, the first answers are `late`."""
        super().__init__(hub)
        self._late = late
        self.heard: list[str] = []
        self._among = among
        self._held: SayRequest | None = None
        self._is_sure = False

    def _say(self, request: SayRequest, context: CallContext) -> Turn:
        self.heard.append(request.text)
        if len(self.heard) <= self._late:
            reply = "The vision model did not answer in time (5 s)."
            return self._turn(request.text, "none", reply=reply, ok=False, retryable=True)
        if self._held is not None and request.text in ("left", "right", "new place", "change"):
            held, self._held = self._held, None
            return super()._say(held, context)
        if request.text.startswith("Place"):
            self._held = request
            reply = "Which 'book' do you mean: left or right? I see 2 that fit."
            return self._question(request.text, reply, ["left", "right"])
        if self._target is not None and not self._is_sure and "yes" not in request.text:
            self._held, self._is_sure = request, True
            return self._question(request.text, "Which is it?", ["new place", "change"])
        return super()._say(request, context)

    def _question(self, text: str, reply: str, options: list[str]) -> Turn:
        boxes = [_box(thing) for thing in self._among]
        seen = Sighting(phrase="book", found=True, score=1.0, boxes=boxes)
        evidence = Evidence(prompts="embedded", sightings=[seen])
        turn = self._turn(text, "question", reply=reply, ok=False)
        return msgspec.structs.replace(turn, options=options, evidence=evidence)


def _pixel(x: float, y: float) -> tuple[float, float]:
    return INTRINSICS.pixel_from_point(apply(inverse(EYE), (x, y, TABLE_M)))


def _box(thing: Thing) -> Box:
    (x, y), (depth, width, _) = thing.centre, thing.size
    left, top = _pixel(x - depth / 2, y + width / 2)
    right, bottom = _pixel(x + depth / 2, y - width / 2)
    return Box(left=left, top=top, right=right, bottom=bottom, score=1.0)
