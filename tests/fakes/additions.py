"""What the tests of all trainings that add a network to a checkpoint do alike."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import torch

from w2c.clock import StepClock
from w2c_grounding.train.addition.run import Addition, Material, Task, add


def without(file: str, checkpoint: Path, directory: Path) -> Path:
    """Copy a checkpoint directory, all but one file of it; return the copy."""
    for one in checkpoint.iterdir():
        if one.name != file:
            (directory / one.name).write_bytes(one.read_bytes())
    return directory


def trained_in_parts(addition: Callable[[Material], Addition], task: Task, out: Path) -> Task:
    """Train into a directory, stopped after a step and gone on with; return the second part."""
    asked = iter([False, True])
    first = replace(task, out=out)
    assert add(addition, first, StepClock(), lambda _: None, lambda: next(asked)) is None
    assert not (out / "checkpoint").exists()
    second = replace(first, resume=True)
    assert add(addition, second, StepClock(), lambda _: None) is not None
    return second


def have_the_same_weights(read: Callable[[Path], torch.nn.Module], *directories: Path) -> bool:
    """Tell whether the networks in the checkpoints of two trainings are equal to the last bit."""
    some, others = (read(one / "checkpoint").state_dict() for one in directories)
    return all(torch.equal(some[name], others[name]) for name in some)


def changed_by_a_step(
    addition: Callable[[Material], Addition],
    task: Task,
    out: Path,
    read: Callable[[Path], torch.nn.Module],
    weight: str,
) -> float:
    """Go on from what a training made for one step; return by how much a weight changed."""
    further = replace(task, checkpoint=task.out / "checkpoint", out=out, steps=1)
    assert add(addition, further, StepClock(), lambda _: None) is not None
    before, after = (read(one / "checkpoint").state_dict()[weight] for one in (task.out, out))
    return float((before - after).abs().max())
