"""Make the configuration of a router that other machines reach: mutual TLS, and who may send what.

The access list is derived from the registry (w2c.topics): a process may write the keys that are its
own, read what names it as a reader, call what names it as a caller, and serve its own methods.
Everything else is denied. So no model service can send a joint command, and `truth` reaches nobody
but those whom the registry names. A process is known by the common name of its certificate.

Robot, camera and controller share the robot host's link to the router: they are one subject,
"robot", and the robot's certificate speaks for the three.

    python deploy/access_control.py --robot talos --certificates /certs --output router.json5
"""

import argparse
import json
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from w2c import topics

BASE = Path(__file__).parent / "zenoh-router.json5"
PORT = 7449
"""Of the TLS endpoint; the plain one, for this machine's containers, stays at 7447."""

BEHIND_THE_ROBOT = ("robot", "camera", "controller")
OTHERS = ("launcher", "operator", "evaluation")
"""Processes of the registry that are no services: `w2c up`, the verbs, the benchmarks."""

Json = dict[str, Any]


@dataclass
class Permissions:
    """Key expressions that one subject may use."""

    write: set[str] = field(default_factory=set)
    read: set[str] = field(default_factory=set)
    call: set[str] = field(default_factory=set)
    serve: set[str] = field(default_factory=set)
    live: set[str] = field(default_factory=set)


def subjects() -> dict[str, tuple[str, ...]]:
    """Return common name -> the processes it speaks for."""
    others = [name for name in (*topics.SERVICES, *OTHERS) if name not in BEHIND_THE_ROBOT]
    return {"robot": BEHIND_THE_ROBOT, **{name: (name,) for name in others}}


def all_keys(robot: str) -> str:
    """Return the key expression of everything about one robot."""
    return f"w2c/{topics.VERSION}/{robot}/**"


def permissions_of(processes: Iterable[str], robot: str) -> Permissions:
    """Return what the registry lets some processes do together."""
    granted = Permissions()
    for process in processes:
        for topic in topics.TOPICS:
            if topic.service in ("*", process):
                granted.write.add(topic.key(robot, process))
            if process in topic.readers or "*" in topic.readers:
                granted.read.add(topic.key(robot))
        for method in topics.METHODS:
            if process in method.callers or "*" in method.callers:
                granted.call.add(method.key(robot))
            if method.service == process:
                granted.serve.add(method.key(robot))
        granted.live.add(topics.liveliness_key(robot, process))
        if process == "recorder":
            granted.read.add(all_keys(robot))
    return granted


def access_control(robot: str, *, trust_local: bool) -> Json:
    """Return Zenoh's `access_control` section, written from the router's side of each link.

    Args:
        robot: id of the robot.
        trust_local: whoever comes over plain TCP may do everything. For a router whose plain
            endpoint is inside a network of this machine's own containers.
    """
    rules: list[Json] = []
    policies: list[Json] = []
    for name, processes in subjects().items():
        granted = permissions_of(processes, robot)
        own = _rules_of(name, granted, robot)
        rules += own
        policies.append({"rules": [rule["id"] for rule in own], "subjects": [name]})
    listed: list[Json] = [{"id": name, "cert_common_names": [name]} for name in subjects()]
    if trust_local:
        rules.append(_rule("local", _ALL_MESSAGES, ("ingress", "egress"), {"**"}))
        listed.append({"id": "local", "link_protocols": ["tcp"]})
        policies.append({"rules": ["local"], "subjects": ["local"]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": listed,
        "policies": policies,
    }


_ALL_MESSAGES = (
    *("put", "delete", "query", "reply", "declare_subscriber", "declare_queryable"),
    *("liveliness_token", "liveliness_query", "declare_liveliness_subscriber"),
)


def _rules_of(name: str, granted: Permissions, robot: str) -> list[Json]:
    """Return the rules of one subject; ingress is what comes from it, egress what goes to it."""
    everyone = {topics.liveliness_key(robot)}
    candidates = [
        _rule(f"{name} writes", ("put", "delete"), ("ingress",), granted.write),
        _rule(f"{name} subscribes", ("declare_subscriber",), ("ingress",), granted.read),
        _rule(f"{name} receives", ("put", "delete"), ("egress",), granted.read),
        # A sender must hear of its readers, or it sends nothing; the recorder's interest is in all.
        _rule(f"{name} is read", ("declare_subscriber",), ("egress",), {all_keys(robot)}),
        _rule(f"{name} calls", ("query",), ("ingress",), granted.call),
        _rule(f"{name} is answered", ("reply", "declare_queryable"), ("egress",), granted.call),
        _rule(f"{name} serves", ("declare_queryable", "reply"), ("ingress",), granted.serve),
        _rule(f"{name} is called", ("query",), ("egress",), granted.serve),
        _rule(f"{name} lives", ("liveliness_token",), ("ingress",), granted.live),
        _rule(f"{name} sees who lives", ("liveliness_token",), ("egress",), everyone),
        _rule(
            f"{name} looks who lives",
            ("declare_liveliness_subscriber", "liveliness_query"),
            ("ingress", "egress"),
            everyone,
        ),
    ]
    return [rule for rule in candidates if rule["key_exprs"]]


def _rule(name: str, messages: Iterable[str], flows: Iterable[str], keys: Iterable[str]) -> Json:
    return {
        "id": name,
        "permission": "allow",
        "messages": list(messages),
        "flows": list(flows),
        "key_exprs": sorted(keys),
    }


def tls_endpoint(address: str, certificates: str, name: str = "router") -> str:
    """Return an endpoint that shows NAME.pem and wants a certificate of ca.pem from its peer."""
    folder = certificates.rstrip("/")
    settings = {
        "listen_private_key_file": f"{folder}/{name}.key",
        "listen_certificate_file": f"{folder}/{name}.pem",
        "root_ca_certificate_file": f"{folder}/ca.pem",
        "enable_mtls": "true",
    }
    return f"tls/{address}#" + ";".join(f"{key}={value}" for key, value in settings.items())


def read_base(path: Path = BASE) -> Json:
    """Return the settings that every router shares: JSON with whole-line comments."""
    lines = path.read_text().splitlines()
    settings: Json = json.loads("\n".join(line for line in lines if not line.startswith("//")))
    return settings


def router_configuration(
    robot: str, certificates: str, *, address: str = f"0.0.0.0:{PORT}", trust_local: bool = False
) -> Json:
    """Return a whole router configuration.

    Without `trust_local` the router listens for TLS only.
    """
    settings = read_base()
    secure = tls_endpoint(address, certificates)
    local = settings["listen"]["endpoints"] if trust_local else []
    settings["listen"] = {"endpoints": [*local, secure]}
    settings["access_control"] = access_control(robot, trust_local=trust_local)
    return settings


def main(arguments: list[str] | None = None) -> int:
    """Write the configuration. Returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="access_control.py",
        description="Make the configuration of a router that other machines reach.",
    )
    parser.add_argument("--robot", required=True, help="id of the robot")
    parser.add_argument(
        "--certificates",
        required=True,
        metavar="DIR",
        help="folder, as the router sees it, with ca.pem, router.pem and router.key",
    )
    parser.add_argument("--listen", default=f"0.0.0.0:{PORT}", metavar="ADDRESS:PORT")
    parser.add_argument(
        "--trust-local",
        action="store_true",
        help="also listen for plain TCP, as zenoh-router.json5 says, and let it do everything",
    )
    parser.add_argument("--output", type=Path, help="file to write; without it, the terminal")
    options = parser.parse_args(arguments)
    settings = router_configuration(
        options.robot,
        options.certificates,
        address=options.listen,
        trust_local=options.trust_local,
    )
    text = "// Made by deploy/access_control.py from the registry; do not edit.\n"
    text += json.dumps(settings, indent=2) + "\n"
    if options.output is None:
        sys.stdout.write(text)
    else:
        options.output.write_text(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
