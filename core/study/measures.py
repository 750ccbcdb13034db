"""Measures of a study: every quantity of :mod:`core.evaluation` that is one number, by name."""

from dataclasses import dataclass, field

from .. import wording
from ..errors import EvaluationError, StudyError
from ..report.quantity import Options, Quantity
from ..report.topics import TOPICS
from .ground_quantities import GROUND_QUANTITIES
from .subject import Subject, WholeGround

QUANTITIES: dict[str, Quantity] = {
    **GROUND_QUANTITIES,
    **{name: quantity for topic in TOPICS for name, quantity in topic.quantities.items()},
}


@dataclass(frozen=True)
class Measure:
    """A quantity that a study asks for.

    Attributes
    ----------
    name : str
        Of its column.
    quantity : str
        Key of ``QUANTITIES``.
    options : mapping
    """

    name: str
    quantity: str
    options: Options = field(default_factory=dict)

    @property
    def column(self) -> str:
        """The name with its unit."""
        unit = QUANTITIES[self.quantity].unit
        return f"{self.name} ({unit})" if unit else self.name


def measured(measure: Measure, subject: Subject) -> float:
    """Return the number; EvaluationError and others of our own if the question has no answer."""
    quantity = QUANTITIES[measure.quantity]
    if quantity.find is None:
        return quantity.number(subject)
    if not isinstance(subject, WholeGround):
        raise EvaluationError("cannot be measured on a ground in parcels; leave parcel_size out, or the measure.")
    own = {name: value for name, value in measure.options.items() if name in quantity.own}
    shared = {name: value for name, value in measure.options.items() if name not in quantity.own}
    return quantity.number(subject.once(quantity.find, shared), **own)


def checked_measure(entry: object) -> Measure:
    """Read a measure of a study file: a name, or a table with ``measure``, perhaps ``name``, and options.

    Raises StudyError if there is no such measure or option, or if options would be ignored.
    """
    table = {"measure": entry} if isinstance(entry, str) else dict(entry) if isinstance(entry, dict) else {}
    wanted = table.pop("measure", None)
    if not isinstance(wanted, str) or wanted not in QUANTITIES:
        raise StudyError(f"There is no measure {wording.quoted(wanted)}; there are {', '.join(QUANTITIES)}.")
    name = str(table.pop("name", wanted))
    quantity = QUANTITIES[wanted]
    for option, value in table.items():
        if option not in quantity.options:
            said = f"it has {', '.join(quantity.options)}" if quantity.options else "it has none"
            raise StudyError(f"The measure '{wanted}' has no option {wording.quoted(option)}; {said}.")
        if not quantity.options[option].fits(value):
            said = quantity.options[option].meaning
            raise StudyError(
                f"The option '{option}' of the measure '{wanted}' cannot be {wording.quoted(value)}; it is {said}."
            )
    if quantity.one_of and sum(option in table for option in quantity.one_of) != 1:
        raise StudyError(f"The measure '{wanted}' needs one of its options {', '.join(quantity.one_of)}.")
    rivals = [option for option in quantity.at_most_one if option in table]
    if len(rivals) > 1:
        raise StudyError(f"The measure '{wanted}' takes one of its options {', '.join(rivals)}; leave the others out.")
    for option, other in quantity.details.items():
        if option in table and other not in table:
            raise StudyError(
                f"The option '{option}' of the measure '{wanted}' says nothing without '{other}'; add that."
            )
    return Measure(name, wanted, table)
