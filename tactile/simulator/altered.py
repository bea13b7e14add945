"""Values with other fields: fields and batches on their way through the effects."""

from typing import Any, TypeVar, cast

Value = TypeVar("Value")


def altered(value: Value, **changes: Any) -> Value:
    """The same frozen value with other fields: `dataclasses.replace` in a third of its time, for nothing is checked.

    Arguments: ``value`` of a dataclass that makes nothing of its fields; ``changes`` by the names of fields.

    Raises:
        TypeError: a field of another name.
    """
    names, given = type(value).__dataclass_fields__, value.__dict__  # type: ignore[attr-defined]  # of every dataclass
    made: Any = object.__new__(type(value))
    kept = made.__dict__
    for name in names:  # nothing that was computed from them
        kept[name] = given[name]
    kept.update(changes)
    if len(kept) != len(names):
        raise TypeError(f"{type(value).__name__} without {', '.join(sorted(kept.keys() - names.keys()))}")
    return cast(Value, made)
