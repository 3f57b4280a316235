"""Small multi-agent programs made up by Hypothesis: beliefs, plans, goals, messages, failures, loops, waits."""

from __future__ import annotations

from hypothesis import strategies as st

AGENTS = ("a", "b", "c")
PROPOSITIONS = ("p0", "p1", "p2", "p3")
GOALS = ("g0", "g1", "g2")
_NUMBERS = st.integers(0, 3).map(str)
_PROPOSITION = st.sampled_from(PROPOSITIONS)
_SOURCE = st.sampled_from(("", "", "", "[source(self)]", "[source(a)]", "[source(b)]", "[source(steer)]"))


def _texts(pattern: str, *parts: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.tuples(*parts).map(lambda values: pattern.format(*values))


def _literals(variables: tuple[str, ...]) -> st.SearchStrategy[str]:
    """Literals to ask for; variables may be bound by them, or be bound already."""
    variable = st.sampled_from((*variables, "Y"))
    return st.one_of(
        _texts("{}{}", _PROPOSITION, _SOURCE),
        _texts("q({})", variable),
        _texts("q({})", _NUMBERS),
        _texts("r({}, {})", variable, variable),
        _texts("q(_){}", _SOURCE),
    )


def _conditions(variables: tuple[str, ...]) -> st.SearchStrategy[str]:
    literal = _literals(variables)
    part = st.one_of(
        literal,
        literal,
        _texts("not {}", literal),
        _texts("({} | {})", _PROPOSITION, _PROPOSITION),
        st.sampled_from(("X < 2", "X == 1", "X + 1 >= 2", "Y = X + 1", "not (X == 0)", "true")),
    )
    return st.lists(part, min_size=1, max_size=3).map(" & ".join)


def _statements(depth: int) -> st.SearchStrategy[str]:
    goal = st.sampled_from(GOALS)
    agent = st.sampled_from(AGENTS)
    simple = st.one_of(
        _texts("!{}", goal),
        _texts("!!{}", goal),
        _texts("!h({})", st.sampled_from(("X", "X - 1", "2", "0"))),
        _texts("+{}", _PROPOSITION),
        _texts("-{}{}", _PROPOSITION, _SOURCE),
        _texts("+q({})", st.sampled_from(("X", "1", "X + 1", "2"))),
        _texts("-q({})", st.sampled_from(("X", "1", "_"))),
        _texts("-+q({})", st.sampled_from(("X", "X + 1", "0"))),
        _texts("+r({}, X)", _NUMBERS),
        _texts("?{}", _literals(("X", "Z"))),
        _texts('.print(X, {}, " t ")', _PROPOSITION),
        _texts(".send({}, tell, {})", agent, _PROPOSITION),
        _texts(".send({}, tell, q({}))", agent, st.sampled_from(("1", "X"))),
        _texts(".send({}, achieve, {})", agent, goal),
        _texts(".send({}, untell, {})", agent, _PROPOSITION),
        _texts(".wait({})", st.sampled_from(("0", "1", "3", "0.25"))),
        _texts(".abolish({})", st.sampled_from((*PROPOSITIONS, "q(_)", "q(1)", "r(X, _)"))),
        _texts("Z = X + {}", _NUMBERS),
        st.sampled_from(("X < 3", ".fail", "act(X)", "act(1)", "refuse", ".drop_desire(g1)", ".my_name(N)")),
    )
    if not depth:
        return simple
    body = _bodies(depth - 1)
    return st.one_of(
        simple,
        simple,
        simple,
        simple,
        _texts("if ({}) {{ {} }} else {{ {} }}", _conditions(("X",)), body, body),
        _texts("if ({}) {{ {} }}", _conditions(("X",)), body),
        _texts("for ({}) {{ {} }}", _literals(("W",)), body),
        _texts("while ({}) {{ {} }}", _conditions(("X",)), body),
    )


def _bodies(depth: int) -> st.SearchStrategy[str]:
    return st.lists(_statements(depth), min_size=0, max_size=4).map("; ".join)


def _plans() -> st.SearchStrategy[str]:
    trigger = st.one_of(
        st.sampled_from(GOALS).map("+!{}".format),
        st.sampled_from(GOALS).map("+!{}".format),
        st.sampled_from(("+!h(X)", "+!h(0)", "+!h(X)", "+!g0[source(S)]", "-!g0", "-!h(X)", "-!g1")),
        _texts("{}{}{}", st.sampled_from("+-"), _PROPOSITION, _SOURCE),
        st.sampled_from(("+q(X)", "-q(X)", "+q(1)", "+p0[source(S)]", "+r(X, X)")),
    )
    context = st.one_of(st.just(""), st.just(""), _conditions(("X",)).map(" : {}".format))
    label = st.one_of(st.just(""), st.just(""), st.just("@x[atomic] "))
    body = _bodies(2).map(lambda text: f" <- {text}" if text else "")
    return _texts("{}{}{}{}.", label, trigger, context, body)


def _fallbacks() -> str:
    """A last plan for each goal, so that not every goal fails."""
    return "\n".join(f"+!{goal}." for goal in GOALS) + "\n+!h(X)."


def programs() -> st.SearchStrategy[str]:
    """The source of one agent."""
    beliefs = st.lists(
        st.sampled_from(("p0.", "p1.", "q(1).", "q(2).", "r(1, 2).", "q(a).", "p2[source(b)].")), max_size=4
    )
    goals = st.lists(st.sampled_from(("!g0.", "!g1.", "!h(2).")), min_size=1, max_size=2)
    plans = st.lists(_plans(), min_size=1, max_size=7)
    last = st.one_of(st.just(""), st.just(_fallbacks()), st.just(_fallbacks()))
    return st.tuples(beliefs, goals, plans, last).map(
        lambda parts: "\n".join((*dict.fromkeys(parts[0]), *parts[1], *parts[2], parts[3]))
    )


def systems() -> st.SearchStrategy[dict[str, str]]:
    """The sources of three agents."""
    return st.fixed_dictionaries({name: programs() for name in AGENTS})
