import unittest

from walker.controller import Mode, WalkerController
from walker.events import ButtonPressed, GripChanged, ObstacleSeen, TiltMeasured


class ControllerTest(unittest.TestCase):
    def setUp(self):
        self.controller = WalkerController()

    def walk(self):
        self.controller.handle(ButtonPressed(button="unlock"))
        self.controller.handle(GripChanged(left=True, right=True))

    def test_walks_when_both_hands_grip(self):
        self.walk()
        self.assertIs(self.controller.mode, Mode.WALKING)

    def test_brakes_when_one_hand_lets_go(self):
        self.walk()
        commands = self.controller.handle(GripChanged(left=True, right=False))
        self.assertEqual(commands, [{"action": "brake", "strength": 0.5}])

    def test_slows_near_people(self):
        self.walk()
        commands = self.controller.handle(ObstacleSeen(distance_m=0.4, kind="person"))
        self.assertEqual(commands[0]["strength"], 0.9)

    def test_alarm_after_fall(self):
        commands = self.controller.handle(TiltMeasured(degrees=40))
        self.assertIn({"action": "alarm", "reason": "fall"}, commands)

    def test_lines(self):
        self.assertEqual(self.controller.feed('{"type": "button", "button": "sos"}')[0]["action"], "alarm")


if __name__ == "__main__":
    unittest.main()
