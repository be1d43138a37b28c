"""Several objects in one go: each gets its result, one that fails is named and stops nothing, one cancel for all."""
import time

import bpy
import numpy as np
import pytest

from .conftest import add_object, positions, refusal
from .test_compress import leftovers

QUICK = {"base_faces": 80, "levels": 1}


def add_objects(*names: str):
    """Objects of different shape, all selected, the last one active."""
    objects = []
    for k, name in enumerate(names):
        obj = add_object(name, subdivisions=4)
        obj.data.transform(((1, 0, 0, 0), (0, 1 + k, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
        obj.location.x = 3 * k
        objects.append(obj)
    for obj in objects:
        obj.select_set(True)
    return objects


def test_every_object_gets_its_preview():
    objects = add_objects("A", "B", "C")
    assert bpy.ops.object.npmesh_compress(**QUICK) == {"FINISHED"}
    shown = {o.npmesh.source.name: o for o in bpy.context.selected_objects}
    assert set(shown) == {"A", "B", "C"} and all(o.npmesh.is_preview for o in shown.values())
    assert bpy.context.active_object == shown["C"]
    for obj in objects:
        assert obj.hide_get() and shown[obj.name].location == obj.location
        assert abs(np.ptp(positions(shown[obj.name])[:, 1]) / np.ptp(positions(obj)[:, 1]) - 1) < 0.1
    assert not leftovers()


def test_all_get_the_settings_of_the_active_one():
    a, b = add_objects("A", "B")
    a.npmesh.levels, b.npmesh.levels = 4, 1
    b.npmesh.base_faces = 80
    bpy.ops.object.npmesh_compress()
    assert a.npmesh.levels == 1
    assert [len(o.data.polygons) for o in bpy.context.selected_objects] == [320, 320]


def test_one_that_fails_is_named_and_stops_nothing():
    add_objects("A", "Empty", "C", "Bad")
    bpy.data.objects["Empty"].data.clear_geometry()
    bpy.data.objects["Bad"].data.vertices[0].co.x = float("nan")
    message = refusal(bpy.ops.object.npmesh_compress, **QUICK)
    assert "'Empty': Expected a mesh with vertices" in message and "'Bad': Expected finite coordinates" in message
    assert {o.npmesh.source.name for o in bpy.context.selected_objects if o.npmesh.is_preview} == {"A", "C"}
    assert not bpy.data.objects["Empty"].hide_get()


def test_the_same_failure_of_several_is_one_line():
    for obj in add_objects("A", "B"):
        obj.data.clear_geometry()
    assert "'A', 'B': Expected a mesh with vertices" in refusal(bpy.ops.object.npmesh_compress, **QUICK)


def test_a_worker_that_crashes_costs_one_object(part, monkeypatch):
    jobs, crashed = part("jobs"), []
    poll = jobs.CompressJob.poll

    def crashing(job):
        if job.position >= 1 and not crashed:
            crashed.append(job._process.pid)
            job._process.kill()
            job._process.wait()
        return poll(job)

    monkeypatch.setattr(jobs.CompressJob, "poll", crashing)
    add_objects("A", "B", "C")
    message = refusal(bpy.ops.object.npmesh_compress, **QUICK)
    # the worker may be one object ahead of what has been read of it
    failed = [name for name in "BC" if f"'{name}': The worker process ended early" in message]
    assert len(failed) == 1 and "Traceback" not in message
    shown = {o.npmesh.source.name for o in bpy.context.selected_objects if o.npmesh.is_preview}
    assert shown == {"A", "B", "C"} - set(failed)
    assert not leftovers()


def test_objects_that_share_a_mesh_are_compressed_once(part, monkeypatch):
    a, = add_objects("A")
    twin = bpy.data.objects.new("Twin", a.data)
    bpy.context.collection.objects.link(twin)
    twin.select_set(True)
    jobs, added = part("jobs"), []
    add = jobs.CompressJob.add
    monkeypatch.setattr(jobs.CompressJob, "add", lambda job, *rest: (added.append(1), add(job, *rest)))
    bpy.ops.object.npmesh_compress(**QUICK)
    assert len(added) == 1 and a["npmesh_stream"] == twin["npmesh_stream"]
    first, second = bpy.context.selected_objects
    assert first.data != second.data and {first.npmesh.source, second.npmesh.source} == {a, twin}


def test_a_preview_and_its_original_are_one_object():
    a, = add_objects("A")
    bpy.ops.object.npmesh_compress(**QUICK)
    a.hide_set(False)
    a.select_set(True)
    bpy.ops.object.npmesh_compress(base_faces=60)
    assert sum(o.npmesh.is_preview for o in bpy.data.objects) == 1


def test_cancelling_many_leaves_nothing(part):
    objects = add_objects("A", "B", "C")
    job = part("jobs").CompressJob([1, 1, 1], bpy.app.tempdir, part("preferences").worker_settings())
    settings = part("core.settings").CompressSettings()
    for obj in objects:
        job.add(part("bridge").mesh_of(obj, bpy.context.evaluated_depsgraph_get()), settings)
    while job.position == 0:
        job.poll()
        time.sleep(0.02)
    job.cancel()
    assert job.position < 3 and job._process.returncode  # killed at work
    assert not leftovers() and not part("jobs").running()


def test_the_progress_of_many_is_one(part):
    objects = add_objects("A", "B")
    job = part("jobs").CompressJob([1, 3], bpy.app.tempdir, part("preferences").worker_settings())
    settings = part("core.settings").CompressSettings()
    for obj in objects:
        job.add(part("bridge").mesh_of(obj, bpy.context.evaluated_depsgraph_get()), settings)
    seen = []
    results = job.wait(lambda fraction, message: seen.append((job.position, fraction)))
    fractions = [f for _, f in seen]
    assert fractions == sorted(fractions) and all(f <= 0.25 for k, f in seen if k == 0)
    assert [r.report["faces"] for r in results] == [1280, 1280] and all(r.seconds > 0 for r in results)


@pytest.mark.parametrize("kind", ["light", "camera", "empty"])
def test_what_has_no_surface_is_left_out_of_a_selection(kind):
    a, = add_objects("A")
    getattr(bpy.ops.object, f"{kind}_add")()
    a.select_set(True)
    bpy.ops.object.npmesh_compress(**QUICK)
    assert [o.npmesh.source for o in bpy.context.selected_objects if o.npmesh.is_preview] == [a]


def test_what_the_worker_says_after_the_last_outcome_is_ignored(part):
    """All meshes may be refused before the worker has said its first word."""
    errors, job = part("core.errors"), part("jobs").CompressJob([1], bpy.app.tempdir, part("preferences").worker_settings())
    try:
        job.refuse(errors.MeshError("Expected a mesh, found none"))
        deadline = time.monotonic() + 120
        while job._line == "" and not (job._folder / "out").stat().st_size:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        assert job.poll()
    finally:
        outcomes = job.result()
    assert isinstance(outcomes[0], errors.MeshError) and not leftovers()
