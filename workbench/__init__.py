"""A Drake-based workbench for designing a multirotor and its controller.

The public names are loaded on first use, so that `import workbench` stays free of
Drake, Qt and matplotlib.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workbench.common.errors import WorkbenchError
    from workbench.common.resources import find_model, find_scenario
    from workbench.design.block_graph import read_block_graph
    from workbench.design.branches import Branch
    from workbench.design.fork import fly_fork
    from workbench.design.judge.live import live_margins
    from workbench.design.judge.loop_judgement import judge_loops
    from workbench.design.judge.margins import LoopMargins, loop_margins
    from workbench.design.judge.operating_map import operating_map
    from workbench.design.judge.plots_loop import plot_loop, plot_loops
    from workbench.design.judge.plots_map import plot_map, plot_rates, plot_sensitivity
    from workbench.design.judge.report import Judgement, judge
    from workbench.design.judge.sampled_stability import slowest_rate
    from workbench.design.judge.sensitivity import step_sensitivity
    from workbench.design.judge.step_pair import linear_step
    from workbench.design.lidar_trial import fly_trial
    from workbench.design.linear.linearize import linearize
    from workbench.design.linear.loops import find_loop
    from workbench.design.linear.model import LinearModel
    from workbench.design.linear.operating_point import OperatingPoint
    from workbench.design.linear.study import LinearStudy
    from workbench.design.plots import STYLE
    from workbench.design.plots_flight import plot_flight
    from workbench.design.plots_lidar import plot_trial
    from workbench.design.regress.flight import Changes
    from workbench.design.regress.junit import junit_xml
    from workbench.design.regress.loading import load_spec
    from workbench.design.regress.page import results_page
    from workbench.design.regress.plots import plot_curve
    from workbench.design.regress.running import record, regress
    from workbench.design.rollout.agreement import agreement, random_trials
    from workbench.design.rollout.engine import RolloutEngine
    from workbench.design.rollout.metrics import rollout_metrics
    from workbench.design.step_response import StepResponse, fly_step
    from workbench.design.sweep.best import prove_best
    from workbench.design.sweep.gain_map import gain_map
    from workbench.design.sweep.plot_sweep import plot_sweep
    from workbench.design.sweep.ranges import SweepRange
    from workbench.design.sweep.sweep import sweep
    from workbench.design.sweep.table import SweepTable
    from workbench.design.tune.picture import plot_tuning
    from workbench.design.tune.tuner import Tuner, tune
    from workbench.design.tune.wish_file import load_wishes, wishes_for
    from workbench.diagram.core import make_flight_core
    from workbench.diagram.workbench import make_workbench
    from workbench.gains.difference import diff_gains
    from workbench.gains.gains import (
        GainFile,
        flight_gains,
        gains_at,
        load_gains,
        make_profile,
        rule_values,
        save_gains,
    )
    from workbench.gains.rule import CONTROL_DELAY, slowest_rotor
    from workbench.live.flight import LiveFlight
    from workbench.plant.gravity import GRAVITY
    from workbench.plant.loading import load_vehicle
    from workbench.plant.rotors import wrench_matrix
    from workbench.plant.variation import Variation
    from workbench.plant.vehicle import Vehicle
    from workbench.scenario.excitation import Excitation, Shape
    from workbench.scenario.scenario import Scenario, SensorsConfig, VehicleConfig, load_scenario
    from workbench.session.session import Session

_HOME = {
    "Branch": "workbench.design.branches",
    "CONTROL_DELAY": "workbench.gains.rule",
    "Changes": "workbench.design.regress.flight",
    "Excitation": "workbench.scenario.excitation",
    "GRAVITY": "workbench.plant.gravity",
    "GainFile": "workbench.gains.gains",
    "Judgement": "workbench.design.judge.report",
    "LinearModel": "workbench.design.linear.model",
    "LinearStudy": "workbench.design.linear.study",
    "LiveFlight": "workbench.live.flight",
    "LoopMargins": "workbench.design.judge.margins",
    "OperatingPoint": "workbench.design.linear.operating_point",
    "RolloutEngine": "workbench.design.rollout.engine",
    "STYLE": "workbench.design.plots",
    "Scenario": "workbench.scenario.scenario",
    "SensorsConfig": "workbench.scenario.scenario",
    "Session": "workbench.session.session",
    "Shape": "workbench.scenario.excitation",
    "StepResponse": "workbench.design.step_response",
    "SweepRange": "workbench.design.sweep.ranges",
    "SweepTable": "workbench.design.sweep.table",
    "Tuner": "workbench.design.tune.tuner",
    "Variation": "workbench.plant.variation",
    "Vehicle": "workbench.plant.vehicle",
    "VehicleConfig": "workbench.scenario.scenario",
    "WorkbenchError": "workbench.common.errors",
    "agreement": "workbench.design.rollout.agreement",
    "diff_gains": "workbench.gains.difference",
    "find_loop": "workbench.design.linear.loops",
    "find_model": "workbench.common.resources",
    "find_scenario": "workbench.common.resources",
    "flight_gains": "workbench.gains.gains",
    "fly_fork": "workbench.design.fork",
    "fly_step": "workbench.design.step_response",
    "fly_trial": "workbench.design.lidar_trial",
    "gain_map": "workbench.design.sweep.gain_map",
    "gains_at": "workbench.gains.gains",
    "judge": "workbench.design.judge.report",
    "judge_loops": "workbench.design.judge.loop_judgement",
    "junit_xml": "workbench.design.regress.junit",
    "linear_step": "workbench.design.judge.step_pair",
    "linearize": "workbench.design.linear.linearize",
    "live_margins": "workbench.design.judge.live",
    "load_gains": "workbench.gains.gains",
    "load_scenario": "workbench.scenario.scenario",
    "load_spec": "workbench.design.regress.loading",
    "load_vehicle": "workbench.plant.loading",
    "load_wishes": "workbench.design.tune.wish_file",
    "loop_margins": "workbench.design.judge.margins",
    "make_flight_core": "workbench.diagram.core",
    "make_profile": "workbench.gains.gains",
    "make_workbench": "workbench.diagram.workbench",
    "operating_map": "workbench.design.judge.operating_map",
    "plot_curve": "workbench.design.regress.plots",
    "plot_flight": "workbench.design.plots_flight",
    "plot_loop": "workbench.design.judge.plots_loop",
    "plot_loops": "workbench.design.judge.plots_loop",
    "plot_map": "workbench.design.judge.plots_map",
    "plot_rates": "workbench.design.judge.plots_map",
    "plot_sensitivity": "workbench.design.judge.plots_map",
    "plot_sweep": "workbench.design.sweep.plot_sweep",
    "plot_trial": "workbench.design.plots_lidar",
    "plot_tuning": "workbench.design.tune.picture",
    "prove_best": "workbench.design.sweep.best",
    "random_trials": "workbench.design.rollout.agreement",
    "read_block_graph": "workbench.design.block_graph",
    "record": "workbench.design.regress.running",
    "regress": "workbench.design.regress.running",
    "results_page": "workbench.design.regress.page",
    "rollout_metrics": "workbench.design.rollout.metrics",
    "rule_values": "workbench.gains.gains",
    "save_gains": "workbench.gains.gains",
    "slowest_rate": "workbench.design.judge.sampled_stability",
    "slowest_rotor": "workbench.gains.rule",
    "step_sensitivity": "workbench.design.judge.sensitivity",
    "sweep": "workbench.design.sweep.sweep",
    "tune": "workbench.design.tune.tuner",
    "wishes_for": "workbench.design.tune.wish_file",
    "wrench_matrix": "workbench.plant.rotors",
}

__all__ = [
    "Branch",
    "CONTROL_DELAY",
    "Changes",
    "Excitation",
    "GRAVITY",
    "GainFile",
    "Judgement",
    "LinearModel",
    "LinearStudy",
    "LiveFlight",
    "LoopMargins",
    "OperatingPoint",
    "RolloutEngine",
    "STYLE",
    "Scenario",
    "SensorsConfig",
    "Session",
    "Shape",
    "StepResponse",
    "SweepRange",
    "SweepTable",
    "Tuner",
    "Variation",
    "Vehicle",
    "VehicleConfig",
    "WorkbenchError",
    "agreement",
    "diff_gains",
    "find_loop",
    "find_model",
    "find_scenario",
    "flight_gains",
    "fly_fork",
    "fly_step",
    "fly_trial",
    "gain_map",
    "gains_at",
    "judge",
    "judge_loops",
    "junit_xml",
    "linear_step",
    "linearize",
    "live_margins",
    "load_gains",
    "load_scenario",
    "load_spec",
    "load_vehicle",
    "load_wishes",
    "loop_margins",
    "make_flight_core",
    "make_profile",
    "make_workbench",
    "operating_map",
    "plot_curve",
    "plot_flight",
    "plot_loop",
    "plot_loops",
    "plot_map",
    "plot_rates",
    "plot_sensitivity",
    "plot_sweep",
    "plot_trial",
    "plot_tuning",
    "prove_best",
    "random_trials",
    "read_block_graph",
    "record",
    "regress",
    "results_page",
    "rollout_metrics",
    "rule_values",
    "save_gains",
    "slowest_rate",
    "slowest_rotor",
    "step_sensitivity",
    "sweep",
    "tune",
    "wishes_for",
    "wrench_matrix",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'workbench' has no attribute '{name}'")
    return getattr(import_module(_HOME[name]), name)
