import pytest

pytest.importorskip("igl")
from benchmarks import lodcost  # noqa: E402
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame  # noqa: E402
from tests.meshes.shapes import bumpy  # noqa: E402


def unit(depth):
    mesh = bumpy(depth)
    return TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F)


def test_every_step_and_both_ways_of_qslim_are_measured():
    row = lodcost.measured(unit(3), 1)
    assert row["faces"] == 1280 and row["left"] == lodcost.BASE_FACES
    assert all(row[k] > 0 for k in ("decimate", "levels", "qslim", "blocked", "memory"))


def test_the_table_has_a_line_for_every_mesh_and_medians_without_the_largest(monkeypatch):
    monkeypatch.setattr(lodcost, "meshes", lambda corpus: [
        ("one", unit(3), 1), ("two", unit(3), 1), ("large", unit(4), 1), ("small", unit(2), 1), ("million", unit(4), 1)])
    seconds = iter([1.0, 1.0, 1.0, 1.0] + [1.0, 2.0, 3.0, 6.0] + [10.0, 20.0, 1.0, 1.0] + 2 * [2.0, 2.0, 1.0, 1.0])

    def told(mesh, repeats):
        one, two, plain, blocked = (next(seconds) for _ in range(4))
        return {"faces": len(mesh.F), "decimate": one, "levels": two, "qslim": plain, "blocked": blocked, "left": 500,
                "memory": 100.0}

    monkeypatch.setattr(lodcost, "measured", told)
    *lines, _, summary = lodcost.table(None)
    assert len(lines) == 2 + 5 and "ends at 500 faces" in lines[2]
    assert "1.500 of qslim's time, 1.250 of blocking qslim's" in summary  # medians of 2, 1 and of 2, 0.5
    assert "5,120 faces take 1.0 times as long as 320, 5,120 faces take 10.0 times as long as 1,280" in summary
