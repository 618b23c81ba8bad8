"""Which processes run where."""

from pathlib import Path

import pytest

from w2c import topics
from w2c.errors import ConfigError
from w2c_launcher.profiles import Options, processes
from w2c_launcher.up import UpConfig, options_of


def options(**changes: object) -> Options:
    values: dict[str, object] = {
        "robot": "talos",
        "router": "tcp/127.0.0.1:1",
        "robot_endpoint": "tcp/127.0.0.1:2",
        "run_directory": "/tmp/run",
        "console_port": 8080,
    }
    return Options(**{**values, **changes})  # type: ignore[arg-type]


def test_the_simulation_runs_every_service() -> None:
    names = {spec.name for spec in processes("simulation", options())}
    assert names == {"router", *topics.SERVICES}


def test_robot_and_controller_are_never_children_of_the_robot_profile() -> None:
    names = {spec.name for spec in processes("robot", options())}
    assert not names & {"robot", "controller", "camera"}


def test_the_router_starts_first_and_stops_last_and_the_recorder_just_before() -> None:
    specs = processes("simulation", options())
    assert [s.name for s in specs if s.stage == 0] == ["router"]
    by_stop = sorted(specs, key=lambda spec: spec.stop_stage)
    assert [spec.name for spec in by_stop[-2:]] == ["recorder", "router"]


def test_loop_robot_and_recorder_go_before_what_answers_people() -> None:
    niceness = {spec.name: spec.niceness for spec in processes("simulation", options())}
    first = {"router", "robot", "controller", "recorder"}
    assert {niceness[name] for name in first} == {0}
    assert min(niceness[name] for name in niceness.keys() - first) > 0


def test_lock_step_and_scene_reach_the_simulator() -> None:
    specs = {s.name: s for s in processes("simulation", options(lock_step=True, scene="s.json"))}
    assert "--lock-step" in specs["robot"].flags
    assert "s.json" in specs["robot"].flags
    assert "s.json" in specs["camera"].flags


def test_an_unknown_profile_names_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="simulation, robot, gpu-host"):
        processes("mars", options())


def test_flags_for_one_service_reach_it_alone() -> None:
    config = UpConfig(with_flags=("llm:--threads 4", "llm:--seed 1"))
    specs = {s.name: s for s in processes("simulation", options_of(config, Path("/tmp/run")))}
    assert specs["llm"].flags[-4:] == ("--threads", "4", "--seed", "1")
    assert "--threads" not in specs["grounding"].flags


def test_flags_are_quoted_as_in_a_shell() -> None:
    config = UpConfig(with_flags=("llm:--model '/my models/a.gguf'",))
    specs = {s.name: s for s in processes("simulation", options_of(config, Path("/tmp/run")))}
    assert specs["llm"].flags[-2:] == ("--model", "/my models/a.gguf")

    with pytest.raises(ConfigError, match="a quote that is not closed"):
        options_of(UpConfig(with_flags=("llm:--model 'my",)), Path("/tmp/run"))


def test_flags_without_a_service_are_refused() -> None:
    with pytest.raises(ConfigError, match="SERVICE:FLAGS"):
        options_of(UpConfig(with_flags=("--threads 4",)), Path("/tmp/run"))


def test_private_systems_get_ports_of_their_own() -> None:
    first = options_of(UpConfig(private=True), Path("/tmp/run"))
    assert first.router not in {UpConfig().router, first.robot_endpoint}


def test_a_service_that_something_else_stands_in_for_is_not_started() -> None:
    names = {spec.name for spec in processes("simulation", options(without=("grounding",)))}
    assert "llm" in names
    assert "grounding" not in names


def test_a_service_that_is_not_started_anyway_cannot_be_left_out() -> None:
    with pytest.raises(ConfigError, match=r"--without grownding: .*router"):
        processes("robot", options(without=("grownding",)))
