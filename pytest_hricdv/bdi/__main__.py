"""``hricdv model``: run, trace and lint BDI models from the command line."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from pytest_hricdv._base.command_line import CommandParser, end_with_reader
from pytest_hricdv._base.message import visible
from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.run.environment import NoEnvironment
from pytest_hricdv.bdi.run.system import MAX_ROUNDS, MultiAgentSystem, Result

_EXAMPLES = """\
examples:
  hricdv model run hello.mas2j
  hricdv model run hello.mas2j --max-rounds 500 --seed 7
  hricdv model trace hello.mas2j --percept ann:light(on)
  hricdv lint hello.mas2j

A project file names its agents; each has its AgentSpeak source beside it:

  hello.mas2j:   MAS hello { agents: ann; bob; }
  ann.asl:       !start.
                 +!start <- .print("hello"); .send(bob, tell, hello).
  bob.asl:       +hello[source(A)] <- .print("hello, ", A).

run prints the output of the agents as '[agent] text', trace the causes of plans and actions, lint probable
mistakes. Warnings, errors and how the run ended go to the standard error. The exit code is 0, or 1 if lint has
findings, or 2 if the model cannot be loaded or run.
"""


def main(arguments: Sequence[str] | None = None, called: str = "hricdv model") -> int:
    """Execute a command line; returns the exit code."""
    options = _parser(called).parse_args(arguments)
    try:
        return int(options.command(options))
    except BdiError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


def _run(options: argparse.Namespace) -> int:
    result = _run_project(options, trace=False)
    for line in result.prints:
        print(visible(line, keep="\n\t"))
    actions = sorted({action.partition("(")[0] for _, action in result.actions})
    if actions and not options.quiet:
        print(f"warning: {_action_warning(actions, options.strict_actions)}", file=sys.stderr)
    return _print_end(options, result)


def _action_warning(actions: Sequence[str], fail: bool) -> str:
    """A warning about external actions that no environment implements."""
    names = visible(", ".join(actions))
    if fail:
        return f"no environment implements the external actions {names}: each failed, as in Jason"
    return (
        f"no environment implements the external actions {names}: here each succeeds without an effect, in Jason each "
        "fails; bdi run --strict-actions fails them, an Environment in Python implements them"
    )


def _trace(options: argparse.Namespace) -> int:
    result = _run_project(options, trace=True)
    assert result.trace is not None
    if options.json:
        print(result.trace.to_json())
    elif options.why is not None:
        chosen = [step for step in result.trace if step.kind == "action" and options.why in step.text]
        if not chosen:
            actions = dict.fromkeys(step.text for step in result.trace if step.kind == "action")
            raise BdiError(f"--why {options.why}: no action contains it; actions: {', '.join(actions) or 'none'}")
        print(visible("\n\n".join(map(result.trace.chain_text, chosen)), keep="\n\t"))
    else:
        agents = dict.fromkeys(step.agent for step in result.trace)
        if options.agent is not None and options.agent not in agents:
            raise BdiError(f"--agent {options.agent}: no agent of this name took a step; agents: {', '.join(agents)}")
        print(visible(result.trace.text(options.agent), keep="\n\t"))
    return _print_end(options, result)


def _lint(options: argparse.Namespace) -> int:
    from pytest_hricdv.bdi.lint import external_actions, lint

    percepts = [name for names in options.percepts for name in names.split(",") if name]
    findings = lint(options.files, percepts)
    print(visible("\n\n".join(map(str, findings)), keep="\n\t"), end="\n" if findings else "")
    actions = external_actions(options.files)
    if actions:
        names = visible(", ".join(actions))
        print(
            f"note: external actions {names}: without an environment for them, they succeed here and fail in Jason",
            file=sys.stderr,
        )
    print(f"{len(findings)} finding{'s'[: len(findings) != 1]}" if findings else "nothing found", file=sys.stderr)
    return 1 if findings else 0


def _run_project(options: argparse.Namespace, trace: bool) -> Result:
    environment = NoEnvironment() if getattr(options, "strict_actions", False) else None
    system = MultiAgentSystem.load(options.file, environment)
    percepts: dict[str, list[str]] = {}
    for agent, literal in options.percept:
        percepts.setdefault(agent, []).append(literal)
    try:
        result = system.run(
            max_rounds=options.max_rounds, seed=options.seed, percepts=percepts, jitter=options.jitter, trace=trace
        )
    except ValueError as error:
        raise BdiError(str(error)) from None
    if not options.quiet:
        for warning in system.warnings:
            print(visible(f"warning: {warning}"), file=sys.stderr)
    return result


def _print_end(options: argparse.Namespace, result: Result) -> int:
    if not options.quiet:
        sys.stdout.flush()
        for warning in result.warnings:
            print(visible(f"warning: {warning}"), file=sys.stderr)
        rounds = "1 round" if result.rounds == 1 else f"{result.rounds} rounds"
        print(f"ended after {rounds}: {result.ended}", file=sys.stderr)
        if result.ended == "round limit":
            for plan in result.endless[:3]:
                print(visible(f"{plan} never ends"), file=sys.stderr)
    return 0


def _parser(called: str) -> CommandParser:
    parser = CommandParser(
        prog=called,
        description="Run multi-agent systems written in AgentSpeak with the semantics of Jason, but deterministically.",
        epilog=_EXAMPLES,
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    run = _with_run_options(_command(commands, "run", "run a project and print the output of its agents"))
    run.add_argument(
        "--strict-actions",
        action="store_true",
        help="external actions fail, as in Jason where no environment implements them; otherwise they succeed",
    )
    run.set_defaults(command=_run)
    trace = _with_run_options(
        _command(commands, "trace", "run a project and print the causes of its plans and actions")
    )
    trace.add_argument("--agent", metavar="NAME", help="show only the steps of this agent")
    trace.add_argument("--why", metavar="TEXT", help="show only the causes of each action that contains TEXT")
    trace.add_argument("--json", action="store_true", help="print the steps as a JSON list")
    trace.set_defaults(command=_trace)
    lint = _command(commands, "lint", "find probable mistakes in models without running them")
    lint.add_argument(
        "files", metavar="FILE", nargs="+", help="a .mas2j file, whose agents are checked together, or an .asl file"
    )
    lint.add_argument(
        "--percepts",
        action="append",
        default=[],
        metavar="NAME,...",
        help="names of percepts of the environment; in a source file: '// lint: percepts NAME, ...'",
    )
    lint.set_defaults(command=_lint)
    return parser


def _command(commands: argparse._SubParsersAction[CommandParser], name: str, summary: str) -> CommandParser:
    return commands.add_parser(
        name,
        help=summary,
        description=f"{summary[0].upper()}{summary[1:]}.",
        epilog=_EXAMPLES,
    )


def _with_run_options(command: CommandParser) -> CommandParser:
    """Add the options of a command that runs a project."""
    command.add_argument("file", metavar="FILE.mas2j", help="the project file")
    command.add_argument(
        "--max-rounds",
        type=_rounds,
        default=MAX_ROUNDS,
        metavar="N",
        help="stop after N rounds; in a round, each agent executes one reasoning cycle (default: %(default)s)",
    )
    command.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of all random numbers of the run (default: 0)"
    )
    command.add_argument(
        "--jitter",
        type=_delay,
        default=0,
        metavar="N",
        help="expose races: agents act in random order, messages and percepts arrive up to N rounds late (default: 0)",
    )
    command.add_argument(
        "--percept",
        type=_percept,
        action="append",
        default=[],
        metavar="AGENT:LITERAL",
        help="a percept of an agent from the start of the run; repeatable",
    )
    command.add_argument("--quiet", action="store_true", help="print nothing but errors on the standard error")
    return command


def _rounds(text: str) -> int:
    return _number(text, "a number of rounds from 1", 1)


def _delay(text: str) -> int:
    return _number(text, "a number of rounds from 0", 0)


def _number(text: str, expected: str, least: int) -> int:
    number = int(text) if text.isdecimal() else least - 1
    if number < least:
        raise argparse.ArgumentTypeError(f"expected {expected}, got {text!r}")
    return number


def _percept(text: str) -> tuple[str, str]:
    agent, separator, literal = text.partition(":")
    if not separator or not agent or not literal:
        raise argparse.ArgumentTypeError(f"expected an agent and a literal as in ann:light(on), got {text!r}")
    return agent, literal


if __name__ == "__main__":
    end_with_reader()
    sys.exit(main())
