"""Work in worker processes, so that Blender's window stays alive: start it, look how far it is, take the result, cancel."""
from .check_job import CheckJob
from .compress_job import CompressedFile, CompressJob
from .job import Job, WorkerCrash, cancel_all, running
from .machine import WorkerSettings
from .read_job import ReadJob

__all__ = ["CheckJob", "CompressJob", "CompressedFile", "Job", "ReadJob", "WorkerCrash", "WorkerSettings", "cancel_all",
           "running"]
