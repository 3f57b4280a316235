"""A reading lamp on an arm that follows wishes from a broker of MQTT."""

import json
import logging
import time

import paho.mqtt.client as mqtt

LOG = logging.getLogger("lamp")
PREFIX = "lamp/desk1"
POSES = {"book": (0.4, 0.2), "face": (0.1, 0.8), "rest": (0.0, 0.0)}


class LampArm:
    def __init__(self, motors, host="localhost"):
        self.motors = motors
        self.brightness = 0
        self.state = "off"
        self.client = mqtt.Client()
        self.client.on_connect = self.on_connect
        self.client.on_message = self.on_message
        self.client.connect(host, 1883)

    def on_connect(self, client, userdata, flags, rc):
        if rc != 0:
            LOG.error("refused: %s", rc)
            return
        client.subscribe(PREFIX + "/light")
        client.subscribe(PREFIX + "/pose")
        client.subscribe(PREFIX + "/gesture")

    def on_message(self, client, userdata, msg):
        if msg.topic == PREFIX + "/light":
            self.set_light(int(msg.payload.decode()))
        elif msg.topic == PREFIX + "/pose":
            wish = json.loads(msg.payload)
            self.set_pose(wish["name"], wish.get("speed", 0.5))
        elif msg.topic == PREFIX + "/gesture":
            self.gesture(msg.payload.decode())
        self.client.publish(PREFIX + "/state", json.dumps({"state": self.state, "brightness": self.brightness}))

    def set_light(self, level):
        if not 0 <= level <= 100:
            return
        self.brightness = level
        self.state = "on" if level else "off"
        self.motors.pwm(level / 100)

    def set_pose(self, name, speed):
        if self.state == "off":
            LOG.info("it is dark, staying")
            return
        if name in POSES:
            self.state = "moving"
            self.motors.move(POSES[name], min(speed, 1.0))
            time.sleep(1.0)
            self.state = "on"

    def gesture(self, kind):
        if kind == "wave":
            self.set_light(100)
        elif kind == "point":
            self.set_pose("book", 1.0)
        elif kind == "fist":
            self.set_light(0)

    def run(self):
        self.client.loop_forever()


def main():
    from lamp.hardware import Motors

    LampArm(Motors()).run()
