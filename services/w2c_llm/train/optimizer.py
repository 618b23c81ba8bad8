"""Muon for the matrices of the layers, AdamW for embeddings, norms and biases.

The update of a matrix is its momentum with all singular values brought near 1 (Jordan et al. 2024,
"Muon: an optimizer for hidden layers in neural networks"), by five Newton-Schulz iterations. They
run in bfloat16 only where the processor has it: PyTorch's own optimizer of this name always does,
which other processors emulate slowly.
"""

from collections import defaultdict
from collections.abc import Callable
from typing import Any

import torch
from transformers import Qwen2ForCausalLM

_COEFFICIENTS = (3.4445, -4.7750, 2.0315)
_ITERATIONS = 5
_LIKE_ADAM = 0.2
"""Root mean square of an update over the rate, that of AdamW: one rate serves both"""


class Muon(torch.optim.Optimizer):
    """Steps of orthogonalised momentum; takes matrices only."""

    def __init__(
        self,
        matrices: list[torch.nn.Parameter],
        lr: float,
        momentum: float = 0.95,
        weight_decay: float = 0.0,
        *,
        bf16: bool = False,
    ) -> None:
        self._products = torch.bfloat16 if bf16 else torch.float32
        super().__init__(matrices, {"lr": lr, "momentum": momentum, "weight_decay": weight_decay})

    @torch.no_grad()
    def step(self, closure: Callable[[], float] | None = None) -> float | None:  # type: ignore[override]  # one signature for both
        """Change the weights by their gradients."""
        loss = closure() if closure is not None else None
        for group in self.param_groups:
            # Matrices of one shape are iterated together: fewer, larger products.
            alike: dict[torch.Size, list[tuple[torch.Tensor, torch.Tensor]]] = defaultdict(list)
            for weight in group["params"]:
                if weight.grad is None:
                    continue
                momentum = self.state[weight].setdefault("momentum", torch.zeros_like(weight))
                momentum.lerp_(weight.grad, 1.0 - group["momentum"])
                update = weight.grad.lerp(momentum, group["momentum"])
                alike[weight.shape].append((weight, update))
            for shape, pairs in alike.items():
                stack = torch.stack([update for _, update in pairs])
                updates = orthogonalised(stack.to(self._products)).to(stack.dtype)
                rate = group["lr"] * _LIKE_ADAM * max(shape) ** 0.5
                for (weight, _), update in zip(pairs, updates, strict=True):
                    weight.mul_(1.0 - group["lr"] * group["weight_decay"])
                    weight.add_(update, alpha=-rate)
        return loss


def orthogonalised(matrices: torch.Tensor) -> torch.Tensor:
    """Return (n, rows, columns) matrices with singular values of about 1 (0.7 to 1.2)."""
    a, b, c = _COEFFICIENTS
    tall = matrices.shape[1] > matrices.shape[2]
    x = matrices.mT if tall else matrices
    x = x / (torch.linalg.matrix_norm(x, keepdim=True) + 1e-7)
    for _ in range(_ITERATIONS):
        square = torch.bmm(x, x.mT)
        x = torch.baddbmm(x, torch.baddbmm(square, square, square, beta=b, alpha=c), x, beta=a)
    return x.mT if tall else x


class Optimizer:
    """All weights of a network, one learning rate."""

    def __init__(
        self, network: Qwen2ForCausalLM, weight_decay: float, *, bf16: bool = False
    ) -> None:
        named = dict(network.named_parameters())
        layers = [w for name, w in named.items() if w.ndim == 2 and ".layers." in name]
        tables = [w for name, w in named.items() if w.ndim == 2 and ".layers." not in name]
        vectors = [weight for weight in named.values() if weight.ndim < 2]
        self._parts: tuple[torch.optim.Optimizer, ...] = (
            Muon(layers, lr=0.0, weight_decay=weight_decay, bf16=bf16),
            torch.optim.AdamW(
                [
                    {"params": tables, "weight_decay": weight_decay},
                    {"params": vectors, "weight_decay": 0.0},
                ],
                lr=0.0,
                betas=(0.9, 0.98),
                fused=True,
            ),
        )

    def step(self, rate: float) -> None:
        """Change the weights by their gradients."""
        for part in self._parts:
            for group in part.param_groups:
                group["lr"] = rate
            part.step()

    def clear(self) -> None:
        """Forget the gradients."""
        for part in self._parts:
            part.zero_grad(set_to_none=True)

    def state_dict(self) -> list[dict[str, Any]]:
        """Return what a checkpoint keeps."""
        return [part.state_dict() for part in self._parts]

    def load_state_dict(self, states: list[dict[str, Any]]) -> None:
        """Take over the state of a checkpoint."""
        for part, state in zip(self._parts, states, strict=True):
            part.load_state_dict(state)
