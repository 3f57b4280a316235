"""Without a suite the plugin costs nothing, says nothing, and says what is missing where it is asked for."""

from __future__ import annotations

import pytest

from tests.plugin.project import in_each_mode

HEAVY = (
    *("lark", "jinja2", "coverage", "greenlet", "numpy", "pybullet"),
    *(f"pytest_hricdv.{package}" for package in ("bdi", "generate", "monitor", "results.model")),
)


@in_each_mode
def test_the_host_test_is_skipped_with_a_word_on_how_to_run_it(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    result = lamps.runpytest_inprocess("-rs", *options)
    assert result.ret == 0
    result.assert_outcomes(passed=1, skipped=1)
    result.stdout.fnmatch_lines(["SKIPPED * no suite is active: choose one with --hri-suite=NAME|PATH, or with hri_*"])
    result.stdout.no_fnmatch_line("hri:*")
    result.stdout.no_fnmatch_line("*human-robot interaction*")
    assert not (lamps.path / "hri-report").exists()


def test_loading_the_plugin_imports_nothing_heavy(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        f"""
        import sys

        def test_loaded(request):
            assert request.config.pluginmanager.hasplugin("hricdv")
            assert [name for name in sys.modules if name.startswith({HEAVY!r})] == []
        """
    )
    result = pytester.runpytest_subprocess("-p", "no:cov", "-p", "no:hypothesispytest", "-W", "error")
    result.assert_outcomes(passed=1)
    assert result.stderr.str() == ""


@pytest.mark.slow
def test_a_project_that_does_not_use_the_plugin_sees_the_same_with_and_without_it(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_one():\n    pass\n")

    def lines(*options: str) -> list[str]:
        result = pytester.runpytest_subprocess("-q", "-W", "error", *options)
        return [line for line in result.outlines + result.errlines if " in " not in line]

    assert lines() == lines("-p", "no:hricdv")


def test_options_are_checked_even_without_a_suite(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("--hri-seed=abc")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --hri-seed=abc: expected a whole number"])


def test_help_lists_options_and_ini_keys_in_one_group(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("--help")
    for option in ("suite", "seed", "tests", "concretizations", "report", "fail-under", "export"):
        result.stdout.fnmatch_lines([f"  --hri-{option}=*"])
    result.stdout.fnmatch_lines(["hricdv: which tests, and how they run (*):", "  hri_suite (string):*"])


def test_a_misspelt_option_suggests_the_right_one(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("--hri-siute=rl")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert "--hri-siute: there is none; did you mean --hri-suite?" in result.stderr.str()
    assert "did you mean" not in lamps.runpytest_inprocess("--hri-xyzzy").stderr.str()
