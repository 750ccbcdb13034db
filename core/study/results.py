"""The results of a study as one table."""

from ..report.table import Table, table
from ..wording import counted
from .plan import Case, shown
from .run import StudyOutcome


def results_table(outcome: StudyOutcome) -> Table:
    """Build a row for each case: scene, clips, settings that the study names, measures, seconds, what went wrong.

    Settings that make no difference to a case are empty.
    """
    plan = outcome.plan
    names = list(plan.settings)
    if any(source.parcel_size for source in plan.scenes) and "parcel_size" not in names:
        names.append("parcel_size")
    columns = ["scene", "clips", *names, *(m.column for m in plan.measures), "seconds", "problem"]
    rows = []
    for entry in outcome.outcomes:
        values = [_value(entry.case, name) for name in names]
        result = entry.result
        numbers = [None if result is None else result.numbers.get(m.name) for m in plan.measures]
        seconds = None if result is None else round(result.seconds, 3)
        problem = entry.problem if result is None else "; ".join(remark.rstrip(".") for remark in result.remarks)
        rows.append([entry.case.scene, entry.case.clips, *values, *numbers, seconds, problem or None])
    return table(columns, rows)


def _value(case: Case, name: str):
    value = case.values.get(name)
    return shown(name, value) if name == "k" and value is not None else value


def failures(outcome: StudyOutcome) -> list[str]:
    """Return a sentence for each reason why cases failed, with the cases."""
    labels: dict[str, list[str]] = {}
    for entry in outcome.outcomes:
        if entry.result is None:
            labels.setdefault(entry.problem, []).append(entry.case.label(outcome.plan.varied))
    return [f"{_some(cases)}: {problem}" for problem, cases in labels.items()]


def _some(cases: list[str]) -> str:
    """Name the first of some cases, and the number of others."""
    rest = len(cases) - 1
    return cases[0] + (f" and {counted(rest, 'more case')}" if rest else "")
