"""Sets, maps and queues: what Jason 3.3 printed for the same bodies."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError
from tests.bdi.models import prints_of

REST = '-!go[error(E)] <- .print("failed ", E). +!h(S) <- .set.add(S, x).'


@pytest.mark.parametrize(
    ("body", "prints"),
    [
        (".set.create(S); .set.add(S,b); .set.add(S,a); .set.add(S,b); .print(S)", ["{a,b}"]),
        (".set.add(S,b); .print(S)", ["{b}"]),
        (
            '.set.create(S); .set.add_all(S,[c,1,"x",f(2),[1]]); .print(S); .length(S,N); .print(N)',
            ['{1,"x",[1],c,f(2)}', "5"],
        ),
        (".set.create(S); .set.add_all(S,[c,a]); .set.to_list(S,L); .print(L)", ["[a,c]"]),
        (
            ".set.create(S); .set.add_all(S,[c,a]); .set.create(T); .set.add_all(T,S); .set.add(T,z); .print(S,T)",
            ["{a,c}{a,c,z}"],
        ),
        (".set.create(S); .set.add_all(S,[c,a]); .set.union(S,[b,a]); .print(S)", ["{a,b,c}"]),
        (".set.create(S); .set.add_all(S,[c,a]); .set.intersection(S,[b,a]); .print(S)", ["{a}"]),
        (".set.create(S); .set.add_all(S,[c,a]); .set.difference(S,[b,a]); .print(S)", ["{c}"]),
        (".set.create(S); .set.add_all(S,[c,a]); .set.remove(S,a); .set.remove(S,zz); .print(S)", ["{c}"]),
        (".set.create(S); .set.add_all(S,[c,a]); .set.copy(S,T); .set.clear(S); .print(S,T)", ["{}{a,c}"]),
        (".set.create(S); .set.add_all(S,[c,a]); for (.member(X,S)) { .print(X) }", ["a", "c"]),
        (".set.create(S); .set.add_all(S,[c,a]); .member(c,S); .print(yes)", ["yes"]),
        (".set.create(S); .set.add_all(S,[c,a]); .member(x,S); .print(yes)", ["failed ia_failed"]),
        (".set.create(S); .set.create(T); S = T; .print(yes); S == T; .print(yes)", ["yes", "yes"]),
        (
            ".set.create(S); .set.create(T); .set.add(S,1); .set.add(T,1); S == T; "
            ".print(yes); .set.add(T,2); S \\== T; .print(yes2); S = T; .print(no)",
            ["yes", "yes2", "failed constraint_failed"],
        ),
        (".set.create(a); .print(no)", ["failed ia_failed"]),
        (".set.create(S); .set.create(S); .print(no)", ["failed ia_failed"]),
        (".set.create(S); +keep(S); .set.add(S,q); ?keep(T); .print(T); -keep(T); .print(done)", ["{q}", "done"]),
        (
            ".set.create(S); .set.add(S,q); .print(f(S)); .set.add(S,r); .print(f(S)); .print([S])",
            ["f({q})", "f({q,r})", "[{q,r}]"],
        ),
        (".set.create(S); +keep2(S); .set.add(S,q); +keep2(S); .count(keep2(_),N); .print(N)", ["1"]),
        (".set.create(S); .set.add(S,f(X)); X = 1; .print(S)", ["{f(X)}"]),
        (".map.create(M); .map.put(M,b,2); .map.put(M,a,1); .map.put(M,b,3); .print(M)", ["{a->1,b->3}"]),
        (".map.put(M,b,2); .map.get(M,b,V); .print(M,V)", ["{b->2}2"]),
        (".map.create(M); .map.put(M,b,2); .map.get(M,z,V); .print(V)", ["failed ia_failed"]),
        (".map.create(M); .map.put(M,b,2); .map.get(M,z,V,7); .print(V)", ["7"]),
        (
            '.map.create(M); .map.put(M,b,2); .map.put(M,"a",3); '
            ".findall(K,.map.key(M,K),L); .print(L); .findall(K,.map.value(M,K),L2); .print(L2)",
            ['["a",b]', "[3,2]"],
        ),
        (
            ".map.create(M); .map.put(M,b,2); .map.remove(M,b,V); .print(M,V); .map.remove(M,b,W); .print(no)",
            ["{}2", "failed ia_failed"],
        ),
        (
            ".map.create(M); .map.put(M,b,2); .map.key(M,b); .print(yes); .map.value(M,9); .print(no)",
            ["yes", "failed ia_failed"],
        ),
        (
            ".map.create(M); .map.put(M,b,2); .map.copy(M,T); .map.clear(M); .print(M,T); .length(T,N); .print(N)",
            ["{}{b->2}", "1"],
        ),
        (".map.create(M); .map.create(T); M = T; .print(eq)", ["failed constraint_failed"]),
        (".map.create(M); .map.put(M,b,[1]); for (.map.key(M,K)) { .map.get(M,K,V); .print(K,V) }", ["b[1]"]),
        (
            ".queue.create(Q); .queue.add(Q,b); .queue.add(Q,a); .print(Q); .queue.head(Q,H); "
            ".print(H); .queue.remove(Q,R); .print(R); .queue.to_list(Q,L); .print(L)",
            ["[b, a]", "b", "b", "[a]"],
        ),
        (
            ".queue.create(Q,priority); .queue.add_all(Q,[c,z,b,a]); .queue.to_list(Q,L); "
            ".print(L); .queue.remove(Q,X); .queue.remove(Q,Y); .print(X,Y,Q)",
            ["[a,b,c,z]", "ab[c, z]"],
        ),
        (".queue.create(Q); .queue.head(Q,X); .print(no)", ["failed ia_failed"]),
        (".queue.create(Q); .queue.remove(Q,X); .print(no)", ["failed ia_failed"]),
        (
            ".queue.create(Q); .queue.add(Q,1); .queue.copy(Q,T); .queue.clear(Q); "
            ".queue.to_list(T,L); .print(L); .length(Q,N); .print(N)",
            ["[1]", "0"],
        ),
        (".queue.create(Q); .queue.create(T); Q = T; .print(eq)", ["failed constraint_failed"]),
        (".queue.create(Q); .empty(Q); .print(empty)", ["empty"]),
        (".set.create(Q); .empty(Q); .print(empty)", ["empty"]),
        (".set.create(S); .type(S,T); .print(T); .findall(T2,.type(S,T2),L); .print(L)", ["set", "[set,ground]"]),
        (".map.create(S); .findall(T2,.type(S,T2),L); .print(L)", ["[map,ground]"]),
        (".queue.create(S); .findall(T2,.type(S,T2),L); .print(L)", ["[queue,ground]"]),
        (
            ".findall(T2,.type(a,T2),L); .print(L); .findall(T3,.type(3,T3),L3); "
            ".print(L3); .findall(T4,.type([a],T4),L4); .print(L4)",
            ["[atom,literal,ground]", "[number,ground]", "[list,structure,ground]"],
        ),
        (
            '.findall(T2,.type(f(X),T2),L); .print(L); .findall(T3,.type("s",T3),L3); '
            ".print(L3); .findall(T4,.type(Z,T4),L4); .print(L4)",
            ["[literal,structure]", "[string,ground]", "[free]"],
        ),
        (".type({a;b},T); .print(T)", ["literal"]),
        (".set.create(S); .list(S); .print(no)", ["failed ia_failed"]),
        (".set.create(S); .ground(S); .print(ground)", ["ground"]),
        (".set.create(S); .set.add(S,1); .concat([0],S,L); .print(L)", ["failed wrong_arguments"]),
        ('.set.create(S); .set.add(S,1); .concat("x",S,L); .print(L)', ["x{1}"]),
        (".set.create(S); S > 3; .print(gt)", ["gt"]),
        (".set.create(S); !h(S); .print(S)", ["{x}"]),
        (
            ".set.create(S); .set.add(S,a); .send(a,tell,told(S)); .wait(50); ?told(T); .set.add(S,b); .print(T)",
            ["{a,b}"],
        ),
    ],
)
def test_collections_are_as_in_jason(tmp_path: Path, body: str, prints: list[str]) -> None:
    assert prints_of(tmp_path, f"!go. +!go <- {body}. {REST}") == prints


def test_a_set_that_is_endless_to_print_ends_the_run_with_its_plan(tmp_path: Path) -> None:
    with pytest.raises(BdiError, match=r"in plan @_?\w+ \(.*a\.asl:1:"):
        prints_of(tmp_path, "!go. +!go <- .set.create(S); .set.add(S, S); .print(S).")
