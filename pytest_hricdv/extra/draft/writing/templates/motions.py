"""Classes for what moves of a drafted robot's devices, as text."""

DRIVE = '''

class Drive:
    """Where a base is that drives as it is told: x and y (m), and its heading (rad). TODO: how does yours drive?"""

    def __init__(self, world: World, name: str) -> None:
        self._world, self._name = world, name
        self._x = self._y = self._heading = self._forward = self._turn = 0.0
        self._since_s = self._recorded_s = world.now_s
        self._until_s = inf

    def go(self, forward: Any = 0.0, turn: Any = 0.0, *, in_degrees: bool = False) -> None:
        """From now on it drives so fast (m/s), and turns so fast (rad/s, or deg/s)."""
        self.pose()
        self._forward, self._turn = (float(v) if isinstance(v, int | float) else 0.0 for v in (forward, turn))
        self._turn *= tau / 360 if in_degrees else 1.0
        self._until_s = inf

    def pose(self) -> tuple[float, float, float]:
        """Where it is now: on an arc from where it was when it was told something else."""
        now_s = self._world.now_s
        passed_s = max(min(now_s, self._until_s) - self._since_s, 0.0)
        half, way = self._turn * passed_s / 2, self._forward * passed_s
        chord = way * (sin(half) / half if half else 1.0)
        self._x += chord * cos(self._heading + half)
        self._y += chord * sin(self._heading + half)
        self._heading = remainder(self._heading + 2 * half, tau)
        self._since_s = now_s
        if now_s - self._recorded_s >= RECORDS_EACH_S:
            self._recorded_s = now_s
            self._world.record(f"{self._name}_x", self._x)
            self._world.record(f"{self._name}_y", self._y)
        return self._x, self._y, self._heading
'''

WHEELS = '''
    def go_by_wheels(self, left: Any, right: Any) -> None:
        """From now on its wheels go so fast (m/s)."""
        if isinstance(left, int | float) and isinstance(right, int | float):
            self.go((left + right) / 2, (right - left) / TRACK_M)
'''

REACH = '''
    def go_to(self, x: Any, y: Any) -> None:
        """It turns at once, and is there (m) after MOVES_S."""
        if isinstance(x, int | float) and isinstance(y, int | float):
            self.pose()
            self._heading = atan2(y - self._y, x - self._x)
            self.go(hypot(y - self._y, x - self._x) / MOVES_S)
            self._until_s = self._since_s + MOVES_S
'''

MOVING = '''

class Moving:
    """A sensor that follows what its device is told: it takes MOVES_S to get there. TODO: how does yours move?"""

    def __init__(self, world: World, name: str, low: float, high: float) -> None:
        self._world, self._name, self._low, self._high = world, name, low, high
        self._from = self._to = float(world.senses[name])
        self._begin_s, self._speed = world.now_s, 0.0

    def go(self, target: Any) -> None:
        """From now on it goes to this number; not all the way where something is in its way."""
        if isinstance(target, int | float):
            self._from = self._at()
            self._to = self._from + (target - self._from) * self._world.ways.get(self._name, 1.0)
            self._begin_s, self._speed = self._world.now_s, 0.0

    def up(self) -> None:
        """It goes as far as it can."""
        self.go(self._high)

    def down(self) -> None:
        """It goes back again."""
        self.go(self._low)

    def switch(self, is_up: Any) -> None:
        """It goes as far as it can, or back again."""
        self.go(self._high if is_up else self._low)

    def speed(self, speed: Any = 0.0) -> None:
        """From now on it changes by so much in a second."""
        if isinstance(speed, int | float):
            self._from = self._to = self._at()
            self._begin_s, self._speed = self._world.now_s, float(speed)

    def _at(self) -> float:
        passed_s = self._world.now_s - self._begin_s
        return self._from + (self._to - self._from) * min(passed_s / MOVES_S, 1.0) + self._speed * passed_s

    def now(self) -> float:
        """What the sensor says now."""
        value = self._at()
        said = value > 0.5 if isinstance(self._world.senses[self._name], bool) else value
        if said != self._world.senses[self._name]:
            self._world.sense(self._name, said)
        return said
'''
