"""Small multi-agent programs made up by Hypothesis: beliefs, plans, goals, messages, failures, loops, waits.

Most of what they do has a compiled form, and most goals have a plan, so that runs are long; now and then
something fails or is only for the interpreter.
"""

from __future__ import annotations

from functools import cache

from hypothesis import strategies as st

AGENTS = ("a", "b", "c")
PROPOSITIONS = ("p0", "p1", "p2", "p3")
GOALS = ("g0", "g1", "g2")
Text = st.SearchStrategy[str]
_NUMBERS = st.integers(0, 3).map(str)
_PROPOSITION = st.sampled_from(PROPOSITIONS)
_SOURCE = st.sampled_from(("", "", "", "", "[source(self)]", "[source(a)]", "[source(b)]", "[source(steer)]"))
_GOAL = st.sampled_from((*GOALS, "h(2)", "h(1)"))


def _texts(pattern: str, *parts: Text) -> Text:
    return st.tuples(*parts).map(lambda values: pattern.format(*values))


def _often(usual: Text, rare: Text) -> Text:
    return st.integers(0, 19).flatmap(lambda drawn: rare if drawn == 7 else usual)


@cache
def _tests(bound: bool) -> Text:
    """Conditions that bind nothing; X may occur if it is bound."""
    plain = st.one_of(
        _texts("{}{}", _PROPOSITION, _SOURCE),
        _texts("not {}{}", _PROPOSITION, _SOURCE),
        _texts("({} | not {})", _PROPOSITION, _PROPOSITION),
        _texts("not q({})", _NUMBERS),
        _texts("not (q(V) & V > {})", _NUMBERS),
        st.just("not r(_, _)"),
    )
    if not bound:
        return plain
    with_x = st.sampled_from(("X < 2", "X == 1", "X + 1 >= 2", "not (X == 0)", "q(X)", "not r(X, X)", "X \\== 1"))
    return st.one_of(plain, with_x)


@cache
def _statement(bound: bool, depth: int) -> Text:
    agent = st.sampled_from(AGENTS)
    forms = [
        _texts("!{}", _GOAL),
        _texts("!!{}", _GOAL),
        _texts("+{}", _PROPOSITION),
        _texts("+{}", _PROPOSITION),
        _texts("-{}{}", _PROPOSITION, _SOURCE),
        _texts("-+{}", _PROPOSITION),
        _texts("-+q({})", _NUMBERS),
        _texts("+q({})", _NUMBERS),
        _texts("-q({})", _NUMBERS),
        _texts('.print({}, " t ", {})', _PROPOSITION, _NUMBERS),
        _texts("do({})", _NUMBERS),
        _texts(".send({}, tell, {})", agent, _PROPOSITION),
        _texts(".send({}, tell, q({}))", agent, _NUMBERS),
        _texts(".send({}, achieve, {})", agent, _GOAL),
        _texts(".wait({})", st.sampled_from(("0", "0.2", "1", "0.25"))),
        _texts(".abolish({})", st.sampled_from((*PROPOSITIONS, "q(_)", "q(1)"))),
    ]
    if bound:
        forms += [
            st.sampled_from(("!h(X - 1)", "+q(X + 1)", "-q(X)", "-+q(X * 2)", "+r(X, 1)", "+r(1, X)", "do(X)")),
            st.sampled_from((".print(X)", "Z = X + 1", "?q(X)", ".abolish(r(X, _))", "X < 3", ".wait(X)")),
            _texts(".send({}, tell, q(X))", agent),
        ]
    if depth:
        body, inside = _body(bound, depth - 1), _body(True, depth - 1)
        forms += [
            _texts("if ({}) {{ {} }} else {{ {} }}", _tests(bound), body, body),
            _texts("if ({}) {{ {} }}", _tests(bound), body),
            _texts("for ({}) {{ {} }}", st.just("q(X)"), inside),
            _texts("for ({}) {{ {} }}", st.just("r(X, W) & W < 3"), inside),
            _texts("while ({}) {{ {} }}", _tests(bound), body),
        ]
    rare = st.sampled_from(
        (
            ".fail",
            "refuse",
            ".drop_desire(g1)",
            ".my_name(N)",
            "?p0",
            "?q(Y)",
            ".send(b, untell, p1)",
            "act(1)",
            "Y < 1",
        )
    )
    return _often(st.one_of(forms), rare)


@cache
def _body(bound: bool, depth: int) -> Text:
    return st.lists(_statement(bound, depth), min_size=depth, max_size=5).map("; ".join)


@cache
def _plan(bound: bool) -> Text:
    """A plan in whose body X is bound, by its trigger or its context, or does not occur."""
    tests = st.lists(_tests(bound), min_size=0, max_size=2)
    goals = [f"+!{goal}" for goal in GOALS]
    beliefs = [f"{sign}{name}" for sign in "+-" for name in PROPOSITIONS[:2]]
    if not bound:
        trigger = st.sampled_from((*goals, *goals, *beliefs, "+!h(0)", "+!h(_)", "+q(1)", "+p0[source(b)]"))
        context = tests.map(" & ".join)
    else:
        asked = st.sampled_from(("q(X)", "r(X, Y) & Y > 0", "q(Y) & X = Y + 1", "q(X)"))
        of_context = st.tuples(st.sampled_from((*goals, *goals, *beliefs)), asked, tests)
        of_trigger = st.tuples(st.sampled_from(("+!h(X)", "+!h(X)", "+q(X)", "-q(X)", "+r(X, _)")), st.just(""), tests)
        trigger = st.just("")
        context = st.one_of(of_context, of_trigger).map(
            lambda parts: f"{parts[0]} : {' & '.join(filter(None, (parts[1], *parts[2])))}".removesuffix(" : ")
        )
    head = context if bound else st.tuples(trigger, context).map(lambda both: " : ".join(filter(None, both)))
    label = _often(st.just(""), st.just("@x[atomic] "))
    body = _body(bound, 2).map(lambda text: f" <- {text}" if text else "")
    return _texts("{}{}{}.", label, head, body)


@cache
def _spin() -> Text:
    """A plan that does nothing but look again."""
    look = _texts("+!{0} : {1} <- !{0}.", st.sampled_from(GOALS), _tests(False))
    look_with_x = _texts("+!{0} : q(X) & {1} <- !{0}.", st.sampled_from(GOALS), _tests(True))
    return st.one_of(look, look, look_with_x, st.just("+!g1[source(S)] : p3[source(S)] <- !g1."))


def programs() -> Text:
    """The source of one agent; a last plan for each goal, so that few goals fail."""
    beliefs = st.lists(st.sampled_from(("p0.", "p1.", "q(1).", "q(2).", "r(1, 2).", "p2[source(b)].")), max_size=4)
    goals = st.lists(st.sampled_from(("!g0.", "!g1.", "!h(2).")), min_size=1, max_size=2)
    failure = st.sampled_from(("-!g0 <- .print(failed).", "-!h(X) <- +q(X).", "+p0[source(S)] <- .print(S).", "q(a)."))
    odd = _often(st.just(""), failure)
    plans = st.lists(st.one_of(_plan(False), _plan(True), _plan(False), _plan(True), _spin()), min_size=4, max_size=9)
    last = _often(st.just("\n".join(f"+!{goal}." for goal in GOALS) + "\n+!h(_)."), st.just(""))
    return st.tuples(beliefs, odd, goals, plans, last).map(
        lambda parts: "\n".join((*dict.fromkeys(parts[0]), parts[1], *parts[2], *parts[3], parts[4]))
    )


def systems() -> st.SearchStrategy[dict[str, str]]:
    """The sources of three agents."""
    return st.fixed_dictionaries({name: programs() for name in AGENTS})
