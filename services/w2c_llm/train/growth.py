"""A deeper network that begins with what a smaller one knows.

New layers stand between the old ones. What they add to the stream is zero at first (output
projections of attention and feed-forward block), so the deeper network begins with the very answers
of the smaller one (Chen et al., "Net2Net", ICLR 2016); the rest of a new layer is a copy of the
layer before it, and learns faster than random weights.
"""

from dataclasses import replace

import torch
from transformers import Qwen2ForCausalLM

from w2c.errors import ConfigError
from w2c_llm.train.network import NetworkSize, make_network
from w2c_llm.train.origin import Origin

_LAYER = "model.layers."
_ADDS_TO_STREAM = ("self_attn.o_proj.weight", "mlp.down_proj.weight")


def deepened(origin: Origin, layers: int) -> Origin:
    """Return a network of `layers` layers, at least those of the origin, that answers as it does.

    Raises:
        ConfigError: it has more layers than that; none can be left out.
    """
    size = origin.size
    if layers < size.layers:
        raise ConfigError(
            f"--layers is {layers}, the network to begin with has {size.layers}: none of them can "
            "be left out; leave --layers out, or ask for more"
        )
    deeper = replace(size, layers=layers)
    network = make_network(deeper, origin.tokenizer.get_vocab_size(), 0)
    network.load_state_dict(_spread(origin.network, size, layers))
    return Origin(network, origin.tokenizer, deeper)


def _spread(network: Qwen2ForCausalLM, size: NetworkSize, layers: int) -> dict[str, torch.Tensor]:
    """Return the weights of the deeper network: old layers evenly apart, copies between them."""
    known = network.state_dict()
    state = {name: value for name, value in known.items() if not name.startswith(_LAYER)}
    sources = [index * size.layers // layers for index in range(layers)]
    for index, source in enumerate(sources):
        is_new = index > 0 and sources[index - 1] == source
        prefix = f"{_LAYER}{source}."
        for name in [name for name in known if name.startswith(prefix)]:
            part = name.removeprefix(prefix)
            empty = is_new and part in _ADDS_TO_STREAM
            value = torch.zeros_like(known[name]) if empty else known[name].clone()
            state[f"{_LAYER}{index}.{part}"] = value
    return state
