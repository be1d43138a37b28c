"""Compressing objects one after the other in one job: gather their meshes, follow the job, hand out the results."""
import sys
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import bpy

from .. import bridge, jobs
from ..core.errors import MeshError, NpmError
from ..core.settings import CompressSettings
from ..preferences import worker_settings
from ..preview.threads import in_thread
from .expected_time import expected_seconds, learn, rates
from .job_operator import JobOperator, Steps, one_line
from .target import fingerprint

if TYPE_CHECKING:
    from ..core.mesh import TriMesh

_FED = object()  # what `feed` finds where every mesh was given to the job


@dataclass
class Item:
    """One object of a batch. Found again by its uid: while the job runs, anything may happen to it."""

    uid: int
    name: str
    made_from: str = ""  # its fingerprint

    def find(self) -> bpy.types.Object | None:
        """The object, if it still exists."""
        return next((o for o in bpy.data.objects if o.session_uid == self.uid), None)


class BatchOperator(JobOperator):
    """A JobOperator that compresses objects; `store_and_show` gets each object and its result."""

    def prepare(self, context: bpy.types.Context, result: jobs.CompressedFile) -> Steps:
        """What can be done before `store_and_show`, in steps. May raise NpmError."""
        yield from ()

    def store_and_show(self, context: bpy.types.Context, obj: bpy.types.Object, result: jobs.CompressedFile,
                       made_from: str) -> None:
        """What to do with the result for `obj`. May raise NpmError or OSError."""
        raise NotImplementedError

    def summarize(self, context: bpy.types.Context, done: list[bpy.types.Object], total: int) -> None:
        """What to say and select at the end."""

    def compress(self, context: bpy.types.Context, sources: Sequence[bpy.types.Object], settings: CompressSettings,
                 mesh: "TriMesh | None" = None) -> set:
        """Compress `sources`; returns the operator's result. mesh: that of the only source, if it is gathered already.

        Raises DependencyError or OSError.
        """
        self._items = [Item(obj.session_uid, obj.name) for obj in sources]
        self._settings, self._given, self._feeding = settings, mesh, self._feed_all()
        seconds = expected_seconds(sources, settings, context.view_layer.depsgraph)
        job = jobs.CompressJob(seconds, bpy.app.tempdir, worker_settings())
        job.estimate = rates().start + sum(seconds)
        return self.run_job(context, job)

    def doing(self) -> str:
        """Which object it is, and of how many."""
        total = len(self._items)
        k = min(self._job.position, total - 1)
        return f"Compressing '{self._items[k].name}'" + (f" ({k + 1} of {total})" if total > 1 else "")

    def feed(self, context: bpy.types.Context) -> bool:
        """Go on gathering the meshes, so that the window never waits for one to be written, or for all of them."""
        return next(self._feeding, _FED) is not _FED

    def _feed_all(self) -> Generator[None, None, None]:
        """Give the job all items, in steps."""
        job = self._job
        yield  # the window first draws that the job has begun
        for k, item in enumerate(self._items):
            try:
                obj = item.find()
                if obj is None:
                    raise MeshError(f"Expected '{item.name}' in the scene, found it removed")
                mesh, self._given = self._given, None
                if mesh is None:
                    mesh = bridge.mesh_of(obj, bpy.context.evaluated_depsgraph_get())
                yield
                item.made_from = yield from in_thread(partial(fingerprint, mesh, self._settings))
                twins = [j for j, other in enumerate(self._items[:k]) if other.made_from == item.made_from]
                if twins:
                    job.repeat(twins[0])
                else:
                    yield from in_thread(partial(job.add, mesh, self._settings))
            except NpmError as error:
                job.refuse(error)

    def finish(self, context: bpy.types.Context, outcomes: list) -> Steps:
        """Hand out what there is, one object a step, then report those that failed, by name."""
        done, failures = [], {}
        learn(outcomes, self._settings)
        for item, outcome in zip(self._items, outcomes, strict=True):
            obj = item.find()
            if obj is None or obj.name not in context.view_layer.objects:
                self.report({"WARNING"}, f"'{item.name}' was removed while it was compressed; the result is dropped")
                continue
            if isinstance(outcome, jobs.WorkerCrash):
                sys.stderr.write(f"{outcome}\n")
                outcome = jobs.WorkerCrash(str(outcome).partition("\n")[0] + "; the console says more")
            try:
                if isinstance(outcome, Exception):
                    raise outcome
                yield from self.prepare(context, outcome)
                obj = item.find()  # between two steps, anything may happen
                if obj is not None:
                    self.store_and_show(context, obj, outcome, item.made_from)
                    done.append(item.uid)
            except (NpmError, OSError, jobs.WorkerCrash) as error:
                failures.setdefault(one_line(error), []).append(f"'{item.name}'")
            yield
        for message, names in failures.items():
            self.report({"ERROR"}, f"{', '.join(names)}: {message}")
        self.summarize(context, [o for o in bpy.data.objects if o.session_uid in done], len(self._items))
        return {"FINISHED"} if done else {"CANCELLED"}
