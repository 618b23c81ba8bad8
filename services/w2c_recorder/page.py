"""The story of a recording as one page of HTML that needs nothing else."""

import base64
from collections.abc import Mapping, Sequence
from html import escape

from w2c import messages as m
from w2c_recorder.drawing import heat_png
from w2c_recorder.overlay import Overlay
from w2c_recorder.timeline import Entry

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 70rem; padding: 0 1rem;
  color: #1b1f24; background: #fff; }
table { border-collapse: collapse; width: 100%; }
td { padding: .15rem .6rem; vertical-align: top; }
td:nth-child(1) { font-variant-numeric: tabular-nums; text-align: right; color: #667; }
td:nth-child(2) { white-space: nowrap; color: #445; }
tr.words td { background: #eaf2ff; font-size: 1.1em; }
tr.answer td { background: #f4f8ff; }
tr.goal td, tr.phase td { background: #eefaf0; }
tr.advice td { background: #fff8e5; }
tr.warning td { background: #fdecea; }
tr.mark td { background: #f3ecff; }
tr.call td, tr.process td { color: #778; font-size: .9em; }
body:has(#calls:not(:checked)) tr.call { display: none; }
body:has(#processes:not(:checked)) tr.process { display: none; }
figure { margin: .5rem 0; }
svg { width: 100%; max-width: 50rem; height: auto; display: block; }
figcaption { color: #667; font-size: .9em; }
"""
_NO_CODE = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"

Picture = tuple[m.CameraFrame, Overlay]


def make_page(
    title: str,
    facts: Mapping[str, str],
    entries: Sequence[Entry],
    pictures: Mapping[int, Picture],
) -> str:
    """Return the page.

    Args:
        title: what the page is of.
        facts: shown above the story.
        entries: the story.
        pictures: index of an entry -> its picture. The same picture may belong to several.
    """
    rows = [_row(entry, pictures.get(index)) for index, entry in enumerate(entries)]
    listed = "".join(
        f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in facts.items()
    )
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        # Much of the text comes from models and users: nothing on this page may run.
        f'<meta http-equiv="Content-Security-Policy" content="{_NO_CODE}">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body>"
        f"<h1>{escape(title)}</h1><details><summary>Recording</summary><dl>{listed}</dl></details>"
        '<p><label><input type="checkbox" id="calls" checked> calls</label> '
        '<label><input type="checkbox" id="processes"> processes</label></p>'
        f"<table>{''.join(rows)}</table></body></html>\n"
    )


def _row(entry: Entry, picture: Picture | None) -> str:
    minutes, seconds = divmod(entry.seconds, 60)
    figure = "" if picture is None else _figure(*picture)
    return (
        f'<tr class="{escape(entry.kind)}"><td>{minutes:.0f}:{seconds:06.3f}</td>'
        f"<td>{escape(entry.actor)}</td><td>{escape(entry.text)}{figure}</td></tr>\n"
    )


def _figure(frame: m.CameraFrame, overlay: Overlay) -> str:
    width, height = frame.width, frame.height
    parts = [_image("image/jpeg", frame.jpeg, width, height)]
    heat = heat_png(overlay.heat)
    if heat:
        parts.append(_image("image/png", heat, width, height))
    for box, label in overlay.boxes:
        parts.append(
            f'<rect x="{box.left:.1f}" y="{box.top:.1f}" width="{box.right - box.left:.1f}" '
            f'height="{box.bottom - box.top:.1f}" fill="none" stroke="#ffdc00" stroke-width="3"/>'
            f'<text x="{box.left:.1f}" y="{max(24.0, box.top - 8):.1f}" font-size="24" '
            f'fill="#ffdc00" stroke="#000" stroke-width="4" paint-order="stroke">'
            f"{escape(label)} {box.score:.2f}</text>"
        )
    if overlay.point is not None:
        u, v = overlay.point
        parts.append(
            f'<circle cx="{u:.1f}" cy="{v:.1f}" r="18" fill="none" stroke="#fff" '
            f'stroke-width="5"/><circle cx="{u:.1f}" cy="{v:.1f}" r="18" fill="none" '
            f'stroke="#0050ff" stroke-width="3"/>'
            f'<circle cx="{u:.1f}" cy="{v:.1f}" r="5" fill="#0050ff"/>'
        )
    caption = f"picture of robot time {frame.stamp_ns * 1e-9:.3f} s. {overlay.label}"
    return (
        f'<figure><svg viewBox="0 0 {width} {height}">'
        f"{''.join(parts)}</svg><figcaption>{escape(caption)}</figcaption></figure>"
    )


def _image(kind: str, data: bytes, width: int, height: int) -> str:
    encoded = base64.b64encode(data).decode()
    return (
        f'<image width="{width}" height="{height}" preserveAspectRatio="none" '
        f'href="data:{kind};base64,{encoded}"/>'
    )
