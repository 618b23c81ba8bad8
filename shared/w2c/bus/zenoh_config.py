"""How every Zenoh session is configured.

Scouting, gossip and shared memory are off, the lease is the same everywhere: two sides with unequal
leases that dial each other can lose each other for good.
"""

import json

import zenoh

LEASE_MS = 1000
RETRY = {"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2}


def base_config(mode: str) -> zenoh.Config:
    """Return the settings every session shares."""
    config = zenoh.Config()
    for path, value in {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/tx/keep_alive": 4,
    }.items():
        config.insert_json5(path, json.dumps(value))
    return config


def client_config(endpoints: list[str], timeout_s: float) -> zenoh.Config:
    """Return the configuration of a client that tries for `timeout_s` [s]."""
    config = base_config("client")
    config.insert_json5("connect/endpoints", json.dumps(endpoints))
    config.insert_json5("connect/timeout_ms", str(int(timeout_s * 1e3)))
    config.insert_json5("connect/exit_on_failure", "true")
    config.insert_json5("connect/retry", json.dumps(RETRY))
    return config


def hub_config(listen: str, router: str) -> zenoh.Config:
    """Return the configuration of the robot driver: it listens, and dials the router."""
    config = base_config("peer")
    config.insert_json5("listen/endpoints", json.dumps([listen]))
    config.insert_json5("connect/endpoints", json.dumps([router]))
    # A robot must come up without a router, and find it whenever it appears.
    config.insert_json5("connect/timeout_ms", "-1")
    config.insert_json5("connect/exit_on_failure", "false")
    config.insert_json5("connect/retry", json.dumps(RETRY))
    return config
