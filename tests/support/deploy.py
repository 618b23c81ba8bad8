"""The deployment files, for tests."""

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]
_VARIABLE = re.compile(r"\$\{(\w+)(?:(:[-?])([^}]*))?\}|\$(\$)")


def load_access_control() -> ModuleType:
    """Import deploy/access_control.py, which is a script and in no package."""
    path = ROOT / "deploy" / "access_control.py"
    spec = importlib.util.spec_from_file_location("access_control", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up by name
    spec.loader.exec_module(module)
    return module


def interpolate(text: str, variables: dict[str, str]) -> str:
    """Return the text with `${NAME:-default}` and `${NAME:?message}` filled in, as compose does."""

    def value_of(match: re.Match[str]) -> str:
        name, operator, argument, escaped = match.groups()
        if escaped:
            return "$"
        if variables.get(name):
            return variables[name]
        if operator == ":-":
            return str(argument)
        raise KeyError(f"{name}: {argument or 'no default'}")

    return _VARIABLE.sub(value_of, text)


class _UniqueKeys(yaml.SafeLoader):
    """Refuses what compose refuses: a key that stands twice in a mapping."""

    def compose_mapping_node(self, anchor: dict[Any, yaml.Node]) -> yaml.MappingNode:
        """Look at the keys before those of `<<` are among them."""
        node = super().compose_mapping_node(anchor)
        seen: set[str] = set()
        for key, _ in node.value:
            if key.value in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"key {key.value!r} stands twice", key.start_mark
                )
            seen.add(key.value)
        return node


def load_yaml(text: str) -> dict[str, Any]:
    """Return a YAML document. Raises yaml.YAMLError, also for a key that stands twice."""
    document: dict[str, Any] = yaml.load(text, _UniqueKeys)  # noqa: S506  # a SafeLoader
    return document


def read_compose(path: Path, variables: dict[str, str] | None = None) -> dict[str, Any]:
    """Return a compose file with its variables filled in, extensions (x-...) left out."""
    document = load_yaml(interpolate(path.read_text(), variables or {}))
    return {name: value for name, value in document.items() if not name.startswith("x-")}


def dot_env() -> dict[str, str]:
    """Return the settings that compose reads from the repository's .env."""
    lines = (ROOT / ".env").read_text().splitlines()
    settings = {}
    for line in lines:
        if line and not line.startswith("#"):
            name, _, value = line.partition("=")
            settings[name] = value
    return settings
