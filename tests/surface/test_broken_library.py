"""SurfaceTopography that cannot be imported: the message is on the package, not on the file."""

import sys
import tomllib

import pytest

import roughsim as rs
from roughsim.untrusted import end_child

FAULTS = {
    'RuntimeError("cannot load MPI library")': r"cannot be imported \(RuntimeError: cannot load MPI library\)",
    'ImportError("libmpi.so.12: cannot open")': r"cannot be imported \(ImportError: libmpi.so.12: cannot open\)",
    'ModuleNotFoundError("no", name="NuMPI")': "NuMPI is not installed; type: pip install",
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("in_child", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_library_that_cannot_be_imported_is_named(
    tmp_path, monkeypatch, capped_scene, fault, in_child
):
    (tmp_path / "SurfaceTopography.py").write_text(f"raise {fault}\n")
    (tmp_path / "map.opd").write_bytes(b"\x01\x00Directory" + bytes(2000))
    monkeypatch.syspath_prepend(tmp_path)
    content = tomllib.loads(capped_scene.with_("numerics.levels", None).to_toml())
    if in_child:
        end_child()  # the next one has this path
    else:
        monkeypatch.delitem(sys.modules, "SurfaceTopography", raising=False)
        call = "roughsim.surface.topography.reading.call_in_child"
        monkeypatch.setattr(call, lambda function, *arguments, seconds: function(*arguments))
    try:
        with pytest.raises(ValueError, match=FAULTS[fault]) as refused:
            rs.load_scene(content | {"surface": {"topography": str(tmp_path / "map.opd")}})
        assert "damaged" not in str(refused.value)
    finally:
        if in_child:
            end_child()
