from unittest.mock import Mock

from feeder.feeder import Feeder


def make():
    arm, face, buttons, buzzer = Mock(), Mock(), Mock(), Mock()
    feeder = Feeder(arm, face, buttons, buzzer)
    return feeder, arm, face, buttons


def button(buttons, name):
    for call in buttons.register.call_args_list:
        if call.args[0] == name:
            call.args[1]()


def test_stop_and_release():
    feeder, arm, _, buttons = make()
    button(buttons, 'stop')
    arm.freeze.assert_called_once()
    assert feeder.phase == 'stopped'
    button(buttons, 'stop')
    assert feeder.phase == 'rest'


def test_force():
    feeder, arm, _, _ = make()
    arm.on_force(2.0)
    assert feeder.phase == 'rest'
    arm.on_force(6.0)
    assert feeder.phase == 'stopped'


def test_a_spoon():
    feeder, arm, face, buttons = make()
    button(buttons, 'next')
    assert feeder.phase == 'scoop'
    feeder._scooped()
    face.on_mouth.call_args.args[0](0.5, 0.9)
    assert feeder.phase == 'feed'
    face.on_mouth.call_args.args[0](0.05, 0.9)
    assert feeder.phase == 'rest'
    button(buttons, 'next')
    feeder._scooped()
    face.on_face_lost.call_args.args[0]()
    arm.retract.assert_called()
