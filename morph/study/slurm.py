"""Engine that makes each cell a Slurm job."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from morph.errors import StudyError
from morph.study.engine import EngineName
from morph.study.submitit_engine import SubmititEngine

if TYPE_CHECKING:
    import submitit


class SlurmEngine(SubmititEngine):
    """Jobs of Slurm, submitted by `sbatch`; by default one core and 60 minutes each."""

    name: ClassVar[EngineName] = "slurm"
    poll_interval: ClassVar[float] = 2.0
    remote: ClassVar[bool] = True

    def __init__(self, folder: Path, *, workers: int, job: dict[str, str | int]) -> None:
        self._job = job
        if shutil.which("sbatch") is None:
            raise StudyError(
                "there is no `sbatch` on this machine",
                where="--engine slurm",
                fix="run it where jobs are submitted, or try it with --engine submitit-local",
            )
        super().__init__(folder, workers=workers)

    def _start(self, folder: Path) -> submitit.Executor:
        import submitit

        executor = submitit.AutoExecutor(folder=folder, cluster="slurm")
        try:
            executor.update_parameters(**{"cpus_per_task": 1, "timeout_min": 60, **self._job})
        except (NameError, ValueError, TypeError) as error:
            raise StudyError(
                f"submitit refuses {self._job}: {' '.join(str(error).split())[:300]}",
                where="--job",
                fix="name its parameters: timeout_min=60, mem_gb=4, slurm_partition=long",
            ) from error
        return executor
