"""Helps somebody to eat: spoon, mouth, pause. Everything comes by callbacks of the drivers."""

import threading

FULL = 3


class Feeder:

    def __init__(self, arm, face_tracker, buttons, buzzer):
        self._arm = arm
        self._buzzer = buzzer
        self._timer = None
        self._spoons = 0
        self.phase = 'rest'
        face_tracker.on_mouth(self._mouth)
        face_tracker.on_face_lost(self._lost)
        buttons.register('next', self._next)
        buttons.register('stop', self._stop)
        arm.on_force = self._force

    def _enter(self, phase):
        self.phase = phase
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _after(self, seconds, function):
        self._timer = threading.Timer(seconds, function)
        self._timer.start()

    def _next(self):
        if self.phase != 'rest':
            return
        if self._spoons >= FULL:
            self._buzzer.beep(3)
            return
        self._enter('scoop')
        self._arm.scoop()
        self._after(2.0, self._scooped)

    def _scooped(self):
        self._enter('wait')
        self._arm.move_near('mouth')
        self._after(15.0, self._give_up)

    def _mouth(self, opening, confidence):
        if confidence < 0.6:
            return
        if self.phase == 'wait' and opening > 0.3:
            self._enter('feed')
            self._arm.move_to('mouth')
            self._after(3.0, self._withdraw)
        elif self.phase == 'feed' and opening < 0.1:
            self._withdraw()

    def _withdraw(self):
        self._spoons += 1
        self._arm.retract()
        self._enter('rest')

    def _give_up(self):
        self._arm.retract()
        self._buzzer.beep(1)
        self._enter('rest')

    def _lost(self):
        if self.phase in ('wait', 'feed'):
            self._arm.retract()
            self._enter('rest')

    def _force(self, newton):
        if newton > 4.0:
            self._arm.freeze()
            self._enter('stopped')
            self._buzzer.beep(5)

    def _stop(self):
        if self.phase == 'stopped':
            self._arm.release()
            self._enter('rest')
        else:
            self._arm.freeze()
            self._enter('stopped')
