"""``hricdv model run``."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv.bdi.__main__ import main
from tests.bdi.models import system_of


def test_run_prints_what_agents_print_and_nothing_else(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    system_of(tmp_path, a="!go. +!go <- .print(hello); .send(b, tell, hi).", b="+hi[source(S)] <- .print(hi, S).")
    assert main(["run", str(tmp_path / "mas.mas2j")]) == 0
    out, err = capsys.readouterr()
    assert out == "[a] hello\n[b] hia\n"
    assert err == "ended after 2 rounds: idle\n"


def test_round_limit_and_seed_are_options(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    system_of(tmp_path, a="n(0). !go. +!go : n(X) <- .random(R); .print(R); -+n(X + 1); !go.")
    main(["run", str(tmp_path / "mas.mas2j"), "--max-rounds", "9", "--seed", "3"])
    first = capsys.readouterr()
    main(["run", str(tmp_path / "mas.mas2j"), "--max-rounds", "9", "--seed", "3"])
    assert capsys.readouterr() == first
    ended, endless = first.err.splitlines()
    assert ended == "ended after 9 rounds: round limit"
    assert endless.endswith("a.asl:1:12: plan @_plan1 of a never ends")


@pytest.mark.parametrize("source", ["+!g <- .", "+!g <- .prnt(1).", "p :- p. !g. +!g : p."])
def test_model_that_cannot_run_gives_a_message_and_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], source: str
) -> None:
    system_of(tmp_path, a="p.")
    (tmp_path / "a.asl").write_text(source)
    assert main(["run", str(tmp_path / "mas.mas2j")]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert "a.asl:1:" in err


@pytest.mark.parametrize("arguments", [[], ["walk"], ["run"], ["run", "x.mas2j", "--max-rounds", "0"]])
def test_wrong_usage_is_exit_code_2(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2


@pytest.mark.skipif(not hasattr(signal, "SIGPIPE"), reason="a signal of POSIX")
def test_the_program_ends_with_its_reader(tmp_path: Path) -> None:
    system_of(tmp_path, a="!go(0). +!go(N) : N < 9000 <- .print(line, N); !go(N + 1). +!go(_).")
    program = [sys.executable, "-m", "pytest_hricdv", "model", "run", str(tmp_path / "mas.mas2j")]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"[a] line0\n"
        process.stdout.close()
    assert process.returncode == -signal.SIGPIPE
