"""Draw how data flows (figures/data.svg), and from the imports how the code does: figures/flow.svg, reference/flow.md.

    python docs/flow.py

reference/flow.md gets a table of the rooms and the tree of all modules, from the first line of each docstring.

An arrow goes from a module to one that imports it. Where a longer way exists the short arrow is left out, so that what
remains is the order in which one has to understand the modules. A module stands one row below the lowest that it
imports.
"""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from itertools import pairwise
from pathlib import Path

HERE = Path(__file__).parent
PACKAGE = HERE.parent / "roughsim"
DATA, PICTURE, PAGE = (
    HERE / "figures" / "data.svg",
    HERE / "figures" / "flow.svg",
    HERE / "reference" / "flow.md",
)
START, END = "<!-- {}: written by docs/flow.py -->\n", "<!-- end -->"
WIDTH, HEIGHT, GAP, DOWN = (
    112,
    28,
    24,
    64,
)  # a box, the space beside it, and from one row to the next, px
COLORS = {"data": "#eef3f8", "theory": "#fdeed7", "edge": "#ece6f5"}
LINE = 'fill="none" stroke="#99a" stroke-width="1.2" marker-end="url(#tip)"'
# folders whose files are found by their place: those count that the folder names, so that a new one changes no picture
OPEN = ()
# what meets files, screens and people
EDGE = ("charts", "cli", "explore", "results", "outputs", "scene", "show", "store")
# where each room stands in the picture of the data (column, row), and what goes from one to the next
ROOMS = {
    "scene": (1, 0),
    "planning": (1, 1),
    "pipeline": (1, 2),
    "surface": (1, 3),
    "contact": (1, 4),
    "observables": (0, 5),
    "store": (1, 6),
    "results": (1, 7),
    "estimate": (0, 7),
    "theory": (-1, 7),
    "prediction": (-1, 8),
    "comparison": (0, 8),
    "heat": (2, 7),
    "charts": (1, 8),
    "explore": (2, 8),
}
HANDED = (
    ("scene", "planning", "Scene"),
    ("planning", "pipeline", "Problem"),
    ("pipeline", "surface", "spectrum, grid"),
    ("surface", "contact", "heights"),
    ("contact", "observables", "pressure"),
    ("contact", "store", "fields of the first members"),
    ("observables", "store", "moments, |σ_q|²"),
    ("store", "results", "members"),
    ("results", "estimate", "numbers"),
    ("results", "heat", "pressure"),
    ("results", "charts", "curves"),
    ("heat", "charts", "temperature"),
    ("heat", "explore", "temperature"),
    ("estimate", "comparison", "mean ± error"),
    ("theory", "prediction", "formulas"),
    ("prediction", "comparison", "theory"),
)
STEP, FALL = 200, 84  # from one column and row of that picture to the next, px

Graph = dict[str, set[str]]


def imported(path: Path) -> set[str]:
    """The names a file imports, also inside functions; not what only type checkers read."""
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            node.body = []
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def sources() -> dict[str, list[Path]]:
    """The files of each module directly below the package; a folder is one module."""
    found = {}
    for path in sorted(PACKAGE.iterdir()):
        if path.suffix == ".py" and path.stem != "__init__":
            found[path.stem] = [path]
        elif (path / "__init__.py").exists() and any(path.glob("[!_]*.py")):
            found[path.name] = [
                file for file in sorted(path.rglob("*.py")) if path.name not in OPEN or counts(file)
            ]
    return found


def counts(file: Path) -> bool:
    """Whether a file of an open folder is named in its `__init__`, or is that."""
    return file.stem == "__init__" or f'"{file.stem}"' in file.with_name("__init__.py").read_text()


def imports() -> Graph:
    """What each module imports of the package, and `theory`."""
    files = sources()
    graph: Graph = {"theory": set()}
    for name, paths in files.items():
        words = {word for path in paths for word in imported(path)}
        inside = {word.split(".")[1] for word in words if word.startswith("roughsim.")} & set(files)
        outside = {"theory"} & {word.split(".")[0] for word in words}
        graph[name] = (inside | outside) - {name}
    return graph


def reduced(graph: Graph) -> Graph:
    """The graph without arrows that a longer way replaces."""
    below: Graph = {}
    for name in TopologicalSorter(graph).static_order():
        below[name] = set().union(*({other} | below[other] for other in graph[name]))
    return {
        name: others - set().union(*(below[other] for other in others))
        for name, others in graph.items()
    }


def depths(graph: Graph) -> dict[str, int]:
    """The row of each module."""
    depth: dict[str, int] = {}
    for name in TopologicalSorter(graph).static_order():
        depth[name] = 1 + max((depth[other] for other in sorted(graph[name])), default=-1)
    return depth


def chains(graph: Graph) -> list[list[str]]:
    """Each arrow as the places it passes: in the rows between, a narrow one that is named after the arrow."""
    depth = depths(graph)
    return [
        [low, *(f"{low}>{high}@{level}" for level in range(depth[low] + 1, depth[high])), high]
        for high in sorted(graph)
        for low in sorted(graph[high])
    ]


def rows(graph: Graph) -> list[list[str]]:
    """Modules and passing arrows by row, in the order with the shortest ways sideways that a few sweeps find."""
    depth = depths(graph)
    links = [pair for chain in chains(graph) for pair in pairwise(chain)]
    for low, high in links:
        depth.setdefault(high, depth[low] + 1)
    levels = [
        sorted(name for name in depth if depth[name] == level)
        for level in range(1 + max(depth.values()))
    ]
    best = levels
    for sweep in range(40):
        levels = swept(levels, links, downwards=sweep % 2 == 0)
        best = min(best, levels, key=lambda some: sideways(some, links))
    return best


def swept(
    levels: list[list[str]], links: list[tuple[str, str]], *, downwards: bool
) -> list[list[str]]:
    """Each row ordered by the mean place of its neighbours in the row before, then in the other."""
    levels = [list(level) for level in levels]
    for level in levels if downwards else reversed(levels):
        place = centres(levels)
        near = {
            name: [low if high == name else high for low, high in links if name in (low, high)]
            for name in level
        }
        level.sort(
            key=lambda name: (sum(place[other] for other in near[name]) / len(near[name]), name)
        )
    return levels


def sideways(levels: list[list[str]], links: list[tuple[str, str]]) -> int:
    """How far all arrows go sideways, px."""
    place = centres(levels)
    return sum(abs(place[low] - place[high]) for low, high in links)


def centres(levels: list[list[str]]) -> dict[str, int]:
    """The x of each place, each row about the middle, px."""
    place = {}
    for level in levels:
        widths = [GAP if "@" in name else WIDTH for name in level]
        left = -(sum(widths) + GAP * (len(level) - 1)) // 2
        for name, width in zip(level, widths, strict=True):
            place[name] = left + width // 2
            left += width + GAP
    return place


def data_picture() -> str:
    """The way of the data as SVG: numbers on the left, fields on the right."""
    place = {name: (column * STEP, row * FALL) for name, (column, row) in ROOMS.items()}
    left, right = (edge(x for x, _ in place.values()) for edge in (min, max))
    below = max(y for _, y in place.values())
    lines = frame(left - WIDTH, right + WIDTH, below + HEIGHT)
    for start, end, label in HANDED:
        (x, y), (to, bottom) = place[start], place[end]
        if y == bottom:  # side by side
            side = WIDTH // 2 if to > x else -WIDTH // 2
            lines.append(f'<path d="M{x + side} {y + HEIGHT // 2}H{to - side}" {LINE}/>')
            middle = (x + to) // 2, y - 4
        else:
            lines.append(arrow([(x, y), (to, bottom)]))
            middle = (x + to) // 2, (y + HEIGHT + bottom) // 2 + 4
        for color in (
            'stroke="white" stroke-width="5"',
            'fill="#334"',
        ):  # a white rim keeps the arrow off the words
            lines.append(
                f'<text x="{middle[0]}" y="{middle[1]}" font-size="12" {color}>{label}</text>'
            )
    lines += [box(name, x, y) for name, (x, y) in place.items()]
    return "\n".join([*lines, "</svg>\n"])


def frame(left: int, right: int, height: int) -> list[str]:
    """The head of a picture: its size, a white ground, and the tip of its arrows."""
    top, width = -GAP, right - left
    return [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left} {top} {width} {height + 2 * GAP}" '
        f'width="{width}" font-family="sans-serif" font-size="14" text-anchor="middle">',
        f'<rect x="{left}" y="{top}" width="{width}" height="{height + 2 * GAP}" fill="white"/>',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 0L8 4L0 8z" fill="#667"/></marker></defs>',
    ]


def picture(graph: Graph) -> str:
    """The imports as SVG."""
    simple = reduced(graph)
    levels = rows(simple)
    x, y = centres(levels), {name: k * DOWN for k, level in enumerate(levels) for name in level}
    half = max(abs(value) for value in x.values()) + WIDTH // 2 + GAP
    height = (len(levels) - 1) * DOWN + HEIGHT
    lines = frame(-half, half, height)
    lines += [arrow([(x[name], y[name]) for name in chain]) for chain in chains(simple)]
    lines += [box(name, x[name], y[name]) for level in levels for name in level if "@" not in name]
    return "\n".join([*lines, "</svg>\n"])


def arrow(points: list[tuple[int, int]]) -> str:
    """A curve from the lower side of the first box through the passing places to the upper side of the last."""
    (left, top), *others = points
    top += HEIGHT
    path = f"M{left} {top}"
    for number, (right, bottom) in enumerate(others, 1):
        middle = (top + bottom) // 2
        path += f"C{left} {middle} {right} {middle} {right} {bottom}"
        left, top = right, bottom
        if number < len(others):
            top += HEIGHT
            path += f"V{top}"
    return f'<path d="{path}" {LINE}/>'


def box(name: str, x: int, y: int) -> str:
    """A module."""
    kind = "theory" if name in ("theory", "prediction") else "edge" if name in EDGE else "data"
    return (
        f'<rect x="{x - WIDTH // 2}" y="{y}" width="{WIDTH}" height="{HEIGHT}" rx="5" fill="{COLORS[kind]}" '
        f'stroke="#556"/><text x="{x}" y="{y + HEIGHT // 2 + 5}">{name}</text>'
    )


def table(graph: Graph) -> str:
    """What each room is for, in its own words, and what it imports, in the order of the picture."""
    depth = depths(graph)
    lines = ["| room | what it does | imports |", "|---|---|---|"]
    for name in sorted(graph, key=lambda name: (depth[name], name)):
        home = HERE.parent / "theory" if name == "theory" else PACKAGE / name
        path = home / "__init__.py" if home.is_dir() else home.with_suffix(".py")
        summary = first_line(path).replace("|", "\\|")
        lines.append(f"| `{name}` | {summary} | {', '.join(sorted(graph[name])) or '–'} |")
    return "\n".join(lines) + "\n"


def first_line(path: Path) -> str:
    """What a module says of itself first."""
    return (ast.get_docstring(ast.parse(path.read_text())) or "").partition("\n")[0]


def tree(graph: Graph) -> str:
    """The rooms in the order of the picture, their modules indented below them, each with its first line."""
    depth = depths(graph)
    lines = ["```", "roughsim/"]
    for name in sorted(set(graph) - {"theory"}, key=lambda name: (depth[name], name)):
        folder = PACKAGE / name
        if folder.with_suffix(".py").exists():
            lines.append(f"  {name + '.py':28}{first_line(folder.with_suffix('.py'))}")
            continue
        lines.append(f"  {name + '/':28}{first_line(folder / '__init__.py')}")
        for path in sorted(folder.rglob("*.py"), key=lambda path: (path.parent, path.name)):
            if path.name != "__init__.py":
                lines.append(f"    {path.relative_to(folder).as_posix():26}{first_line(path)}")
    return "\n".join([*lines, "```"]) + "\n"


def page(text: str, graph: Graph) -> str:
    """Return the page with the table of the rooms and the tree of the modules of a graph between their marks."""
    for name, written in (("rooms", table(graph)), ("modules", tree(graph))):
        start = START.format(name)
        before, _, rest = text.partition(start)
        text = before + start + "\n" + written + "\n" + END + rest.partition(END)[2]
    return text


if __name__ == "__main__":
    found = imports()
    DATA.write_text(data_picture())
    PICTURE.write_text(picture(found))
    PAGE.write_text(page(PAGE.read_text(), found))
