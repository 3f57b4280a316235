"""Bad input: one clear message, exit code 4, nothing left behind; whether tests would run here or in workers."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.plugin.project import change

SUITE = "--hri-suite=by-hand"
ROOT = Path(__file__).parents[2]


def short(value: object) -> str:
    """A parameter as a part of a test's name."""
    text = value[-1] if isinstance(value, list) else str(value)
    return re.sub(r"[^\w.]+", "-", text)[:40].strip("-")


def refused(lamps: pytest.Pytester, *options: str) -> str:
    """The message with which a run is refused: printed once, without a traceback, before a report is begun."""
    result = lamps.runpytest_inprocess(*options)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    message = result.stderr.str().strip()
    assert message.startswith("ERROR: ")
    assert message.count("ERROR") == 1
    printed = message + result.stdout.str()
    assert "Traceback" not in printed
    assert "INTERNALERROR" not in printed
    assert "node down" not in printed
    assert "human-robot interaction" not in printed
    assert not (lamps.path / "hri-report").exists()
    return message.removeprefix("ERROR: ")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--hri-suite=bdi-rand"], "; nearest: bdi-random"),
        (["--hri-suite=nowhere/tests.txt"], "'nowhere/tests.txt' is not a method, and there is no file or folder"),
        (["--hri-suite=,"], "suite ',' selects nothing; known: by-hand, bdi-random, rl, pseudorandom, all"),
        ([SUITE, "--hri-tests=0"], "--hri-tests=0: expected at least 1"),
        ([SUITE, "--hri-seed=1.5"], "--hri-seed=1.5: expected a whole number"),
        ([SUITE, "--hri-concretizations=0"], "--hri-concretizations=0: expected at least 1"),
        ([SUITE, "-o", "hri_seed=abc"], "hri_seed = abc: expected a whole number"),
        ([SUITE, "-o", "hri_sampling=some"], "hri_sampling = some: expected one of uniform"),
        ([SUITE, "-o", "hri_fail_under=plans=most"], "hri_fail_under: plans=most: expected a percentage"),
        (
            [SUITE, "--hri-concretizations=10000", "--hri-suite=rl"],
            "0,000 tests, 10000 of each abstract test",
        ),
        ([SUITE, "--hri-tests=100001"], "--hri-tests=100001: expected at most 100000"),
        ([SUITE, f"--hri-seed={2**63}"], "expected at most 9223372036854775807"),
        ([SUITE, "--hri-seed=٣"], "--hri-seed=٣: expected a whole number"),
        ([SUITE, "--hri-sampling=edges"], "--hri-sampling=edges: expected one of uniform, corners"),
        (
            [SUITE, "--hri-fail-under=lines=80"],
            "--hri-fail-under=lines=80: expected KIND=PCT with KIND in statements, ",
        ),
        ([SUITE, "--hri-fail-under=80"], "--hri-fail-under=80: expected KIND=PCT"),
        ([SUITE, "--hri-fail-under=plans=most"], "--hri-fail-under=plans=most: expected a percentage, got 'most'"),
        ([SUITE, "--hri-fail-under=plans=101"], "--hri-fail-under=plans=101: expected a percentage from 0 to 100"),
        ([SUITE, "--hri-fail-under=plans=nan"], "--hri-fail-under=plans=nan: expected a percentage from 0 to 100"),
        ([SUITE, "--hri-known=R9"], "known violation of 'R9': no such requirement; there are R1, R2, R3"),
        ([SUITE, "--hri-allow-nc=R8"], "NC is allowed for 'R8': no such requirement; there are R1, R2, R3"),
        ([SUITE, "--hri-baseline=base.json"], "base.json: no such baseline; write it with --hri-update-baseline"),
        ([SUITE, "--hri-baseline=pytest.ini"], "pytest.ini:1:2: not JSON, perhaps cut off"),
        ([SUITE, "--hri-update-baseline"], "--hri-update-baseline: say which file, with --hri-baseline=FILE"),
        ([SUITE, "--hri-fail-on=nc,chnge"], "--hri-fail-on=nc,chnge: expected some of nc, pending, change"),
        ([SUITE, "--hri-fail-on=change"], "--hri-fail-on=change: compared with what? give --hri-baseline=FILE"),
        ([SUITE, "--hri-report=pytest.ini"], "pytest.ini: a file is in the way: remove it, or choose another folder"),
        ([SUITE, "--hri-report=pytest.ini/below"], "a file is in the way"),
        ([SUITE, "--hri-export=pytest.ini"], "pytest.ini: File exists; choose another folder"),
    ],
    ids=short,
)
def test_options(lamps: pytest.Pytester, options: list[str], told: str) -> None:
    assert told in refused(lamps, *options)


@pytest.mark.parametrize(
    ("name", "old", "new", "told"),
    [
        (
            "models/visitor.asl",
            "<- greet; set_lamp(level, 100)",
            "<- greet set_lamp(level, 100)",
            "visitor.asl:4:39: expected '.' or ';', found 'set_lamp'; a ';' is missing between two statements\n"
            "    @v3 +!wish : polite & bright <- greet set_lamp(level, 100); .send(guide, tell, asked).\n"
            "                                          ^",
        ),
        ("models/lamps.mas2j", "agents:", "agent:", "lamps.mas2j:2:13: "),
        ("models/lamps.mas2j", " usher;", "", "no agent 'usher' in this model"),
        ("conftest.py", '"dim", "dark"', '"dim", "gloomy"', "belief 'gloomy' of the space occurs nowhere in agent"),
        ("conftest.py", "lamps.mas2j", "lumps.mas2j", "lumps.mas2j"),
        (
            "requirements.toml",
            "lamp_level > 0 ->",
            "lamp_level > 0 =>",
            "requirements.toml:8:34: requirement R2, column 23 of the formula: unexpected '='",
        ),
        (
            "requirements.toml",
            "lamp_level <= 80",
            "lamp_level <= 80 lx",
            "column 40 of the formula: unknown unit 'lx'",
        ),
        (
            "requirements.toml",
            "lamp_level <= 80",
            "lamp_levle <= 80",
            "unknown name 'lamp_levle'; nearest: lamp_level\n    always(lamp_level > 0 -> lamp_levle <= 80)\n"
            "                             ^^^^^^^^^^",
        ),
        ("by_hand.toml", '"d*"', '"x*"', "by_hand.toml:7:29: pattern matches no belief: 'x*'"),
        ("lamps/guide.py", '"by hand"', '"by hand"  # unreachable:', "lamps/guide.py:44: a waiver needs its reason"),
        (
            "pytest.ini",
            "R2: the hall has no dimmer",
            "R2",
            "hri_known_violations: 'R2': expected 'REQUIREMENT: reason'",
        ),
        (
            "pytest.ini",
            "R2: the hall",
            "R2 until 2027-06-31: the hall",
            "hri_known_violations: 'R2 until 2027-06-31: the hall has no dimmer': '2027-06-31' is not a date",
        ),
        ("pytest.ini", "R2: the hall", "R2 : dark\n    R2: the hall", "a second line for R2; expected one"),
        (
            "pytest.ini",
            "pythonpath = .",
            "pythonpath = .\nhri_allow_nc = R1",
            "hri_allow_nc: 'R1': expected 'REQUIREMENT",
        ),
        ("conftest.py", '{"light": CrossProduct', '{"light": dict', "cross product 'light' is {"),
        (
            "conftest.py",
            "levels})",
            'levels}, {("roof", "*"): "?"})',
            "('roof', '*') is declared impossible but is not a bin",
        ),
        (
            "pytest.ini",
            "R2: the hall",
            "R7: the hall",
            "known violation of 'R7': no such requirement; there are R1, R2",
        ),
        (
            "pytest.ini",
            "pythonpath = .",
            "pythonpath = .\nhri_strict = maybe",
            "ini: hri_strict: expected true or false",
        ),
        ("pytest.ini", "pythonpath = .", "pythonpath = .\nhri_fail_under = all", "under: all: expected KIND=PCT"),
    ],
    ids=short,
)
def test_files(lamps: pytest.Pytester, name: str, old: str, new: str, told: str) -> None:
    change(lamps.path, name, old, new)
    assert told in refused(lamps, SUITE)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('name="lamps",', "", "conftest.py:15: pytest_hricdv_testbench: TypeError: Testbench.__init__() missing 1 "),
        ('name="lamps",', "", "\n  name: a name for reports"),
        ("        model=Model(", "        modle=Model(", "unexpected keyword argument 'modle'"),
        (
            "        run=run,",
            '        run=run,\n        virtual=("time",),',
            "conftest.py:15: pytest_hricdv_testbench: TypeError: Testbench.__init__() got an unexpected keyword "
            "argument 'virtual'\n  virtual=... is now time=VirtualTime(apis=...)",
        ),
        (
            "        run=run,",
            "        run=run,\n        ros2=__import__('pytest_hricdv.testbench').testbench.Ros2(patience_s=5.0),",
            "argument 'patience_s'\n  patience_s=... is now idle_timeout_s=...",
        ),
        (
            "        run=run,",
            "        run=run,\n        people=__import__('pytest_hricdv.testbench').testbench"
            ".InteractiveAgent('a', patience_s=5.0),",
            "argument 'patience_s'\n  patience_s=... is now idle_timeout_s=...",
        ),
        (
            "    return Testbench(",
            "    return dict(",
            "conftest.py:9: pytest_hricdv_testbench: returned {'name': 'lamps'",
        ),
        (
            "    return Testbench(",
            "    Testbench(",
            "conftest.py:9: pytest_hricdv_testbench: returned None; expected a",
        ),
        ("    levels = (", "    levels = 1 / 0, (", "conftest.py:14: pytest_hricdv_testbench: ZeroDivisionError: div"),
        ("import Answer, Greeting, Switched, Wish\n", "import Sign\n", "conftest.py:10: pytest_hricdv_testbench: Impo"),
        ('code=("lamps",)', 'code="lamps"', "code is 'lamps'; expected a tuple of the names of the packages under te"),
        ('code=("lamps",)', 'code=("lumps",)', "there is no package or module 'lumps'; name one that can be imported"),
        (
            "run=run,",
            "run=None,",
            "run is None; expected a function that runs one concrete test and returns an Outcome",
        ),
        ("messages=(Answer,", "messages=(int,", "message <class 'int'> is not a class with fields"),
        (
            '{"lamp_level": Signal(float, "%")}',
            '["lamp_level"]',
            "signals is ['lamp_level']; expected the physical signals, name ->",
        ),
        (
            "fields={}",
            'fields={"lamp": Field("%")}',
            "units has 'lamp', which is neither a signal nor a topic.field; nearest: lamp_level",
        ),
        (
            'Signal(float, "%")',
            'Signal(float, "%", sampled_while="lamp_level")',
            "signals['lamp_level']: sampled_while is 'lamp_level', which is not a bool signal; there are: none",
        ),
        (
            '{"lamp_level": Signal(float, "%")}',
            '{"lamp_level": int}',
            "signal 'lamp_level': expected the type bool, float or str, got",
        ),
        (
            '"lamp_level": Signal(float, "%")',
            '"lamp_level": Signal(float, "%"), "until": float',
            "signal 'until': this is a keyword of the requirement language",
        ),
        (
            '"curt"), "wish"',
            '"bright"), "wish"',
            "conftest.py:20: pytest_hricdv_testbench: GenerateError: belief 'bright' is in group 'mood' and in group",
        ),
        (
            '"mood": ("polite", "curt")',
            '"mood": ()',
            "GenerateError: group 'mood' of beliefs is empty; expected at least",
        ),
        (
            'start=("hall", "cellar")',
            "start=()",
            "GenerateError: group 'start' of beliefs is empty; expected at least o",
        ),
        (
            "Uniform(0.5, 1.0",
            "Uniform(0.5, -1.0",
            "conftest.py:13: pytest_hricdv_testbench: GenerateError: range [0.5, -1]",
        ),
        ("Uniform(0.5, 1.0", "Uniform(False, 1.0", "range with False: expected a finite number"),
        ('Signal(float, "%")', "Signal(float, 5)", "signals['lamp_level']: unit is 5; expected a string"),
        (
            "        run=run,",
            "        run=run, time=__import__('pytest_hricdv.testbench').testbench.VirtualTime('time'),",
            "time: apis is 'time'; expected tuple[str, ...]",
        ),
        (
            "        run=run,",
            "        run=run, time=__import__('pytest_hricdv.testbench').testbench.VirtualTime((), None, 'idle'),",
            "time: allowed_endings is 'idle'; expected tuple[str, ...]",
        ),
        ('HERE / "by_hand.toml"', 'HERE / "by_head.toml"', "by_head.toml, and there is no such file"),
        ('HERE / "requirements.toml"', "HERE", "requirements is "),
    ],
    ids=short,
)
def test_testbench(lamps: pytest.Pytester, old: str, new: str, told: str) -> None:
    change(lamps.path, "conftest.py", old, new)
    assert told in refused(lamps, SUITE)


def test_no_testbench(lamps: pytest.Pytester) -> None:
    (lamps.path / "conftest.py").unlink()
    message = refused(lamps, SUITE)
    assert message == (
        f"no testbench: implement pytest_hricdv_testbench(config) in {lamps.path / 'conftest.py'} "
        "and return a pytest_hricdv.testbench.Testbench"
    )


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("greet\nset_lamp level - 3\n", "recorded.txt:2:1: 'set_lamp level - 3' is not a command; expected "),
        ("greet\n\n  gret\n", "recorded.txt:3:3: unknown command 'gret'; nearest: greet"),
        ("# nothing but words\n", "recorded.txt: no tests in it; expected at least one"),
        ("# id: a.b\ngreet\n", "recorded.txt:"),
        (
            "\n".join(["# id: a\n# suite: s\n# target: a\n# seed: 1\ngreet\n"] * 2),
            "recorded.txt:7:1: a second test with the id 'a', which is at ",
        ),
    ],
    ids=short,
)
def test_recorded_tests(lamps: pytest.Pytester, text: str, told: str) -> None:
    (lamps.path / "recorded.txt").write_text(text, encoding="utf-8")
    assert told in refused(lamps, "--hri-suite=recorded.txt")


@pytest.mark.parametrize("workers", [("-n", "2"), ("-n2",), ("-n", "auto"), ("--numprocesses=2",)])
def test_workers_without_xdist(lamps: pytest.Pytester, workers: tuple[str, ...]) -> None:
    told = "-n needs pytest-xdist, which is not installed or switched off: pip install pytest-xdist"
    assert told in refused(lamps, SUITE, "-p", "no:xdist", *workers)
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_suite = by-hand")
    assert told in refused(lamps, "-p", "no:xdist", *workers)


def test_a_simulator_that_is_not_installed_is_told_once_before_the_run(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", "run=run,", 'run=run,\n        simulation=Simulation(requires=("simulator",)),')
    simulator = lamps.path / "simulator.py"
    simulator.write_text("raise ImportError('needs PyBullet: pip install \"pytest-hricdv[sim]\"')\n", encoding="utf-8")
    told = 'the testbench requires simulator: needs PyBullet: pip install "pytest-hricdv[sim]"'
    assert refused(lamps, SUITE) == told
    assert lamps.runpytest_inprocess("--collect-only", "-q", SUITE).ret == 0


@pytest.mark.slow
def test_the_table_says_which_extra_it_needs(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    (pytester.path / "pybullet.py").write_text("raise ImportError('not for this Python')\n", encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(pytester.path))
    options = ("--rootdir", ROOT, "-c", ROOT / "pyproject.toml", "-p", "no:cacheprovider")
    result = pytester.runpytest_subprocess("--hri-suite=by-hand", *options, ROOT / "tests" / "hri")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert 'pip install "pytest-hricdv[sim]"' in result.stderr.str()
    assert "not for this Python" in result.stderr.str()
    assert not (pytester.path / "hri-report").exists()


def test_a_broken_cache_entry_is_generated_anew(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess("--collect-only", SUITE)
    (kept,) = (lamps.path / ".pytest_cache" / "v" / "hricdv").iterdir()
    sealed = json.loads(kept.read_text(encoding="utf-8"))
    suite = json.loads(sealed["content"])
    doctored = json.dumps(suite | {"tests": suite["tests"][:1]})
    for entry in ("{}", doctored, {**sealed, "content": doctored}):
        kept.write_text(json.dumps(entry), encoding="utf-8")
        result = lamps.runpytest_inprocess("--collect-only", SUITE)
        assert result.ret == 0
        assert json.loads(kept.read_text(encoding="utf-8")) == sealed
        result.stdout.fnmatch_lines(["collected * / 4 selected"])


def test_code_that_is_no_python_ends_the_session_with_its_line(lamps: pytest.Pytester) -> None:
    change(lamps.path, "lamps/guide.py", 'return "by hand"', 'return ("by hand"')
    result = lamps.runpytest_inprocess(SUITE)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(
        [
            "*run: SyntaxError: '(' was never closed (guide.py, line 44)",
            "The testbench's run needs lamps.guide, which cannot be imported: *",
            "*3 tests not run or lost, totals are lower bounds",
        ]
    )
