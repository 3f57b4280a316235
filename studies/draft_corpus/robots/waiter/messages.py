"""Messages of the restaurant's bus."""

from typing import Annotated, Literal, Union

from pydantic import BaseModel, Field, TypeAdapter


class Order(BaseModel):
    kind: Literal["order"] = "order"
    table: int = Field(ge=1, le=12)
    dish: Literal["soup", "pasta", "salad"]
    guests: int = Field(default=1, ge=1, le=4)


class DishReady(BaseModel):
    kind: Literal["dish_ready"] = "dish_ready"
    table: int
    weight_g: float


class GuestWaves(BaseModel):
    kind: Literal["guest_waves"] = "guest_waves"
    table: int
    hand: Literal["left", "right"] = "right"


class TrayWeight(BaseModel):
    kind: Literal["tray_weight"] = "tray_weight"
    grams: float


class Help(BaseModel):
    kind: Literal["help"] = "help"
    text: str


Incoming = Annotated[Union[Order, DishReady, GuestWaves, TrayWeight, Help], Field(discriminator="kind")]
INCOMING = TypeAdapter(Incoming)


class Say(BaseModel):
    table: int
    text: str


class Status(BaseModel):
    phase: str
    table: int | None = None
