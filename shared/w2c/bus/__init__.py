"""Publish, subscribe, serve and call: one Protocol, on Zenoh and within one process."""

from w2c.bus.codec import (
    Envelope,
    Input,
    decode_envelope,
    decode_message,
    encode_envelope,
    encode_message,
)
from w2c.bus.inprocess import InProcessBus, InProcessHub
from w2c.bus.interface import (
    Bus,
    CallContext,
    Latest,
    Queue,
    RawQueue,
    RawReceived,
    Received,
    StandIn,
)

__all__ = [
    "Bus",
    "CallContext",
    "Envelope",
    "InProcessBus",
    "InProcessHub",
    "Input",
    "Latest",
    "Queue",
    "RawQueue",
    "RawReceived",
    "Received",
    "StandIn",
    "decode_envelope",
    "decode_message",
    "encode_envelope",
    "encode_message",
]
