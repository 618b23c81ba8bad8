"""Tables of docs/reference/scenes.md, made from the catalogue."""

from w2c_sim_robot.scenes.held_out import HELD_OUT_KINDS, held_out_material
from w2c_sim_robot.scenes.objects.catalogue import KINDS, make_object
from w2c_sim_robot.scenes.wording import parts_of

SUPPORT_WORDS = {
    "carries": "load-bearing",
    "slides": "movable",
    "fragile": "fragile",
    "forbidden": "no-go",
}
"""What a person calls the classes of `SceneObject.support`"""


def kinds_table() -> str:
    """Return one row a kind, by group; `*` marks what is kept for judging."""
    lines = [
        "| kind | names | materials | colours | parts | a hand may lean on it | usual size [cm] |"
        " mass [kg] |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for kind, row in sorted(KINDS.items(), key=lambda entry: (entry[1].group, entry[0])):
        item = make_object(kind, row.colours[0], (0.0, 0.0, 0.0))
        materials = [
            f"{material}*" if held_out_material(kind, material) else material
            for material in row.materials
            if material
        ]
        size = " x ".join(f"{100 * extent:.3g}" for extent in row.size)
        star = "*" if kind in HELD_OUT_KINDS else ""
        lines.append(
            f"| `{kind}`{star} | {', '.join(row.names)} | {', '.join(materials)} "
            f"| {len(row.colours)} | {', '.join(parts_of(item))} "
            f"| {SUPPORT_WORDS[row.support]} | {size} | {row.mass:g} |"
        )
    return "\n".join(lines)
