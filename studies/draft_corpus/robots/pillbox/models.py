"""What the ward's server and the pill box say to each other."""

from datetime import timedelta
from enum import Enum

from pydantic import BaseModel, Field


class Urgency(str, Enum):
    ROUTINE = "routine"
    SOON = "soon"
    NOW = "now"


class Dose(BaseModel):
    patient: str
    pills: int = Field(ge=1, le=8)
    urgency: Urgency = Urgency.ROUTINE


class Scan(BaseModel):
    wristband: str


class Drawer(BaseModel):
    position: str  # "open" or "shut"


class Cancel(BaseModel):
    reason: str = ""


class Event(BaseModel):
    name: str
    detail: str = ""


GRACE = timedelta(seconds=20)
