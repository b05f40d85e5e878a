"""Immutable physical parameters, checked when they are made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from .errors import InputError

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class Parameters(BaseModel):
    """Immutable, checked parameters; a bad value raises InputError that names it."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)

    def __init__(self, **values):
        try:
            super().__init__(**values)
        except ValidationError as error:
            lines = {}
            for problem in error.errors():
                # a field that allows several types has one problem per type: the first says enough
                field, *rest = problem["loc"] or ("",)
                name = ".".join([str(field), *(str(part) for part in rest if isinstance(part, int))])
                message = problem["msg"].removeprefix("Value error, ")
                lines.setdefault(name, f"{name} = {problem['input']!r}: {message}" if name else message)
            raise InputError(f"{type(self).__name__}: " + "; ".join(lines.values())) from None

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy with some values changed, checked like a new one.

        Raises:
            InputError: a value that is not allowed.
        """
        return type(self)(**{**{name: getattr(self, name) for name in type(self).model_fields}, **(update or {})})
