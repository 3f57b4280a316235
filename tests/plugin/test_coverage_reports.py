"""Code of which public reports said that coverage was wrong: it counts as coverage.py counts it, with it and alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.plugin.project import change
from tests.plugin.test_coverage_settings import CROSS_CHECK, SUITE, coverages, ours

pytestmark = pytest.mark.slow  # sessions in processes of their own

MODULES = {
    # Gevent, SQLAlchemy: lines that run in a greenlet of the code's own.
    "greenlets": """
import greenlet
def use():
    def coroutine():
        return 5
    child = greenlet.greenlet(coroutine)
    value = child.switch()
    value += 1
    return value
""",
    # Lines that run in a thread, and after it.
    "threaded": """
import threading
def body(out):
    for n in range(3):
        out.append(n)
    return out
def use():
    out = []
    t = threading.Thread(target=body, args=(out,))
    t.start()
    t.join()
    if out:
        out.append(9)
    return out
""",
    # Lines after an await.
    "coroutines": """
import asyncio
async def inner():
    await asyncio.sleep(0.01)
    value = 1
    async with asyncio.timeout(1.0):
        value += 1
    return value
async def outer():
    a, b = await asyncio.gather(inner(), inner())
    if a == b:
        return a
    return None
def use():
    return asyncio.run(outer())
""",
    # A pattern that matches everything, as an alternative.
    "wildcards": """
def use():
    return [kind(x) for x in ("a", "b")]
def kind(x):
    match x:
        case "a":
            return 1
        case "default" | _:
            return 2
""",
    # The end of a generator expression is no branch of the condition.
    "generator_expressions": """
def use(args=("-x",)):
    if any(arg.startswith("-") for arg in args):
        return "option"
    return ""
""",
    # The end of a condition in a finally block.
    "finally_blocks": """
def example(raise_exc, enter):
    try:
        if raise_exc:
            raise ValueError
    except ValueError:
        pass
    finally:
        if enter:
            pass
    return 1
def use():
    example(True, True); example(False, False)
""",
    # Leaving a with statement early.
    "with_statements": """
import contextlib
def use():
    for n in range(2):
        with contextlib.suppress(ValueError):
            if n:
                raise ValueError
            continue
    with contextlib.nullcontext() as a, contextlib.nullcontext(3) as b:
        return b
""",
    # A condition in an except block that the code falls out of.
    "except_blocks": """
class X:
    def a(self):
        raise Exception("expected")
    def b(self):
        try:
            while True:
                var = "somevalue"
                self.a()
        except Exception as e:
            if not (e.args == ("expected",)):
                raise e
            q = 1
def use():
    X().b()
""",
    # A condition that is the last in a try block.
    "last_in_try": """
def f(cursor, fetch=True):
    try:
        cursor.append(1)
        if fetch:
            cursor.append(2)
    except Exception:
        raise ValueError
    return cursor
def use():
    f([]); f([], False)
""",
    # A RecursionError takes the trace function away from some tracers.
    "recursion": """
import sys
def f():
    f()
def use():
    try:
        f()
    except RecursionError as e:
        text = str(e)
    if text:
        text += "!"
    return text
""",
    # A module that is loaded again.
    "reloading": """
import importlib
from lamps.reported import reloaded
def use():
    before = reloaded.VALUE
    importlib.reload(reloaded)
    return before
""",
    # Which is loaded again.
    "reloaded": """
VALUE = 1
if VALUE > 1:
    VALUE = 2
def other():
    return VALUE
""",
    # A module that is imported by its name.
    "importing": """
import importlib
def use():
    m = importlib.import_module("lamps.reported.late")
    return m.late()
""",
    # Which is imported by its name.
    "late": """
X = 1
def late():
    return X
def never():
    return 2
""",
    # A branch to what is excluded in other projects.
    "excluded": """
def use():
    return foo(1), bar(1)
def foo(x):
    if x == 1:
        return x
    elif x == 2:
        raise NotImplementedError
def bar(x):
    try:
        return x + 1
    except TypeError:
        return NotImplemented
""",
    # A condition whose body does nothing.
    "bare_if": """
def func2(arg):
    if arg:
        pass
def use():
    func2(True)
if __name__ == "__main__":
    use()
""",
    # A loop with its end.
    "loops": """
def use(a=5):
    while a:
        x = 1
        a -= 1
    return x
""",
    # A loop that is never entered.
    "empty_loops": """
def use(items=()):
    for x in items:
        if x:
            print(x)
    return "done"
""",
    # A generator that is closed halfway.
    "generators": """
def gen():
    try:
        yield 1
        yield 2
    finally:
        done = True
def use():
    g = gen()
    next(g)
    g.close()
    return [y for y in gen() if y]
""",
    # Code that is compiled under the name of the file.
    "executed": """
SOURCE = "a = 1\\nb = 2\\n"
def use():
    names = {}
    exec(compile(SOURCE, __file__, "exec"), names)
    return names["b"]
""",
    # A function whose definition and result take several lines.
    "decorated": """
import functools
def deco(f):
    @functools.wraps(f)
    def w(*a):
        return f(*a)
    return w
@deco
@deco
def use(
    x=1,
    y=lambda: (
        2
    ),
):
    return (
        x
        if x
        else y()
    )
""",
    # Another current folder is left behind.
    "elsewhere": """
import os
def use():
    os.chdir(os.path.dirname(__file__))
    return os.getcwd()
""",
}
"""Module -> its text; `use` runs it, where it has one."""


def report_on(folder: Path) -> None:
    """Let the guide run all of them."""
    package = folder / "lamps" / "reported"
    package.mkdir()
    calls = []
    for name, text in MODULES.items():
        (package / f"{name}.py").write_text(text.lstrip("\n"), encoding="utf-8")
        if "def use(" in text:
            calls += [f"    from lamps.reported import {name}", f"    {name}.use()"]
    (package / "__init__.py").write_text("\n".join(["def use():", *calls, ""]), encoding="utf-8")
    call = "        import lamps.reported\n        lamps.reported.use()\n        level = level_for(wish)\n"
    change(folder, "lamps/guide.py", "        level = level_for(wish)\n", call)
    virtual = 'code=("lamps",),\n        time=VirtualTime(apis=("time", "threading", "asyncio")),'
    change(folder, "conftest.py", 'code=("lamps",),', virtual)


def test_totals_are_those_of_coverage_with_it_and_without_it(lamps: pytest.Pytester) -> None:
    report_on(lamps.path)
    lamps.runpytest_subprocess(*SUITE, "-p", "no:xdist", *CROSS_CHECK)
    joined = ours(lamps.path)
    assert joined == coverages(lamps.path)
    assert joined["lamps/reported/greenlets.py"] == (8, 0, 0, 0)
    lamps.runpytest_subprocess(*SUITE, "-p", "no:xdist", "-p", "no:cov")
    assert ours(lamps.path) == joined
