"""Colours of AgentSpeak (`asl`) and of project files (`mas2j`) in the documentation, as lexers for Pygments."""

from __future__ import annotations

from typing import ClassVar

from pygments.lexer import RegexLexer, words
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text, Token

_Rules = dict[str, list[object]]
_BLANKS_AND_COMMENTS: list[object] = [
    (r"\s+", Text),
    (r"//.*$", Comment.Single),
    (r"/\*.*?\*/", Comment.Multiline),
    (r'"(?:\\.|[^"\\])*"', String),
]


class AgentSpeakLexer(RegexLexer):
    """AgentSpeak, as Jason writes it: plans with labels, triggers, contexts and bodies; beliefs, rules and goals."""

    name = "AgentSpeak"
    aliases: ClassVar[list[str]] = ["asl"]
    filenames: ClassVar[list[str]] = ["*.asl"]
    tokens: ClassVar[_Rules] = {
        "root": [
            *_BLANKS_AND_COMMENTS,
            (r"@[a-z]\w*", Name.Label),
            (r"(?:(?<=\s)|^)[+-]!{1,2}(?=[a-z~])|(?:(?<=\s)|^)[+-]\?(?=[a-z~])", Keyword),
            (words(("not", "div", "mod"), prefix=r"\b", suffix=r"\b"), Operator.Word),
            (words(("if", "else", "for", "while", "include", "begin", "end"), prefix=r"\b", suffix=r"\b"), Keyword),
            (words(("true", "false", "self"), prefix=r"\b", suffix=r"\b"), Keyword.Constant),
            (r"\.[a-z]\w*(?:\.[a-z]\w*)*", Name.Builtin),
            (r"\b[A-Z_]\w*", Name.Variable),
            (r"\d+(?:\.\d+)?(?:[eE][+-]?\d+)?", Number),
            (r"[a-z]\w*", Name),
            (r"<-|:-|!!|[!?]|[-+]{1,2}|\\==|\\=|==|=\.\.|<=|>=|[<>=&|*/~^]", Operator),
            (r"[()\[\]{}:;,.@#]", Punctuation),
            (r".", Token.Other),
        ]
    }


class ProjectLexer(RegexLexer):
    """A Jason project: the agents of a multi-agent system, and their environment."""

    name = "Jason project"
    aliases: ClassVar[list[str]] = ["mas2j"]
    filenames: ClassVar[list[str]] = ["*.mas2j"]
    tokens: ClassVar[_Rules] = {
        "root": [
            *_BLANKS_AND_COMMENTS,
            (r"\bMAS\b", Keyword),
            (r"\b[A-Za-z]\w*(?=\s*:)", Keyword),
            (r"\d+(?:\.\d+)?", Number),
            (r"[\w./*]+", Name),
            (r"[{}()\[\]:;,=#@]", Punctuation),
            (r".", Token.Other),
        ]
    }
