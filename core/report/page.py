"""A page of HTML that holds all it needs: no script, no network, pictures inside."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from .drawing import Drawing, svg
from .table import Table

_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #21242a; background: #f4f5f6; margin: 0; }
main { max-width: 1120px; margin: 0 auto; padding: 32px 24px 64px; }
h1 { font-size: 28px; margin: 0 0 4px; } h2 { font-size: 20px; margin: 40px 0 8px; }
p { margin: 6px 0 10px; max-width: 76ch; } .lead { color: #50555e; }
.row { display: flex; flex-wrap: wrap; gap: 16px; align-items: flex-start; }
figure { margin: 8px 0; background: #fff; border: 1px solid #dfe1e4; border-radius: 6px; padding: 6px; }
figure svg, figure img { display: block; max-width: 100%; height: auto; }
figcaption { font-size: 13px; color: #50555e; padding: 4px 10px 6px; max-width: 500px; }
table { border-collapse: collapse; background: #fff; border: 1px solid #dfe1e4; margin: 8px 0; font-size: 14px; }
th, td { padding: 4px 12px; text-align: left; border-bottom: 1px solid #eceef0; vertical-align: top; }
th { background: #eef0f2; } td.number { text-align: right; font-variant-numeric: tabular-nums; }
li { max-width: 76ch; }
"""


@dataclass(frozen=True)
class Paragraph:
    text: str


@dataclass(frozen=True)
class Bullets:
    texts: tuple[str, ...]


@dataclass(frozen=True)
class Figure:
    """A drawing, or a picture as the bytes of a PNG or JPEG file, with a caption."""

    content: Drawing | bytes
    caption: str = ""


@dataclass(frozen=True)
class FigureRow:
    """Figures side by side, as far as the window is wide enough."""

    figures: tuple[Figure, ...]


Block = Paragraph | Bullets | Figure | FigureRow | Table


@dataclass(frozen=True)
class Section:
    title: str
    blocks: tuple[Block, ...]


def html_page(title: str, lead: str, sections: Sequence[Section]) -> str:
    """Return the whole page as text."""
    body = "".join(
        f"<h2>{escape(section.title)}</h2>{''.join(_block(block) for block in section.blocks)}" for section in sections
    )
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head>'
        f'<body><main><h1>{escape(title)}</h1><p class="lead">{escape(lead)}</p>{body}</main></body></html>\n'
    )


def _block(block: Block) -> str:
    if isinstance(block, Paragraph):
        return f"<p>{escape(block.text)}</p>"
    if isinstance(block, Bullets):
        return f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in block.texts)}</ul>"
    if isinstance(block, Table):
        return block.html()
    if isinstance(block, FigureRow):
        return f'<div class="row">{"".join(_block(figure) for figure in block.figures)}</div>'
    caption = f"<figcaption>{escape(block.caption)}</figcaption>" if block.caption else ""
    return f"<figure>{_content(block.content)}{caption}</figure>"


def _content(content: Drawing | bytes) -> str:
    if isinstance(content, Drawing):
        return svg(content)
    kind = "png" if content.startswith(b"\x89PNG") else "jpeg"
    data = base64.b64encode(content).decode("ascii")
    return f'<img src="data:image/{kind};base64,{data}" alt="">'
