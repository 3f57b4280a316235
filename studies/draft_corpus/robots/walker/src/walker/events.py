from __future__ import annotations

from typing import Annotated, Literal, TypedDict, Union

from pydantic import BaseModel, Field, TypeAdapter


class GripChanged(BaseModel):
    type: Literal["grip"] = "grip"
    left: bool
    right: bool


class TiltMeasured(BaseModel):
    type: Literal["tilt"] = "tilt"
    degrees: float = Field(ge=-90, le=90)


class ButtonPressed(BaseModel):
    type: Literal["button"] = "button"
    button: Literal["lock", "unlock", "sos"]


class ObstacleSeen(BaseModel):
    type: Literal["obstacle"] = "obstacle"
    distance_m: float = Field(gt=0)
    kind: str = "thing"


Event = Annotated[Union[GripChanged, TiltMeasured, ButtonPressed, ObstacleSeen], Field(discriminator="type")]
EVENTS: TypeAdapter[Event] = TypeAdapter(Event)


class BrakeCommand(TypedDict):
    action: Literal["brake", "release", "slow"]
    strength: float


class Alarm(TypedDict):
    action: Literal["alarm"]
    reason: str


Command = Union[BrakeCommand, Alarm]
