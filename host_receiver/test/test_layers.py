"""The layers of both packages: a module imports from its own layer and from lower ones only."""

import ast
import functools
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
# Lowest first. A name is a module or a package below the top-level package.
LAYERS = {
    "ml2_receiver": (
        "printable", "json_text", "errors", "user_folder", "private_files", "stop_limit",
        "generated", "pacing", "wire", "table", "configuration", "security", "processes",
        "transport", "pairing", "session", "topics", "recording", "ros",
        "zenoh", "commands", "cli", "__main__",
    ),
    "ml2_tools": (
        "errors", "geometry", "images", "bags", "live", "monitoring", "headset", "doctor",
        "calibration", "inspection", "selftest", "products", "evaluation", "export",
        "playback", "compatibility", "viewing", "messages", "commands",
    ),
}  # fmt: skip
# Modules of the driver that the toolbox may use; a name stands for all below it.
PUBLIC = (
    "ml2_receiver.errors",
    "ml2_receiver.printable",
    "ml2_receiver.json_text",
    "ml2_receiver.private_files",
    "ml2_receiver.generated",
    "ml2_receiver.wire",
    "ml2_receiver.table",
    "ml2_receiver.configuration",
    "ml2_receiver.security",
    "ml2_receiver.processes",
    "ml2_receiver.pairing",
    "ml2_receiver.transport",
    "ml2_receiver.session.statistics",
    "ml2_receiver.session.stream_state",
    "ml2_receiver.session.streams",
    "ml2_receiver.topics",
    "ml2_receiver.recording",
    "ml2_receiver.ros.context",
    "ml2_receiver.ros.raw_taker",
    "ml2_receiver.ros.real_time",
    "ml2_receiver.ros.spinning",
    "ml2_receiver.ros.fastdds",
    "ml2_receiver.commands",
)
NOT_IN_THE_DRIVER = {"cv2", "matplotlib", "pycolmap", "scipy", "websockets", "ml2_tools"}


@functools.cache
def modules(top: str) -> list[str]:
    files = (path.relative_to(ROOT).with_suffix("") for path in (ROOT / top).rglob("*.py"))
    return sorted(".".join(file.parts) for file in files)


@functools.cache
def imports(module: str) -> list[str]:
    """The absolute name of every module that this one imports, lazily or at once."""
    return list(_imports(module))


def _imports(module: str) -> Iterator[str]:
    path = ROOT / Path(*module.split(".")).with_suffix(".py")
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            package = module.split(".")[: -node.level] if node.level else []
            yield ".".join([*package, *(node.module or "").split(".")])


def layer(module: str) -> str:
    top, _, below = module.partition(".")
    return below.split(".")[0] if top in LAYERS and below else ""


@pytest.mark.parametrize("top", LAYERS)
def test_every_module_is_in_a_layer(top: str) -> None:
    found = {layer(module) for module in modules(top)} - {"__init__"}
    assert found == set(LAYERS[top])


@pytest.mark.parametrize("top", LAYERS)
def test_each_package_says_what_it_is_for(top: str) -> None:
    files = [ROOT / top / name / "__init__.py" for name in LAYERS[top]]
    silent = [
        it for it in files if it.exists() and not ast.get_docstring(ast.parse(it.read_text()))
    ]
    assert silent == []


@pytest.mark.parametrize("top", LAYERS)
def test_no_layer_imports_from_a_higher_one(top: str) -> None:
    order = LAYERS[top]
    upward = [
        f"{module} imports {imported}"
        for module in modules(top)
        for imported in imports(module)
        if imported.startswith(f"{top}.") and layer(module) in order
        if order.index(layer(imported)) > order.index(layer(module))
    ]
    assert upward == []


@pytest.mark.parametrize("top", LAYERS)
def test_modules_do_not_import_each_other_in_circles(top: str) -> None:
    graph = {it: {i for i in imports(it) if i in modules(top)} for it in modules(top)}
    while free := {it for it, needed in graph.items() if not needed & graph.keys()}:
        graph = {it: needed for it, needed in graph.items() if it not in free}
    assert graph == {}


def test_the_driver_needs_no_tools() -> None:
    found = [
        f"{module} imports {imported}"
        for module in modules("ml2_receiver")
        for imported in imports(module)
        if imported.partition(".")[0] in NOT_IN_THE_DRIVER
    ]
    assert found == []


def test_the_toolbox_uses_public_modules_of_the_driver_only() -> None:
    found = [
        f"{module} imports {imported}"
        for module in modules("ml2_tools")
        for imported in imports(module)
        if imported.startswith("ml2_receiver.")
        and not any(f"{imported}.".startswith(f"{public}.") for public in PUBLIC)
    ]
    assert found == []
