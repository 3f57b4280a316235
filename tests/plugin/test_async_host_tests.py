"""Host tests that are coroutines, run by pytest-asyncio or the plugin of anyio: they pass as others do."""

from __future__ import annotations

import importlib.util

import pytest

from tests.plugin.project import change, outcomes

BLINK = """        asyncio.run(blink(clock))
        bus.publish(Switched(level))"""

CODE = """import asyncio

GLARE = 80.0


async def blink(clock):
    async with asyncio.TaskGroup() as tasks:
        for _ in range(3):
            tasks.create_task(asyncio.sleep(0.05))
    await asyncio.wait_for(asyncio.sleep(0.05), timeout=1.0)
    loop = asyncio.get_running_loop()
    assert await loop.run_in_executor(None, lambda: 1) == 1
"""

HOSTS = {
    "def": "def test_lamps(hri_case):\n    hri_case.check(hri_case.run())\n",
    "pytest-asyncio": "@pytest.mark.asyncio\n{}",
    "anyio": "@pytest.mark.anyio\n{}",
    "asyncio.run in the test": (
        "def test_lamps(hri_case):\n    async def main():\n        hri_case.check(hri_case.run())\n"
        "    asyncio.run(main())\n"
    ),
}
COROUTINE = """async def test_lamps(hri_case):
    task = asyncio.current_task()
    await asyncio.sleep(0)
    result = hri_case.run()
    await asyncio.sleep(0)
    assert asyncio.current_task() is task
    assert asyncio.get_running_loop().time() != result.sim_s
    hri_case.check(result)
"""
HEAD = """import asyncio

import pytest


@pytest.fixture
def anyio_backend():
    return "asyncio"


"""

NEEDED = {"pytest-asyncio": "pytest_asyncio", "anyio": "anyio"}


@pytest.mark.parametrize("host", HOSTS)
def test_code_with_asyncio_passes_whatever_runs_the_host_test(lamps: pytest.Pytester, host: str) -> None:
    module = NEEDED.get(host)
    if module is not None and importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not installed")
    change(lamps.path, "lamps/guide.py", "GLARE = 80.0\n", CODE)
    change(lamps.path, "lamps/guide.py", "        bus.publish(Switched(level))", BLINK)
    change(
        lamps.path,
        "conftest.py",
        "        run=run,\n",
        "        run=run,\n        time=VirtualTime(apis=('asyncio', 'threading')),\n",
    )
    (lamps.path / "test_lamps.py").write_text(HEAD + HOSTS[host].format(COROUTINE), encoding="utf-8")
    scope = ("-o", "asyncio_default_fixture_loop_scope=function") if importlib.util.find_spec("pytest_asyncio") else ()
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", *scope)
    result.assert_outcomes(passed=3, xfailed=1)
    assert set(outcomes(lamps.path).values()) == {"passed", "known-violation"}
    result.stdout.no_fnmatch_line("*Warning*")
