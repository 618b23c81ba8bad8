"""A router with the generated access list, certificates, and the buses of real services on it."""

import json
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from support.deploy import load_access_control
from support.ports import free_port
from support.waiting import wait_until
from w2c import topics
from w2c.bus.zenoh_bus import ZenohBus, connect
from w2c.config import ServiceConfig
from w2c.errors import ConnectionFailedError, UnavailableError
from w2c.messages import (
    GoalReply,
    GroundingReply,
    GroundingRequest,
    JointCommand,
    LogRecord,
    PlaceGoal,
    Truth,
)
from w2c.router import RouterConfig, open_router

ROBOT = "guarded"


def openssl(*arguments: str) -> None:
    subprocess.run(["openssl", *arguments], check=True, capture_output=True)


def make_certificate(folder: Path, name: str) -> None:
    """Sign a certificate for a common name, valid on the loopback interface."""
    key, request, extension = (folder / f"{name}.{end}" for end in ("key", "csr", "ext"))
    extension.write_text("subjectAltName=DNS:localhost,IP:127.0.0.1\n")
    openssl(
        *("req", "-newkey", "rsa:2048", "-nodes", "-subj", f"/CN={name}"),
        *("-keyout", str(key), "-out", str(request)),
    )
    openssl(
        *("x509", "-req", "-days", "2", "-in", str(request), "-extfile", str(extension)),
        *("-CA", str(folder / "ca.pem"), "-CAkey", str(folder / "ca.key"), "-CAcreateserial"),
        *("-out", str(folder / f"{name}.pem")),
    )


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certificates")
    openssl(
        *("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=test-ca"),
        *("-keyout", str(folder / "ca.key"), "-out", str(folder / "ca.pem")),
    )
    for name in ("router", "robot", "llm", "grounding", "dialogue", "evaluation", "recorder"):
        make_certificate(folder, name)
    return folder


@pytest.fixture(scope="module")
def address(certificates: Path) -> Iterator[str]:
    """Run a router as deploy/access_control.py configures it."""
    where = f"localhost:{free_port()}"
    path = certificates / "router.json5"
    arguments = ["--robot", ROBOT, "--certificates", str(certificates), "--listen", where]
    load_access_control().main([*arguments, "--output", str(path)])
    with open_router(RouterConfig(zenoh_config=str(path))):
        yield where


class Guests:
    """Connects services, each with its own certificate."""

    def __init__(self, certificates: Path, address: str, stack: ExitStack) -> None:
        self._certificates = certificates
        self._address = address
        self._stack = stack

    def endpoint(self, name: str) -> str:
        """Return the router's endpoint with the certificate of one process."""
        folder = self._certificates
        return (
            f"tls/{self._address}#root_ca_certificate_file={folder}/ca.pem;"
            f"connect_private_key_file={folder}/{name}.key;"
            f"connect_certificate_file={folder}/{name}.pem;enable_mtls=true"
        )

    def __call__(self, service: str, certificate: str = "") -> ZenohBus:
        """Return the bus of a service, with its own certificate or that of another."""
        endpoint = self.endpoint(certificate or service)
        config = ServiceConfig(robot=ROBOT, router=endpoint, connect_timeout=5.0)
        return self._stack.enter_context(connect(config, service, [endpoint]))


@pytest.fixture
def guests(certificates: Path, address: str) -> Iterator[Guests]:
    with ExitStack() as stack:
        yield Guests(certificates, address, stack)


def truth() -> Truth:
    return Truth(
        stamp_ns=0, tick=0, generalized_position=np.zeros(3), world_from_base=np.zeros(7),
        end_effector_positions=np.zeros((4, 3)), contact_forces=np.zeros((4, 3)), fell=False,
    )  # fmt: skip


def log_record(text: str) -> LogRecord:
    return LogRecord(stamp_ns=0, level="info", logger="test", text=text)


def test_truth_reaches_evaluation_and_recorder_and_nobody_else(guests: Guests) -> None:
    robot, evaluation = guests("robot"), guests("evaluation")
    dialogue, recorder = guests("dialogue"), guests("recorder")
    at_evaluation = evaluation.queue(topics.TRUTH)
    at_dialogue = dialogue.queue(topics.TRUTH)
    at_recorder = recorder.raw_queue(f"w2c/{topics.VERSION}/{ROBOT}/**")

    seen: set[str] = set()

    def both_have_it() -> bool:
        robot.publish(topics.TRUTH, truth())
        if at_evaluation.receive(0.05) is not None:
            seen.add("evaluation")
        received = at_recorder.receive(0.05)
        if received is not None and received.key == topics.TRUTH.key(ROBOT):
            seen.add("recorder")
        return seen == {"evaluation", "recorder"}

    wait_until(both_have_it)
    assert at_dialogue.receive(0.3) is None


def test_a_command_of_a_model_service_does_not_pass(guests: Guests) -> None:
    """Sent past the registry's check in the sender, as a hostile process would."""
    recorder, llm, robot = guests("recorder"), guests("llm"), guests("controller", "robot")
    everything = recorder.raw_queue(f"w2c/{topics.VERSION}/{ROBOT}/**")
    command = JointCommand(tick=1, position=np.zeros(3))
    senders: list[str] = []

    def collect() -> bool:
        # A log line after each command: when it is there, so would be the command.
        llm._send(topics.JOINT_COMMAND, topics.JOINT_COMMAND.key(ROBOT), b"forged")
        llm.publish(topics.LOG, log_record("after"))
        robot.publish(topics.JOINT_COMMAND, command)
        received = everything.receive(0.05)
        while received is not None:
            senders.append("forged" if received.payload == b"forged" else received.key)
            received = everything.receive(0.0)
        return {topics.LOG.key(ROBOT, "llm"), topics.JOINT_COMMAND.key(ROBOT)} <= set(senders)

    wait_until(collect)
    assert "forged" not in senders


def test_calls_of_the_registry_work_and_others_find_nobody(guests: Guests) -> None:
    def answer(request: GroundingRequest, _context: object) -> GroundingReply:
        return GroundingReply(
            model=request.phrases[0], width=1, height=1, evidence=[], milliseconds=0.0
        )

    grounding, dialogue, llm = guests("grounding"), guests("dialogue"), guests("llm")
    controller = guests("controller", "robot")
    grounding.serve(topics.GROUND, answer)
    served: list[PlaceGoal] = []

    def place(goal: PlaceGoal, _context: object) -> GoalReply:
        served.append(goal)
        return GoalReply(goal_id=goal.goal_id, start_tick=0)

    controller.serve(topics.PLACE, place)

    request = GroundingRequest(jpeg=b"x", phrases=["book"], want="boxes")
    assert dialogue.call(topics.GROUND, request).message.model == "book"
    goal = PlaceGoal(
        goal_id="g", end_effector="left_hand", task="reach",
        point=np.zeros(3), normal=np.array([0.0, 0.0, 1.0]),
    )  # fmt: skip
    wait_until(lambda: ("controller", "0") in llm.alive())
    with pytest.raises(UnavailableError):
        llm.call(topics.PLACE, goal, timeout_s=2.0)
    assert served == []


def test_a_token_in_anothers_name_is_not_seen(guests: Guests) -> None:
    guests("robot", "llm")
    dialogue = guests("dialogue")
    guests("grounding")

    wait_until(lambda: ("grounding", "0") in dialogue.alive())
    assert ("robot", "0") not in dialogue.alive()


def test_without_a_certificate_nobody_gets_in(certificates: Path, address: str) -> None:
    endpoint = f"tls/{address}#root_ca_certificate_file={certificates}/ca.pem"
    config = ServiceConfig(robot=ROBOT, router=endpoint, connect_timeout=1.0)

    with pytest.raises(ConnectionFailedError):
        connect(config, "llm", [endpoint])
    with pytest.raises(ConnectionFailedError):
        connect(config, "llm", [f"tcp/{address}"])


def test_local_trust_lets_plain_tcp_do_everything(certificates: Path, tmp_path: Path) -> None:
    module = load_access_control()
    settings = module.router_configuration(
        ROBOT, str(certificates), address=f"localhost:{free_port()}", trust_local=True
    )
    plain = f"tcp/127.0.0.1:{free_port()}"
    settings["listen"]["endpoints"][0] = plain
    path = tmp_path / "router.json5"
    path.write_text(json.dumps(settings))
    config = ServiceConfig(robot=ROBOT, router=plain, connect_timeout=5.0)
    with (
        open_router(RouterConfig(zenoh_config=str(path))),
        connect(config, "robot", [plain]) as robot,
        connect(config, "evaluation", [plain]) as evaluation,
    ):
        queue = evaluation.queue(topics.TRUTH)

        def arrives() -> bool:
            robot.publish(topics.TRUTH, truth())
            return queue.receive(0.05) is not None

        wait_until(arrives)
