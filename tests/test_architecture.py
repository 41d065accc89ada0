"""The layout: which module may import what, one door per heavy package, and a package that imports at once."""

import ast
import subprocess
import sys
import textwrap
import tokenize
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = sorted([*(ROOT / "roughsim").rglob("*.py"), *(ROOT / "theory").rglob("*.py")])
# data flows to the right: a module may import only what stands before it
ORDER = (
    "show",
    "errors",
    "machine",
    "untrusted",
    "extensions",
    "grid",
    "table",
    "_kernels",
    "fourier",
    "surface",
    "contact",
    "heat",
    "observables",
    "pipeline",
    "sliding",
    "scene",
    "prediction",
    "estimate",
    "planning",
    "store",
    "results",
    "charts",
    "comparison",
    "ensemble",
    "studies",
    "error_over_cost",
    "outputs",
    "explore",
    "cli",
)
DOORS = {
    "pyfftw": {"roughsim.fourier"},
    "numba": {"roughsim._kernels"},
    "h5py": {
        "roughsim.store",
        "roughsim.results",
        "roughsim.untrusted",
        "roughsim.surface.topography",
    },
    "SurfaceTopography": {"roughsim.surface.topography"},
    "matplotlib": {"roughsim.charts"},
    "pint": {"roughsim.scene"},
    "pydantic": {"roughsim.scene"},
    "typer": {"roughsim.cli"},
    "bokeh": {"roughsim.explore"},
    "theory": {"roughsim.prediction", "theory"},
    "roughsim": {"roughsim"},
}

# the insides of Python and of other packages, which a new release may change
INSIDES = ("numba.core", "numba.extending", "numba.np", "llvmlite", "gc")
REACHED = ("sys.modules", "os._exit", "mallopt", "_nrt", "no_cfunc_wrapper")


def module_name(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def imported(path):
    """Every module that a file imports, also inside functions and for annotations."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and node.module != "__future__":
            found += [f"{node.module}.{alias.name}" for alias in node.names]
    return found


def imports(sources=SOURCES):
    """All pairs of the name of a module and what it imports."""
    return [(module_name(path), target) for path in sources for target in imported(path)]


def test_no_folder_of_tests_shadows_a_package():
    packages = {source.relative_to(ROOT).parts[0] for source in SOURCES}
    folders = [ROOT / "tests", *filter(Path.is_dir, (ROOT / "tests").rglob("*"))]
    assert not [
        (folder, name) for folder in folders for name in packages if (folder / name).is_dir()
    ]


def lies_in(name, packages):
    """Whether a module is one of these or inside of one."""
    return any(name == package or name.startswith(package + ".") for package in packages)


def test_heavy_packages_come_through_their_door():
    heavy = [(name, target) for name, target in imports() if target.split(".")[0] in DOORS]
    assert len({name for name, _ in heavy}) > 200
    assert [
        f"{name} imports {target}"
        for name, target in heavy
        if not lies_in(name, DOORS[target.split(".")[0]])
    ] == []


def test_only_public_interfaces_of_python_and_other_packages_are_used():
    for name, target in imports():
        package, *inside = target.split(".")
        own = package in ("roughsim", "theory")
        private = package.startswith("_") or any(part.startswith("_") for part in inside)
        assert own or not private, f"{name} imports {target}"
        assert not lies_in(target, INSIDES), f"{name} imports {target}"
    for path in SOURCES:
        text = path.read_text()
        assert [words for words in REACHED if words in text] == [], path


def test_data_flows_one_way():
    for name, target in imports():
        stage, wanted = (one.split(".")[1:2] for one in (name, target))
        if not (name.startswith("roughsim.") and target.startswith("roughsim.")):
            continue
        if stage[0] in ORDER and wanted[0] in ORDER:
            assert ORDER.index(wanted[0]) <= ORDER.index(stage[0]), (
                f"{name} imports {target}, which stands after it"
            )


def test_every_module_has_its_place():
    stages = {
        module_name(path).split(".")[1]
        for path in SOURCES
        if module_name(path).startswith("roughsim.")
    }
    assert stages - {"scenes", "__main__"} == set(ORDER)


def tokens_of(path):
    """Count the tokens of a module: names, operators, numbers and strings; air is free."""
    counted, whole, within = {"NAME", "OP", "NUMBER", "STRING"}, 0, 0
    with tokenize.open(path) as file:
        for token in tokenize.generate_tokens(file.readline):
            kind = tokenize.tok_name[token.type]
            within += kind == "FSTRING_START"  # from Python 3.12 on its parts are tokens, too
            whole += within == 0 and kind in counted
            within -= kind == "FSTRING_END"
            whole += within == 0 and kind == "FSTRING_END"
    return whole


def test_modules_stay_small():
    # none has less than 3.5 bytes for each token
    long = {module_name(path): tokens_of(path) for path in SOURCES if path.stat().st_size >= 14_000}
    assert {name: tokens for name, tokens in long.items() if tokens > 4000} == {}


@pytest.mark.parametrize(
    ("text", "tokens"),
    [("a = 1\n\n# air\n", 3), ("b = 'x y'\n", 3), ("""c = f"{a + 1:.{b}f} {f'{a}'}"\n""", 3)],
)
def test_an_f_string_is_one_token_in_each_python(tmp_path, text, tokens):
    path = tmp_path / "module.py"
    path.write_text(text)
    assert tokens_of(path) == tokens


def test_rooms_stay_few():
    assert len(ORDER) <= 29  # and the folder of scenes


def test_no_imports_go_in_circles_not_even_for_annotations():
    modules = {module_name(path): path for path in SOURCES if module_name(path) != "roughsim"}

    def home(name):  # of a name in a module, the module
        while name and name not in modules:
            name = name.rpartition(".")[0]
        return name

    graph = {
        name: {home(target) for target in imported(path)} - {"", name}
        for name, path in modules.items()
    }
    list(TopologicalSorter(graph).static_order())  # a CycleError names the circle


def test_importing_roughsim_imports_nothing_heavy():
    code = (
        "import sys, roughsim; heavy = {'numpy', 'scipy', 'numba', 'h5py', 'matplotlib', 'pydantic', 'pint', 'pyfftw'};"
        "print(sorted(heavy & set(sys.modules)))"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert found.stdout.strip() == "[]"


@pytest.mark.slow
def test_verbs_that_solve_no_contact_load_neither_compiler_nor_transforms():
    modules = "comparison.tables comparison.trust outputs.compare outputs.status planning.plan"
    code = f"""
        import sys, {", ".join(f"roughsim.{name}" for name in modules.split())}
        print({{"numba", "pyfftw", "h5py", "matplotlib", "pint"}} & set(sys.modules))
        import roughsim as rs
        assert rs.plan(rs.load_scene("steel-0.5GPa"), 0.013).levels
        print({{"numba", "pyfftw", "scipy.fft", "scipy.optimize"}} & set(sys.modules))
        import roughsim.heat, roughsim.observables.moments
        print("numba" in sys.modules)  # what needs a transform, but no kernel
        [getattr(rs, name) for name in rs.__all__]  # whatever was imported before
        assert callable(rs.plan) and callable(rs.compare) and "Grid" in dir(rs)
    """
    found = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    assert found.stdout.split() == ["set()", "set()", "False"]


def test_a_worker_loads_no_scenes_and_no_theory():
    code = (
        "import sys, roughsim.ensemble.workers; names = {'h5py', "
        "'pydantic', 'theory', 'roughsim.scene', 'roughsim.prediction'}; print(*(names & set(sys.modules)))"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert found.stdout.strip() == ""


def test_a_kernel_that_others_call_keeps_the_order_of_its_sums_or_is_always_a_part_of_them():
    # otherwise a process that compiles and one that loads what was compiled differ in the last bits
    called = 0
    for path in (ROOT / "roughsim" / "_kernels").glob("*.py"):
        functions = {
            f.name: f for f in ast.parse(path.read_text()).body if isinstance(f, ast.FunctionDef)
        }
        functions = {
            name: f
            for name, f in functions.items()
            if any("kernel(" in ast.unparse(d) for d in f.decorator_list)
        }
        for function in functions.values():
            names = {
                n.func.id
                for n in ast.walk(function)
                if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)
            }
            for name in names & functions.keys() - {function.name}:
                called += 1
                (decorator,) = functions[name].decorator_list
                given = {word.arg for word in decorator.keywords}
                assert "fastmath" not in given or "inline" in given, (
                    f"{path.name}: {name}, called by {function.name}"
                )
    assert called > 10
