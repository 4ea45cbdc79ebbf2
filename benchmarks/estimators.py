"""How long an update of each estimator takes: `python benchmarks/estimators.py`.

It is called from Python, as a session does. The EKF with all sensors should take 500 us. The
time of numpy for F P F' of the EKF's size in the same turn shows whether the machine or the
estimator is slow. This is not part of `make bench`.
"""

import sys
import time

import numpy as np
from spread import number, ratios, spread, text

from workbench.estimation import ekf, ekf_state
from workbench.estimation.estimators import checked_update, find_estimator
from workbench.estimation.samples import (
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLE_ARRAY_SIZE,
    Mounting,
)
from workbench.estimation.settings import EKF, ESTIMATORS

UPDATES, TURNS = 500, 15
PERIOD = 1 / 128
ASKED = 500e-6
"""Of the EKF with all sensors [s]."""
MOUNTING = Mounting(p_BG=(0.0, 0.0, 0.1), p_BP=(0.0, 0.02, 0.0), p_BR=(0.0, 0.0, -0.1))


def main() -> int:
    """Print a line for each estimator and amount of samples; 1 if the EKF is too slow."""
    state = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, *[0.0] * 6])
    predicting = np.zeros(SAMPLE_ARRAY_SIZE)
    predicting[5] = 9.81
    hearing = predicting.copy()
    hearing[[GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER]] = 1.0
    hearing[[GPS + 4, BAROMETER + 1, RANGE_FINDER + 1]] = 3.1, 3.0, 2.9
    hearing[MAGNETOMETER + 1 : MAGNETOMETER + 4] = MOUNTING.m_W
    found = [each for each in map(find_estimator, ESTIMATORS) if each]
    work = {
        (each.name, said): (each, z)
        for each in found
        for said, z in (("IMU alone", predicting), ("all sensors", hearing))
    }
    taken: dict[tuple[str, str], list[float]] = {key: [] for key in work}
    reference = []
    F = np.eye(ekf_state.ERRORS) + 1e-3
    for turn in range(TURNS + 1):  # the first warms up
        begun = time.process_time()
        for _ in range(UPDATES):
            F @ F @ F.T
        if turn:
            reference.append((time.process_time() - begun) / UPDATES)
        for key, (estimator, z) in work.items():
            memory = estimator.begin(
                state, MOUNTING, np.zeros(ekf_state.ERRORS), ekf.InitialDeviations()
            )
            settings, mounting = np.array(estimator.settings()), MOUNTING.packed()
            update = checked_update(estimator)
            update(memory, z, settings, mounting, PERIOD)
            begun = time.process_time()
            for _ in range(UPDATES):
                update(memory, z, settings, mounting, PERIOD)
            if turn:
                taken[key].append((time.process_time() - begun) / UPDATES)
    said = "F P F' of numpy"
    print(f"{said:27} {text(spread([1e6 * each for each in reference])):>24} us")
    for (name, said), times in taken.items():
        micros = text(spread([1e6 * each for each in times]))
        print(f"{name:14} {said:12} {micros:>24} us, {text(ratios(times, reference))} of that")
    worst = float(np.median(taken[EKF, "all sensors"]))
    print(f"asked for of the EKF with all sensors are {number(1e6 * ASKED)} us")
    return 0 if worst <= ASKED else 1


if __name__ == "__main__":
    sys.exit(main())
