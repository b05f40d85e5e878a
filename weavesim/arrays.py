"""Types for array fields: converted to one data type, copied, read-only, and bit-exact in JSON."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

# In JSON, arrays of up to this many numbers are lists, longer ones base64 bytes.
LONGEST_LIST = 32


def frozen(array: np.ndarray) -> np.ndarray:
    """A copy of ``array`` on immutable bytes: unlike a flag, they cannot be made writable again."""
    return np.ndarray(array.shape, array.dtype, buffer=array.tobytes())


class _ArrayType:
    """Annotation of a NumPy array as a field: converted to one data type, copied, read-only."""

    def __init__(self, name: str) -> None:
        self.dtype = np.dtype(name)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            self._checked,
            serialization=core_schema.plain_serializer_function_ser_schema(self._for_json, when_used="json"),
        )

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        packed = {
            "type": "object",
            "description": f"{self.dtype.name} in C order, little-endian",
            "properties": {
                "shape": {"type": "array", "items": {"type": "integer", "minimum": 0}},
                "base64": {"type": "string", "contentEncoding": "base64"},
            },
            "required": ["shape", "base64"],
            "additionalProperties": False,
        }
        return {"anyOf": [{"type": "array"}, packed]}

    def _checked(self, value: Any) -> np.ndarray:
        if isinstance(value, Mapping):
            array = self._unpacked(value)
        else:
            try:
                given = np.asarray(value)
            except ValueError:
                raise ValueError(f"an array of {self.dtype.name} is needed, with rows of equal length") from None
            kinds = {"f": "iuf", "i": "iu", "b": "b"}[self.dtype.kind]
            if given.size and given.dtype.kind not in kinds:
                raise ValueError(f"an array of {self.dtype.name} is needed, not {given.dtype}")
            array = np.array(given, dtype=self.dtype, order="C")
            if self.dtype.kind == "i" and not np.array_equal(array, given):
                raise ValueError(f"numbers out of range of {self.dtype.name}")
        return frozen(array)

    def _unpacked(self, value: Mapping[str, Any]) -> np.ndarray:
        try:
            content, shape = base64.b64decode(value["base64"], validate=True), tuple(value["shape"])
            return np.frombuffer(content, dtype=self.dtype.newbyteorder("<")).astype(self.dtype).reshape(shape)
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"not an array of {self.dtype.name} in base64 with its shape ({error})") from None

    def _for_json(self, array: np.ndarray) -> Any:
        if array.ndim == 1 and array.size <= LONGEST_LIST and np.all(np.isfinite(array)):
            return array.tolist()
        content = np.ascontiguousarray(array, dtype=self.dtype.newbyteorder("<")).tobytes()
        return {"shape": list(array.shape), "base64": base64.b64encode(content).decode("ascii")}


FloatArray = Annotated[np.ndarray, _ArrayType("float64")]
IntArray = Annotated[np.ndarray, _ArrayType("int64")]
IndexArray = Annotated[np.ndarray, _ArrayType("int32")]
BoolArray = Annotated[np.ndarray, _ArrayType("bool")]
