"""`w2c ground "book" "cup"`: what the model sees, drawn over a picture; and its sub-verbs."""

import sys
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import tyro

from w2c import topics
from w2c.config import parse
from w2c.errors import ConfigError
from w2c.extras import needs_extra
from w2c.messages import CaptureRequest, GroundingReply, GroundingRequest, PhraseEvidence
from w2c.system import Connection, service_config
from w2c_grounding.known import KNOWN
from w2c_grounding.model_config import Dtype, ModelConfig
from w2c_grounding.model_list import describe_models, is_in_cache
from w2c_grounding.pointer.options import PointerOptions
from w2c_grounding.use_command import use


class GroundConfig(Connection, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Find phrases in a picture and draw what was found.

    With --image no running system is needed: the model is loaded here. Without it the robot's
    camera takes a picture and the running grounding process answers.

    'w2c ground models' lists the public models that --model knows by name; 'w2c ground use NAME'
    lets the running process answer with another one.
    """

    phrases: tyro.conf.Positional[
        Annotated[tuple[str, ...], msgspec.Meta(min_length=1, max_length=32)]
    ]
    """What to look for, as in: "book" "the red cup"."""
    image: str = ""
    """A JPEG or PNG file; empty = the live camera."""
    out: str = "ground.png"
    """Where the drawn picture is written."""
    model: str = ""
    """With --image: a name of 'w2c ground models', a checkpoint directory or a hub id; empty = the
    embedded model."""
    family: str = ""
    """With --image: kind of model; empty = what the checkpoint says of itself."""
    revision: str = ""
    """With --image: commit or tag of a hub id; empty = the newest that is present."""
    allow_download: bool = False
    """With --image: fetch a hub id that is not on this machine."""
    dtype: Dtype = "float32"
    """With --image: of the weights in memory."""
    device: str = "cpu"
    """With --image: cpu, cuda ..."""
    input_size: Annotated[int, msgspec.Meta(ge=16, le=4096)] | None = None
    """With --image: what the picture is scaled to for the model [px]."""
    threads: Annotated[int, msgspec.Meta(ge=1, le=256)] = 2
    """With --image: CPU threads."""
    threshold: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] | None = None
    """With --image: a phrase whose peak is below it is not in the picture."""
    template: str | None = None
    """With --image: text around a phrase, as in 'a photo of a {}'."""
    pointer: PointerOptions = PointerOptions()
    """With --image: of the families pointer and pointer-local."""
    point_rule: Literal["interior", "peak"] = "interior"
    """With --image: interior (hot and far from edges) or peak (the arg-max of the paper)."""

    def model_config(self) -> ModelConfig:
        """Return the part that chooses the model."""
        return ModelConfig(**{name: getattr(self, name) for name in ModelConfig.__struct_fields__})


def ground(arguments: list[str] | None = None) -> int:
    """Run the verb. Exit status: 0 done, also where nothing was found; 1 failed; 2 usage."""
    argv = sys.argv[1:] if arguments is None else arguments
    if argv == ["models"]:
        with needs_extra("grounding"):
            print(describe_models(KNOWN.values(), is_in_cache))
        return 0
    if argv[:1] == ["use"]:
        return use(argv[1:])
    config = parse(GroundConfig, argv, program="w2c ground")
    with needs_extra("grounding"):
        from w2c_grounding.drawing import draw_reply
        from w2c_grounding.picture import decode, encode_png
    picture, reply = _ask_running_system(config) if not config.image else _ask_in_process(config)
    _write(Path(config.out), encode_png(draw_reply(decode(picture), reply)))
    print(f"{reply.model}, {reply.width} x {reply.height} px, {reply.milliseconds:.0f} ms")
    for evidence in reply.evidence:
        print(describe(evidence))
    print(f"picture: {config.out}")
    return 0


def describe(evidence: PhraseEvidence) -> str:
    """Return what was found for a phrase in one line for people."""
    unknown = ", ".join(evidence.unknown_words)
    note = f"; the model has never seen: {unknown}" if unknown else ""
    if evidence.point is None:
        return f"  {evidence.phrase}: not found, score {evidence.score:.2f}{note}"
    u, v = evidence.point
    best = evidence.boxes[0]
    box = f"[{best.left:.0f} {best.top:.0f} {best.right:.0f} {best.bottom:.0f}]"
    others = f" and {len(evidence.boxes) - 1} more" if len(evidence.boxes) > 1 else ""
    return (
        f"  {evidence.phrase}: point ({u:.0f}, {v:.0f}), box {box}{others}, "
        f"score {evidence.score:.2f}{note}"
    )


def _ask_in_process(config: GroundConfig) -> tuple[bytes, GroundingReply]:
    """Load the model here and answer for the file of the flags."""
    from w2c_grounding.answer import Grounder
    from w2c_grounding.loaded import first_answer
    from w2c_grounding.registry import load

    try:
        picture = Path(config.image).read_bytes()
    except OSError as error:
        raise ConfigError(
            f"picture {config.image} cannot be read: {error}; check --image"
        ) from error
    request = _request(picture, config)
    family, card = load(config.model_config())
    return picture, first_answer(card.name, Grounder(family, card, config.point_rule), request)


def _ask_running_system(config: GroundConfig) -> tuple[bytes, GroundingReply]:
    """Take a picture with the robot's camera and let the running process answer."""
    from w2c.bus.zenoh_bus import connect

    service = service_config(config)
    with connect(service, "operator", [service.router]) as bus:
        frame = bus.call(topics.CAPTURE, CaptureRequest())
        request = _request(frame.message.jpeg, config)
        reply = bus.call(topics.GROUND, request, inputs=[frame.as_input()])
        return frame.message.jpeg, reply.message


def _request(picture: bytes, config: GroundConfig) -> GroundingRequest:
    """Return the request, bounded as on the bus. Raises ConfigError."""
    values = {"jpeg": picture, "phrases": list(config.phrases), "want": "heatmaps"}
    try:
        return msgspec.convert(values, GroundingRequest)
    except msgspec.ValidationError as error:
        raise ConfigError(f"this cannot be asked: {error}") from error


def _write(path: Path, data: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error}; choose another --out") from error
