"""Which model the family `pointer` asks: one at a server, or one in this process."""

from w2c.chat_server import read_key
from w2c.errors import ConfigError
from w2c_grounding.model_config import ModelConfig
from w2c_grounding.pointer.pointer import Pointer
from w2c_grounding.pointer.server import ServerTalker


def load_server(config: ModelConfig, model: str, template: str) -> Pointer:
    """Return a pointer whose model is a name at a server; nothing is sent yet.

    Raises:
        ConfigError: there is no address, no name, or no readable key.
    """
    options = config.pointer
    if not options.url or not model:
        raise ConfigError(
            "family pointer asks a server: it needs --pointer.url, as in http://127.0.0.1:8080/v1, "
            "and --model, the name of the model there. A model in this process is family "
            "pointer-local"
        )
    return Pointer(ServerTalker(options, model, read_key(options.key_file)), options, template)


def load_local(config: ModelConfig, source: str, template: str) -> Pointer:
    """Return a pointer whose model runs in this process. Raises ConfigError or ModelError."""
    from w2c_grounding.pointer.local import LocalTalker

    options = config.pointer
    return Pointer(LocalTalker.load(config, source, options), options, template)
