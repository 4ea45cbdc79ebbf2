"""Finds gains for wishes, reports the search's progress, and pins the result as a regression."""

from workbench.analysis.queries import RegressionCase, Tune
from workbench.analysis.replies import Searched, Tuned
from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work, Working
from workbench.design.pin import pin_step
from workbench.design.tune.case import NOMINAL_CASE
from workbench.design.tune.tuner import Tuner
from workbench.design.tune.tuning import Tuning, TuningProgress
from workbench.design.tune.wish import wishes_for


def pin(subject: AnalysedVehicle, question: RegressionCase, work: Work) -> Working:
    """Write a spec and its baseline, and answer where they are; the regression passes."""
    step = question.step
    found = pin_step(
        question.path,
        subject.scenario,
        {**subject.vehicle_settings, **subject.flown_gains(question.gains)},
        step.axis,
        step.amplitude,
        duration=step.duration,
        acts=step.acts,
        margins=question.margins,
        overwrite=question.overwrite,
        progress=work.check,
    )
    loops = f" and the margins of {found.loops} loops" if found.loops else ""
    what = step.axis if step.is_load else f"along {step.axis}"
    said = (
        f"{found.limits} numbers and {found.curves} curves of a step {what}{loops} are pinned to "
        "the present values"
    )
    yield found.spec, found.baseline, said


def tune_gains(subject: AnalysedVehicle, question: Tune, work: Work) -> Working:
    """Answer which gains meet wishes, starting from given ones; a stop keeps the best so far."""
    tuner = Tuner(
        subject.flown_setup,
        wishes_for(*question.wishes, controller=subject.scenario.controller),
        settings=subject.flown_gains(question.gains),
        velocity=question.velocity,
    )
    work.on_stop(tuner.stop)
    found = tuner.run(lambda progress: work.tell(_search_progress(progress)))
    yield Tuned(
        before=found.before,
        gains=found.gains,
        met=found.met,
        stopped=found.stopped,
        wishes=tuple(
            (
                str(result.required),
                result.required.wish.metric.text(result.before),
                result.required.wish.metric.text(result.after),
                result.met,
            )
            for result in found.as_described
        ),
        steps={
            axis: (each.time, each.response[0], each.response[1])
            for (axis, case), each in found.responses.items()
            if case == NOMINAL_CASE
        },
        said=_unmet_text(found),
        widened=len(found.shortfalls),
    )


def _search_progress(progress: TuningProgress) -> Searched:
    if progress.best is None or progress.worst is None:
        return Searched(progress.phase, progress.share, {}, "")
    metric = progress.worst.wish.metric
    reserve = 100.0 * progress.best.reserve
    spare = f"{reserve:.0f} % to spare" if reserve >= 0.0 else f"{-reserve:.0f} % short"
    said = f"{progress.worst.wish.name} {metric.text(progress.value)}, {spare}"
    return Searched(progress.phase, progress.share, dict(progress.gains), said)


def _unmet_text(found: Tuning) -> tuple[str, ...]:
    """Return why wishes are not met, and further remarks."""
    said = [*map(str, found.conflicts), *found.shortfalls]
    if not found.met and not found.conflicts:
        said.append(_most_missed_wish(found))
    if found.proof:
        said += [
            f"flown on the full diagram, {required} is missed with "
            f"{required.wish.metric.text(value)}"
            for required, value in found.proof.missed
        ]
    worst = found.worst_corner
    if worst is not None:
        value = worst.required.wish.metric.text(worst.after)
        name = worst.required.wish.name
        said.append(f"the worst vehicle near it has {name} {value}: {worst.required.case}")
    for result in found.guarded:
        if result.after < result.before:
            metric = result.required.wish.metric
            fell = f"{metric.text(result.before)} to {metric.text(result.after)}"
            said.append(f"{result.required.wish.name}, about which there is no wish, falls: {fell}")
    return (*said, *found.remarks)


def _most_missed_wish(found: Tuning) -> str:
    """Return the wish that is missed by most, if any."""
    short = min(found.results, key=lambda result: result.reserve)
    value = short.required.wish.metric.text(short.after)
    if short.met:
        return "all wishes are met, but only in the quick flights"
    early = "stopped early; so far " if found.stopped else ""
    return f"{early}no gains that meet all wishes were found: {short.required} has {value}"
