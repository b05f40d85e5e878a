"""What a calibration is given: files of tests, dimensions of specimens and frames, and choices."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from ..checks import NotNegative, Parameters, Positive
from ..fabric.file import FABRIC_HELP
from ..ranges import Quantity

TESTS = ("biaxial", "picture_frame", "bias_extension", "cantilever", "bending_length", "bending_length_weft")
# The authors of the round robin trust angles computed from the crosshead up to about 30 degrees in bias extension.
TRUSTED_BIAS_ANGLE = 35.0

Paths = tuple[Path, ...]


class CalibrationOptions(Parameters):
    """Options of ``weavesim calibrate``; every field becomes a command-line option.

    Every test may be given several times: each file, and each specimen in it, is a repeat.
    """

    fabric: str = Field(
        description=f"what is known already, and where fits start: {FABRIC_HELP}",
    )
    biaxial: Paths = Field(default=(), description="CSV: strains and forces of warp and weft")
    picture_frame: Paths = Field(default=(), description="CSV: shear angle (or displacement) and force of a frame")
    bias_extension: Paths = Field(default=(), description="CSV: displacement and force of a strip pulled at 45 degrees")
    cantilever: Paths = Field(default=(), description="CSV: overhangs, a row per specimen, and their chord angles")
    bending_length: tuple[Annotated[Positive, Quantity("length", at_most=2.0)], ...] = Field(
        default=(), description="Peirce's bending length of a specimen, half the overhang at 41.5 degrees [m]"
    )
    bending_length_weft: tuple[Annotated[Positive, Quantity("length", at_most=2.0)], ...] = Field(
        default=(), description="that of the weft, if it differs from the warp's [m]"
    )
    frame_side: Annotated[Positive, Quantity("frame side", at_most=2.0)] | None = Field(
        default=None, description="distance between the hinges of the picture frame [m]"
    )
    fabric_side: Annotated[Positive, Quantity("frame side", at_most=2.0)] | None = Field(
        default=None, description="side of the sheared square of fabric [m] [default: that of the frame]"
    )
    frame_convention: Literal["fabric area", "frame side"] = Field(
        default="fabric area",
        description='of forces per length, as MomentCurve.from_normalised_force: "fabric area" or "frame side"',
    )
    bias_length: Annotated[Positive, Quantity("length", at_most=2.0)] | None = Field(
        default=None, description="length of the bias-extension strip between the clamps [m]"
    )
    bias_width: Annotated[Positive, Quantity("length", at_most=1.0)] | None = Field(
        default=None, description="width of the strip [m]"
    )
    bias_largest_angle: Annotated[Positive, Quantity("angle")] = Field(
        default=TRUSTED_BIAS_ANGLE, lt=80.0,
        description="rows of the bias extension beyond this kinematic angle are left out: yarns slip [degrees]",
    )  # fmt: skip
    frame_largest_angle: Annotated[Positive, Quantity("angle")] = Field(
        default=79.0, lt=80.0, description="rows of the picture frame beyond this angle are left out [degrees]"
    )
    biaxial_width: Annotated[Positive, Quantity("length", at_most=1.0)] | None = Field(
        default=None, description="width over which each force of the biaxial test acts, if forces are in N [m]"
    )
    cantilever_yarn: Literal["both", "warp", "weft"] = Field(
        default="both", description="yarns along the strips of the cantilever whose column does not say it"
    )
    preload: Annotated[Positive, Quantity("force")] | None = Field(
        default=None, description="force at which displacements are set to zero; rows before are slack [N]"
    )
    offset: Literal["ask", "subtract", "keep"] = Field(
        default="ask",
        description="a force at zero angle or displacement: subtract it (the machine's zero), or keep it (friction); "
        '"ask" subtracts what is small and refuses the rest',
    )
    noise: Annotated[Positive, Field(lt=0.5)] | None = Field(
        default=None,
        description="standard deviation of a single test, as a share of its largest value [default: from its points]",
    )
    knots: int = Field(default=10, ge=2, le=40, description="angles at which the shear curve is fitted")
    friction: Literal["auto", "none"] = Field(
        default="auto",
        description='"auto": from the loop if unloading is measured, else the initial jump, which is an assumption; '
        '"none": all of the shear moment is elastic',
    )
    fit: tuple[str, ...] = Field(
        default=(), description="parameters of the unit cell to fit [default: those that the data can tell apart]"
    )
    full: bool = Field(
        default=False, description="keep parameters that the data cannot tell apart, instead of a reduced set"
    )
    families: Literal["auto", "shared", "separate"] = Field(
        default="auto",
        description='one value for warp and weft, or two; "auto": one if they are equal in the given fabric',
    )
    held_uncertainty: NotNegative = Field(
        default=0.0, lt=1.0,
        description="standard deviation of values that are held, as a share of them; widens the intervals of the rest",
    )  # fmt: skip
    starts: int = Field(default=8, ge=1, le=200, description="starting points of the fit of the unit cell")
    seed: int = Field(default=0, ge=0, description="of the starting points")
    column: tuple[str, ...] = Field(
        default=(), description='a column by another name, as "force=Standardkraft"; may be repeated'
    )
    name: str | None = Field(default=None, description="name of the calibrated fabric")
    accept_unusual: bool = Field(default=False, description="take unusual values and measurements as meant")

    @field_validator("biaxial", "picture_frame", "bias_extension", "cantilever", mode="before")
    @classmethod
    def _one_or_several(cls, value: object) -> object:
        return (Path(value),) if isinstance(value, str | Path) else value

    @field_validator("bending_length", "bending_length_weft", mode="before")
    @classmethod
    def _one_length(cls, value: object) -> object:
        return (value,) if isinstance(value, int | float) and not isinstance(value, bool) else value

    @field_validator("fit", "column", mode="before")
    @classmethod
    def _names(cls, value: object) -> object:
        return (value,) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _has_tests(self) -> Self:
        if not any(getattr(self, test) for test in TESTS):
            raise ValueError(f"nothing to calibrate with: give at least one of {', '.join(TESTS)}")
        if self.bias_extension and (self.bias_length is None or self.bias_width is None):
            raise ValueError("bias_extension needs the strip: give bias_length and bias_width [m]")
        if self.bias_length and self.bias_width and self.bias_length < 2.0 * self.bias_width * (1.0 - 1.0e-9):
            raise ValueError(
                f"bias_length = {self.bias_length} m and bias_width = {self.bias_width} m: the length must be at least "
                "twice the width, or no zone shears fully"
            )
        if self.fabric_side and self.frame_side and self.fabric_side > self.frame_side:
            raise ValueError(f"fabric_side = {self.fabric_side} m: must not exceed frame_side = {self.frame_side} m")
        if self.bending_length_weft and not (self.bending_length or self.cantilever):
            raise ValueError("bending_length_weft needs bending_length, that of the warp")
        return self

    def column_names(self) -> dict[str, str]:
        """Names of columns by role, from ``column``.

        Raises:
            ValueError: an entry that is not ROLE=NAME.
        """
        result = {}
        for item in self.column:
            role, equal, name = item.partition("=")
            if not equal or not role.strip() or not name.strip():
                raise ValueError(f"column = {item!r}: write ROLE=NAME, such as force=Standardkraft")
            result[role.strip()] = name.strip()
        return result
