"""Sensors that are late, stuck or the wrong way round."""

from __future__ import annotations

from controller.ports import Reading
from sim.sensor_faults import SensorFaults

from .stage import Stage

READY = Reading(gaze=True, pressure=True, location=True)
AWAY = Reading(gaze=False, pressure=False, location=False)


def test_stuck_sensors_say_what_they_said_last_until_their_time_is_over() -> None:
    faults = SensorFaults(stuck_until_s=5.0)
    assert [faults.applied(each, 4.0) for each in (READY, AWAY)] == [READY, READY]
    assert faults.applied(AWAY, 5.0) == AWAY


def test_a_late_reading_is_heard_with_what_was_measured_and_not_by_those_who_have_gone() -> None:
    with Stage() as stage:
        sensors = stage.sensors()
        heard: list[tuple[float, Reading | None]] = []

        def listen(patience_s: float) -> None:
            sensors.faults.late_s = 3.0
            readings = stage.bus.port("robot").subscribe(Reading)
            heard.append((stage.kernel.now_s, readings.wait(patience_s)))
            readings.close()
            stage.kernel.sleep(5.0)

        def body() -> None:
            listen(2.0)
            listen(4.0)

        stage.run(body)
        times = [message.time_s for message in stage.recorder.messages if message.topic == "reading"]
    assert [reading is None for _, reading in heard] == [True, False]
    assert times[0] == heard[1][0] + 3.0
