"""SurfaceTopography that cannot be imported: the message is on the package, not on the file."""

import tomllib

import pytest

import roughsim as rs
from roughsim.untrusted import end_child


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (
            'RuntimeError("cannot load MPI library")',
            r"cannot be imported \(RuntimeError: cannot load MPI library\)",
        ),
        pytest.param(
            'ImportError("libmpi.so.12: cannot open")',
            r"cannot be imported \(ImportError: libmpi.so.12: cannot open\)",
            marks=pytest.mark.slow,
        ),
        ('ModuleNotFoundError("no", name="NuMPI")', "NuMPI is not installed; type: pip install"),
    ],
)
def test_a_library_that_cannot_be_imported_is_named(
    tmp_path, monkeypatch, capped_scene, fault, words
):
    (tmp_path / "SurfaceTopography.py").write_text(f"raise {fault}\n")
    (tmp_path / "map.opd").write_bytes(b"\x01\x00Directory" + bytes(2000))
    monkeypatch.syspath_prepend(tmp_path)
    content = tomllib.loads(capped_scene.with_("numerics.levels", None).to_toml())
    end_child()  # the next one has this path
    try:
        with pytest.raises(ValueError, match=words) as refused:
            rs.load_scene(content | {"surface": {"topography": str(tmp_path / "map.opd")}})
        assert "damaged" not in str(refused.value)
    finally:
        end_child()
