"""A session in which nothing reaches the code under test fails, whatever its testbench is; others do not."""

from __future__ import annotations

import pytest

from tests.plugin.project import change, report
from tests.sampling import mostly_slow

UNREACHED = "FAILED nothing that people, sensors or the world did reached the code under test in any of 4 runs:*"

OWN_BUS = """
import queue, threading, time
from lamps.messages import Greeting, Wish

class OwnBus:
    queues = {}

    def subscribe(self, kind):
        return self.queues.setdefault(kind, queue.Queue())

class Guide:
    def __init__(self, *given):
        self.given = given
        self.bus = OwnBus()
        self.wishes = self.bus.subscribe(Wish)

    def run(self):
        while True:
            try:
                wish = self.wishes.get(timeout=0.5)
            except queue.Empty:
                self.step()
                continue

    def step(self):
        pass
"""

RUN = """
def run(run):
    import queue, threading
    import lamps.guide
    from lamps.guide import Guide
    from lamps.messages import Greeting, Wish
    from pytest_hricdv.testbench import Outcome

    class Kettle:
        heat = 1.0

        def read(self):
            return 1.0

    kettle, inbox, state, event = Kettle(), lamps.guide.queue.Queue(), {"level": 0.0}, threading.Event()
    port = run.bus.port("guide")

    def visitor():
        bus = run.bus.port("visitor")
        for action in run.actions():
            run.kernel.sleep(action.parameters.get("pause_s", 0.0))
            bus.publish(Greeting())
            level = float(len(action.command))
            bus.publish(Wish(level=level, cellar=False))
            PERSON
        run.kernel.sleep(2.0)
        run.kernel.stop("gone")

    def robot():
        guide = Guide(GIVEN)
        guide.run()

    run.recorder.signal(0.0, "lamp_level", 1.0)
    run.kernel.spawn("visitor", visitor)
    run.kernel.spawn("guide", run.measured(robot))
    return Outcome(run.go(LIMIT_S))
"""


def write(
    lamps: pytest.Pytester, *, guide: str = OWN_BUS, given: str = "", person: str = "pass", run: str = RUN
) -> None:
    """Let a guide, to which something is given, run with a person who does something for each action."""
    (lamps.path / "lamps/guide.py").write_text(guide, encoding="utf-8")
    requirement = '[R1]\ntitle = "Light"\nformula = "always(on(wish) -> lamp_level <= 80)"\n'
    (lamps.path / "requirements.toml").write_text(requirement, encoding="utf-8")
    conftest = lamps.path / "conftest.py"
    text = conftest.read_text(encoding="utf-8").replace(
        "cross={", "time=VirtualTime(apis=('time', 'threading')), cross={"
    )
    head = text[: text.index("def run(run):")]
    conftest.write_text(head + run.replace("PERSON", person).replace("GIVEN", given), encoding="utf-8")


def step(body: str) -> str:
    """A guide with a bus of its own that does something now and then."""
    return OWN_BUS.replace("        pass\n", f"        {body}\n")


HAS_OWN = {
    "a bus of its own": {},
    "a device that only it has": {"given": "kettle", "guide": step("self.given[0].read()")},
    "the bus, from which it takes nothing": {"given": "port", "guide": step("self.given[0].publish(Greeting())")},
    "a subscription to what only it says": {
        "given": "port.subscribe(Greeting), port",
        "guide": step("self.given[0].poll()"),
        "run": RUN.replace("            bus.publish(Greeting())\n", ""),
    },
    "a thread of its own, which wakes it": {
        "guide": step("threading.Timer(0.1, lambda: self.wishes.put(None)).start()")
    },
    "its own bus, with the same messages in an order of its own": {
        "guide": step("self.wishes.put(Wish(1.0, False)); time.sleep(0.25)")
    },
    "an immutable value that others have": {"given": "LIMIT_S, 'lamp', (1, 2)"},
}


@pytest.mark.parametrize("parts", mostly_slow(HAS_OWN, 1))
def test_a_session_in_which_nothing_reaches_the_code_fails(lamps: pytest.Pytester, parts: dict[str, str]) -> None:
    write(lamps, **parts)
    result = lamps.runpytest_subprocess("--hri-suite=by-hand", "-o", "hri_known_violations=")
    result.assert_outcomes(passed=4, deselected=1)
    assert UNREACHED in [*_matching(result)], "\n".join(result.outlines)
    assert result.ret == 1
    (problem,) = report(lamps.path)["problems"]
    assert "It may connect to a bus of its own: hand it run.bus.port(...)" in problem


REACHED = {
    "a subscription": {"given": "port.subscribe(Wish)", "guide": step("self.given[0].poll()")},
    "a queue": {"given": "inbox", "guide": step("self.given[0].get()"), "person": "inbox.put(level)"},
    "a dictionary": {"given": "state", "guide": step("self.given[0]['level']"), "person": "state['level'] = level"},
    "a device": {"given": "kettle", "guide": step("self.given[0].heat"), "person": "kettle.heat = level"},
    "a device that is held weakly": {
        "given": "weakref.proxy(kettle)",
        "guide": step("self.given[0].heat"),
        "person": "kettle.heat = level",
        "run": RUN.replace("import queue, threading", "import queue, threading, weakref"),
    },
    "an event": {"given": "event", "guide": step("self.given[0].wait(0.1)"), "person": "event.set()"},
    "a variable of a module": {
        "guide": "LEVEL = 0.0\n"
        + step("self.wishes.put(1) if LEVEL > 10 else None").replace(
            "                continue", "                if LEVEL > 10:\n                    time.sleep(0.1)"
        ),
        "person": "lamps.guide.LEVEL = 20.0 if 'greet' in action.command else 0.0",
    },
    "a world": {
        "given": "state",
        "guide": step("self.given[0]['level']"),
        "run": RUN.replace(
            "    def visitor():",
            "    class World:\n"
            "        def advance(self, target_us):\n"
            "            state['level'] += 1.0\n"
            "            return target_us\n"
            "        def observe(self):\n"
            "            pass\n\n"
            "    run.kernel.world = World()\n\n"
            "    def visitor():",
            1,
        ),
    },
    "the code itself, by reference": {
        "run": RUN.replace("        guide = Guide(GIVEN)\n", "        guide = guides[0]\n").replace(
            "    def visitor():", "    guides = [Guide()]\n\n    def visitor():", 1
        ),
        "person": "guides[0].level = level",
    },
    "a bus of its own that people use": {"person": "lamps.guide.OwnBus.queues[Wish].put(level)"},
}


@pytest.mark.parametrize("parts", mostly_slow(REACHED, 2))
def test_what_reaches_the_code_in_any_way_fails_nothing(lamps: pytest.Pytester, parts: dict[str, str]) -> None:
    write(lamps, **parts)
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "-o", "hri_known_violations=")
    result.assert_outcomes(passed=4, deselected=1)
    assert "problems" not in report(lamps.path) or not report(lamps.path)["problems"], "\n".join(result.outlines)
    assert not [*_matching(result)]


def test_a_single_course_of_events_says_nothing(lamps: pytest.Pytester) -> None:
    """With one test, what the code does cannot be compared."""
    write(lamps)
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "-k", "hall-polite", "-o", "hri_known_violations=")
    assert not [*_matching(result)]


def _matching(result: pytest.RunResult) -> list[str]:
    return [UNREACHED for line in result.outlines if line.startswith(UNREACHED.rstrip("*"))]


def test_a_session_in_which_no_action_begins_says_so(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", "in run.actions():", "in ():")
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "-o", "hri_known_violations=")
    result.stdout.fnmatch_lines(["no action began in any of 4 runs: *"])
