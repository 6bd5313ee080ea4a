"""Options that belong together are one parameter of a command.

A command takes a dataclass whose fields are declared as typer wants options; typer is shown one
parameter per field.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields
from inspect import Parameter, Signature, signature
from typing import Any, get_type_hints


@dataclass(frozen=True)
class OptionGroup:
    """Options of a terminal, and what becomes of them.

    Parameters
    ----------
    options : as typer reads them
    collected : makes the command's parameter of their values by name
    """

    options: tuple[Parameter, ...]
    collected: Callable[[Mapping[str, Any]], Any]


def option(name: str, kind: Any, default: Any = Parameter.empty) -> Parameter:
    """Return one option; `kind` is annotated as typer wants it."""
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=kind)


def fields_group(group: type[Any]) -> OptionGroup:
    """Return the group of a dataclass: an option per field."""
    kinds = get_type_hints(group, include_extras=True)
    options = tuple(
        option(
            field.name,
            kinds[field.name],
            Parameter.empty if field.default is MISSING else field.default,
        )
        for field in fields(group)
    )
    return OptionGroup(options, lambda values: group(**values))


def grouped(**groups: OptionGroup) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Show typer the options of groups in place of a command's parameters of these names."""

    def replaced(command: Callable[..., None]) -> Callable[..., None]:
        kinds = get_type_hints(command, include_extras=True)
        shown: list[Parameter] = []
        for name, parameter in signature(command).parameters.items():
            own = (option(name, kinds[name], parameter.default),)
            shown += groups[name].options if name in groups else own

        def called(**given: Any) -> None:
            collected = {
                name: group.collected({each.name: given.pop(each.name) for each in group.options})
                for name, group in groups.items()
            }
            command(**collected, **given)

        called.__name__, called.__doc__ = command.__name__, command.__doc__
        called.__module__ = command.__module__
        called.__annotations__ = {each.name: each.annotation for each in shown}
        called.__signature__ = Signature(shown)  # type: ignore[attr-defined]
        return called

    return replaced
