"""The scenarios by name."""

from w2c.errors import ConfigError
from w2c_evaluation.scenarios import scenario_a
from w2c_evaluation.scenarios.scenario import Scenario

SCENARIOS: dict[str, Scenario] = {one.SCENARIO.name: one.SCENARIO for one in (scenario_a,)}


def find_scenario(name: str) -> Scenario:
    """Return a scenario. Raises ConfigError."""
    if name not in SCENARIOS:
        raise ConfigError(f"no scenario '{name}'; choose of: {', '.join(SCENARIOS)}")
    return SCENARIOS[name]
