"""A turn of the conversation as the terminal shows it."""

from w2c.messages import Target, Turn


def turn_lines(turn: Turn) -> list[str]:
    """Return what was understood, the target, and what may be answered to a question."""
    lines = [f"[{turn.module}] {turn.reply}"]
    if turn.target is not None:
        lines += _target_lines(turn.target)
    if turn.options:
        lines += [f"  {number}. {option}" for number, option in enumerate(turn.options, 1)]
        lines.append(f'answer in words: w2c say "{turn.options[0]}"')
    return lines


def _target_lines(target: Target) -> list[str]:
    place = ""
    if target.point is not None:
        x, y, z = target.point
        place = f", in the world ({x:.3f}, {y:.3f}, {z:.3f}) m"
    lines = [f"target {target.target_id} at pixel ({target.u:.0f}, {target.v:.0f}){place}"]
    return [*lines, f"warning: {target.warning}"] if target.warning else lines
