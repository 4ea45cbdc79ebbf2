"""Orders to a `FlightLoop` without its process."""

from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerRefusal, WorkerRequest, WorkerResult
from workbench.live.flying import FlightLoop


def execute(flying: FlightLoop, order: object) -> WorkerResult | WorkerRefusal:
    """Execute an order now, report, and return the answer."""
    answer: WorkerResult | WorkerRefusal
    try:
        answer = WorkerResult(1, flying.do(WorkerRequest(1, order)))
    except WorkbenchError as error:
        answer = WorkerRefusal(1, str(error))
    flying.report()
    return answer
